#include "rt/external_source.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "math/elementary.hpp"
#include "msg/image.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {
namespace {

template <class Real>
bool all_finite(const std::byte* at, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    Real v;
    std::memcpy(&v, at + i * sizeof v, sizeof v);
    if (!math::is_finite(static_cast<double>(v))) return false;
  }
  return true;
}

bool all_finite(const msg::TypeInfo& type, const std::byte* message) {
  for (const msg::FloatRun& run : type.floats)
    if (run.is_f64 ? !all_finite<double>(message + run.offset, run.count)
                   : !all_finite<float>(message + run.offset, run.count))
      return false;
  return true;
}

}  // namespace

bool OutsideMessage::copy(std::size_t from, std::span<std::byte> into) const noexcept {
  if (memory) return from <= SIZE_MAX - offset && memory->copy(offset + from, into);
  if (from > bytes.size() || into.size() > bytes.size() - from) return false;
  if (!into.empty()) std::memcpy(into.data(), bytes.data() + from, into.size());
  return true;
}

struct ExternalSource::Port : OutputBase {
  explicit Port(const Topic& t) : topic(t) {
    for (const msg::FieldInfo& f : t.type->fields)
      if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array) stamp_at = static_cast<int>(f.offset);
  }
  std::byte* loan() { return static_cast<std::byte*>(loan_erased()); }
  std::byte* hold() { return static_cast<std::byte*>(hold_slot()); }
  bool publish(std::byte* message) { return publish_held(message); }
  bool has_pixels() const { return topic.type->has_bulk(); }
  void set_stamp(std::byte* message, Time stamp) const {
    if (stamp_at >= 0) std::memcpy(message + stamp_at, &stamp, sizeof stamp);
  }
  /// The step's instant in place of a stamp that was not given, and of one that is later than the step.
  void settle_stamp(std::byte* message, Time now) const {
    if (stamp_at < 0) return;
    Time stamp;
    std::memcpy(&stamp, message + stamp_at, sizeof stamp);
    if (stamp == Time{} || stamp > now) set_stamp(message, now);
  }

  Topic topic;
  int stamp_at = -1;           // -1: the type has none
  std::uint32_t capacity = 0;  // bytes for pixels
  Pool held;                   // types with pixels: its places
};

ExternalSource::ExternalSource(const std::vector<Topic>& topics) : places_(kRoom) {
  std::size_t largest = 0;
  for (const Topic& t : topics) {
    ports_.push_back(std::make_unique<Port>(t));
    if (!t.type->has_bulk()) {
      largest = std::max<std::size_t>(largest, t.type->size);
      continue;
    }
    ports_.back()->held.first = static_cast<std::uint32_t>(places_.size());
    for (std::uint32_t i = 0; i < kImageRoom; ++i)
      places_.push_back({static_cast<std::uint32_t>(ports_.size() - 1), nullptr});
  }
  const std::size_t stride = largest / sizeof(std::max_align_t) + 1;
  plain_.resize(kRoom * stride);
  for (std::uint32_t i = 0; i < kRoom; ++i)
    places_[i].message = reinterpret_cast<std::byte*>(plain_.data() + i * stride);
  shared_.free.store((1u << kRoom) - 1, std::memory_order_relaxed);
  taken_.reserve(places_.size());
}

ExternalSource::~ExternalSource() = default;

void ExternalSource::declare(Declaration& d) {
  for (const auto& p : ports_)
    d.ports.push_back({p->topic.port, Declaration::PortKind::output, p->topic.type, nullptr, p.get(), 0,
                       p->has_pixels() ? kImageRoom : kRoom});
}

hal::Status ExternalSource::configure(Setup& setup) {
  for (const auto& p : ports_) {
    if (!p->has_pixels()) continue;
    p->capacity = setup.image_bytes(*p);
    setup.hold(*p, kImageRoom);
  }
  return {};
}

void ExternalSource::bound() noexcept {
  for (const auto& p : ports_) {
    if (!p->has_pixels()) continue;
    for (std::uint32_t i = 0; i < kImageRoom; ++i) places_[p->held.first + i].message = p->hold();
    p->held.free.store((1u << kImageRoom) - 1, std::memory_order_release);
  }
}

StepStatus ExternalSource::step(const Step& step) noexcept {
  for (const std::uint32_t number : taken_) {
    Place& place = places_[number];
    Port& port = *ports_[place.port];
    port.settle_stamp(place.message, step.now);
    if (port.has_pixels()) {
      // As many places as the burst has slots, and a held slot less for each loan: neither can run out.
      if (!port.publish(place.message)) bug("more images than places", port.topic.port);
      place.message = port.hold();
    } else {
      std::memcpy(port.loan(), place.message, port.topic.type->size);
    }
    unstage(number);
  }
  taken_.clear();
  return StepStatus::ok;
}

ExternalSource::Pool& ExternalSource::pool_of(std::uint32_t port) noexcept {
  return ports_[port]->has_pixels() ? ports_[port]->held : shared_;
}

std::uint32_t ExternalSource::room(std::uint32_t port) const { return ports_[port]->has_pixels() ? kImageRoom : kRoom; }

hal::Result<std::uint32_t> ExternalSource::stage(std::uint32_t port, const OutsideMessage& message) noexcept {
  Pool& pool = pool_of(port);
  std::uint32_t free = pool.free.load(std::memory_order_relaxed);
  for (;;) {
    if (free == 0) return hal::Error{hal::Errc::busy, "external messages wait", room(port)};
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(free));
    if (!pool.free.compare_exchange_weak(free, free & ~(1u << bit), std::memory_order_acquire,
                                         std::memory_order_relaxed))
      continue;
    const std::uint32_t number = pool.first + bit;
    places_[number].port = port;
    if (const auto filled = fill(*ports_[port], places_[number], message); !filled) {
      unstage(number);
      return filled.error();
    }
    return number;
  }
}

/// Only the copy is looked at, which nobody else can change.
hal::Status ExternalSource::fill(Port& port, Place& place, const OutsideMessage& message) const noexcept {
  const auto refuse = [](const char* why, std::int64_t detail = 0) {
    return hal::Error{hal::Errc::bad_argument, why, detail};
  };
  const msg::TypeInfo& type = *port.topic.type;
  const std::size_t length = message.length();
  if (length < type.size || length - type.size > port.capacity)
    return refuse("size of the message", static_cast<std::int64_t>(length));
  // Programs that read the slot's earlier message in place: the writer that gave the slot to this thread has passed
  // its fence, and the writes of this thread need one of their own before them.
  StdAtomics::order_before_reuse();
  if (!message.copy(0, {place.message, length}))
    return hal::Error{hal::Errc::bad_data, "the memory is shorter than the message"};
  port.set_stamp(place.message, message.stamp);
  if (!all_finite(type, place.message)) return refuse("not finite");
  if (!port.has_pixels()) return {};
  const std::size_t pixels = length - type.size;
  type.set_bulk_capacity(place.message, port.capacity);
  if (&type != &msg::type_info<msg::Image>()) {
    return type.bulk_used(place.message) <= pixels ? hal::Status{} : refuse("more bulk than came with the message");
  }
  const auto& image = *reinterpret_cast<const msg::Image*>(place.message);
  if (!image.is_whole(pixels)) return refuse("an image whose rows do not fit its bytes");
  if (std::uint64_t{image.width} * image.height > port.topic.image_pixels)
    return refuse("an image with more pixels than the robot file has", port.topic.image_pixels);
  return {};
}

void ExternalSource::unstage(std::uint32_t place) noexcept {
  Pool& pool = pool_of(places_[place].port);
  pool.free.fetch_or(1u << (place - pool.first), std::memory_order_release);
}

std::span<const std::byte> ExternalSource::message_of(std::uint32_t place) const {
  const Place& p = places_[place];
  const msg::TypeInfo& type = *ports_[p.port]->topic.type;
  return {p.message, type.size + (type.has_bulk() ? type.bulk_used(p.message) : 0)};
}

void ExternalSource::take(std::uint32_t place) noexcept { taken_.push_back(place); }

}  // namespace sinew::rt
