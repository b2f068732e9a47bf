#include "rt/external_source.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace sinew::rt {

struct ExternalSource::Port : OutputBase {
  explicit Port(const Topic& t) : topic(t) {
    for (const msg::FieldInfo& f : t.type->fields)
      if (f.name == "stamp" && f.kind == msg::Kind::i64 && !f.is_array) stamp_at = static_cast<int>(f.offset);
  }
  std::byte* loan() { return static_cast<std::byte*>(loan_erased()); }

  Topic topic;
  int stamp_at = -1;  // -1: the type has none
};

ExternalSource::ExternalSource(const std::vector<Topic>& topics) : places_(kRoom) {
  std::size_t largest = 0;
  for (const Topic& t : topics) {
    ports_.push_back(std::make_unique<Port>(t));
    largest = std::max<std::size_t>(largest, t.type->size);
  }
  for (Place& place : places_) place.bytes.resize(largest);
  taken_.reserve(kRoom);
}

ExternalSource::~ExternalSource() = default;

void ExternalSource::declare(Declaration& d) {
  for (const auto& p : ports_)
    d.ports.push_back({p->topic.port, Declaration::PortKind::output, p->topic.type, nullptr, p.get(), 0, kRoom});
}

StepStatus ExternalSource::step(const Step& step) noexcept {
  for (const std::uint32_t number : taken_) {
    const Place& place = places_[number];
    Port& port = *ports_[place.port];
    std::byte* message = port.loan();
    std::memcpy(message, place.bytes.data(), port.topic.type->size);
    if (port.stamp_at >= 0) std::memcpy(message + port.stamp_at, &step.now, sizeof step.now);
    unstage(number);
  }
  taken_.clear();
  return StepStatus::ok;
}

hal::Result<std::uint32_t> ExternalSource::stage(std::uint32_t port, std::span<const std::byte> message) noexcept {
  std::uint32_t free = free_.load(std::memory_order_relaxed);
  for (;;) {
    if (free == 0) return hal::Error{hal::Errc::busy, "external messages wait", kRoom};
    const auto number = static_cast<std::uint32_t>(std::countr_zero(free));
    if (!free_.compare_exchange_weak(free, free & ~(1u << number), std::memory_order_acquire,
                                     std::memory_order_relaxed))
      continue;
    places_[number].port = port;
    std::memcpy(places_[number].bytes.data(), message.data(), message.size());
    return number;
  }
}

void ExternalSource::unstage(std::uint32_t place) noexcept { free_.fetch_or(1u << place, std::memory_order_release); }

std::span<const std::byte> ExternalSource::message_of(std::uint32_t place) const {
  return std::span(places_[place].bytes).first(ports_[places_[place].port]->topic.type->size);
}

void ExternalSource::take(std::uint32_t place) noexcept { taken_.push_back(place); }

}  // namespace sinew::rt
