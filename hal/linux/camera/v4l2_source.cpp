#include "hal/linux/camera/v4l2_source.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <new>

#include "hal/linux/shared_memory.hpp"
#include "hal/linux/socket.hpp"

namespace sinew::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostClients = 16;
constexpr std::size_t kAlign = 64;

template <std::size_t N>
void put_name(char (&to)[N], const std::string& text) {
  std::memcpy(to, text.data(), std::min(text.size(), N - 1));
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

}  // namespace

Result<std::unique_ptr<V4l2Source>> V4l2Source::open(Os& os, const V4l2SourceSpec& spec, const ThreadOptions& thread,
                                                     std::string& why) {
  std::unique_ptr<V4l2Source> source(new V4l2Source(spec));
  if (const Status prepared = source->prepare(why); !prepared) return prepared.error();
  if (const Status listens = source->listen(why); !listens) return listens.error();
  auto started = os.start_thread(thread, [s = source.get()] { s->work(); });
  if (!started) {
    why = "no thread for the camera's socket";
    return started.error();
  }
  source->thread_ = std::move(*started);
  return source;
}

Status V4l2Source::prepare(std::string& why) {
  node_ = spec_.root + "/dev/video" + std::to_string(spec_.number);
  link_ = spec_.root + "/dev/v4l/by-id/" + spec_.by_id;
  const std::size_t row = std::size_t{spec_.width} * msg::bytes_per_pixel(spec_.format);
  if (row == 0 || spec_.height == 0 || spec_.width > msg::kMaxImageWidth || spec_.height > msg::kMaxImageHeight) {
    why = "no such picture: " + std::to_string(spec_.width) + "x" + std::to_string(spec_.height);
    return Error{Errc::bad_argument, "v4l2 source: picture"};
  }
  std::error_code failed;
  fs::create_directories(spec_.root + "/dev/v4l/by-id", failed);
  if (failed) {
    why = spec_.root + "/dev cannot be made: " + failed.message();
    return Error{Errc::io, "v4l2 source: folder"};
  }
  slot_bytes_ = (sizeof(msg::Image) + row * spec_.height + kAlign - 1) / kAlign * kAlign;
  auto memory = create_shared_memory("sinew_camera", slot_bytes_ * (kCableSlots + 1));
  auto bell = stream_pair();
  if (!memory || !bell) {
    why = "no memory for the pictures";
    return memory ? bell.error() : memory.error();
  }
  memory_ = std::move(*memory);
  bell_ = std::move(bell->first), bell_heard_ = std::move(bell->second);
  for (std::uint32_t slot = 0; slot <= kCableSlots; ++slot) {
    auto* image = new (memory_->data() + slot * slot_bytes_) msg::Image;
    image->set_bulk_capacity(static_cast<std::uint32_t>(row * spec_.height));
    if (!image->format_as(spec_.format, spec_.width, spec_.height)) return Error{Errc::bad_argument, "v4l2 source"};
  }
  return {};
}

Status V4l2Source::listen(std::string& why) {
  auto listener = listen_stream("unix:" + node_);
  if (!listener) {
    why = node_ + ": cannot listen there: " + to_string(listener.error().code);
    return listener.error();
  }
  listener_ = std::move(*listener);
  std::error_code failed;
  fs::remove(link_, failed);
  fs::create_symlink("../../video" + std::to_string(spec_.number), link_, failed);
  if (!failed) return {};
  why = link_ + ": " + failed.message();
  return Error{Errc::io, "v4l2 source: link"};
}

V4l2Source::~V4l2Source() {
  stop_.store(true, std::memory_order_release);
  if (bell_) static_cast<void>(bell_->write_now(std::as_bytes(std::span("s", 1))));
  thread_.reset();
  close_all();
}

msg::Image& V4l2Source::image(std::uint32_t slot) noexcept {
  return *std::launder(reinterpret_cast<msg::Image*>(memory_->data() + slot * slot_bytes_));
}

// ---- the world's side

std::span<std::uint8_t> V4l2Source::canvas() noexcept {
  const std::uint32_t free = free_.load(std::memory_order_acquire);
  drawing_ = free == 0 ? kCableSlots : static_cast<std::uint32_t>(std::countr_zero(free));
  msg::Image& picture = image(drawing_);
  return {picture.pixels(), picture.bulk_used()};
}

void V4l2Source::deliver(Time middle, std::uint32_t number) noexcept {
  const std::uint32_t slot = std::exchange(drawing_, kCableSlots);
  if (!streams()) return;
  if (slot == kCableSlots) {
    lost_.add();
    return;
  }
  msg::Image& picture = image(slot);
  picture.stamp = middle;
  picture.frame_number = number;
  free_.fetch_and(~(1u << slot), std::memory_order_relaxed);
  filled_.fetch_or(1u << slot, std::memory_order_release);                // after its pixels; send_filled() acquires
  static_cast<void>(bell_->write_now(std::as_bytes(std::span("f", 1))));  // when the pipe is full, it rings already
}

void V4l2Source::set_plugged(bool plugged) noexcept {
  plugged_.store(plugged, std::memory_order_release);
  static_cast<void>(bell_->write_now(std::as_bytes(std::span("p", 1))));
}

// ---- its own thread

void V4l2Source::work() noexcept {
  using namespace std::chrono_literals;
  while (!stop_.load(std::memory_order_acquire)) {
    const bool plugged = plugged_.load(std::memory_order_acquire);
    std::string why;
    if (!plugged && listener_) close_all();
    if (plugged && !listener_) static_cast<void>(listen(why));  // after a refusal: again in the next round
    send_filled();
    std::vector<Waiting> items{{bell_heard_->handle()}};
    items.push_back({listener_ && clients_.size() < kMostClients ? listener_->handle() : -1});
    for (const auto& client : clients_) items.push_back({client->line->handle()});
    if (!wait_ready(items, 500ms)) continue;
    std::array<std::byte, 64> rings{};
    if (items[0].ready) static_cast<void>(bell_heard_->read_now(rings));
    for (std::size_t i = clients_.size(); i-- > 0;)
      if (items[i + 2].ready && !hear(*clients_[i])) {
        drop(clients_[i].get());
        clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(i));
      }
    if (items[1].ready) welcome();
  }
}

void V4l2Source::welcome() {
  using namespace std::chrono_literals;
  auto line = listener_->accept(0ms);
  if (!line) return;  // unplugged again
  CableHello hello;
  hello.width = spec_.width, hello.height = spec_.height, hello.format = spec_.format;
  hello.slot_bytes = static_cast<std::uint32_t>(slot_bytes_);
  hello.rate_mhz = static_cast<std::uint32_t>(std::lround(spec_.rate_hz * 1000));
  hello.busy = owner_ != nullptr;
  put_name(hello.card, spec_.card);
  put_name(hello.bus_info, spec_.bus_info);
  (*line)->set_patience(100ms);
  if (!(*line)->write_with_memory(bytes_of(hello), *memory_)) return;
  clients_.push_back(std::make_unique<Client>());
  clients_.back()->line = std::move(*line);
}

/// Takes all messages that are there. False: the client has gone, or speaks another language.
bool V4l2Source::hear(Client& client) {
  for (;;) {
    const auto got = client.line->read_now(std::span(client.partial).subspan(client.have));
    if (!got) return false;
    if (*got == 0) return true;
    client.have += *got;
    if (client.have < client.partial.size()) continue;
    client.have = 0;
    CableMessage message;
    std::memcpy(&message, client.partial.data(), sizeof message);
    if (!obey(client, message)) return false;
  }
}

bool V4l2Source::obey(Client& client, const CableMessage& message) {
  const bool owns = owner_ == &client;
  switch (message.word) {
    case CableWord::claim: {
      if (!owner_) owner_ = &client;
      CableMessage answer;
      answer.word = owner_ == &client ? CableWord::granted : CableWord::busy;
      return static_cast<bool>(client.line->write(bytes_of(answer)));
    }
    case CableWord::start:
    case CableWord::stop:
      if (!owns) return false;
      streams_.store(message.word == CableWord::start, std::memory_order_release);
      return true;
    case CableWord::give_back:
      if (!owns || message.slot >= kCableSlots || (lent_ >> message.slot & 1) == 0) return false;
      lent_ &= ~(1u << message.slot);
      free_.fetch_or(1u << message.slot, std::memory_order_release);
      return true;
    case CableWord::granted:
    case CableWord::busy:
    case CableWord::frame:
      break;
  }
  return false;
}

void V4l2Source::send_filled() {
  std::uint32_t filled = filled_.exchange(0, std::memory_order_acquire);
  while (filled != 0) {
    std::uint32_t oldest = static_cast<std::uint32_t>(std::countr_zero(filled));
    for (std::uint32_t slot = oldest + 1; slot < kCableSlots; ++slot)
      if ((filled >> slot & 1) != 0 && image(slot).frame_number < image(oldest).frame_number) oldest = slot;
    filled &= ~(1u << oldest);
    const CableMessage message{CableWord::frame, oldest, image(oldest).frame_number, 0};
    const auto owner = std::find_if(clients_.begin(), clients_.end(), [&](const auto& c) { return c.get() == owner_; });
    if (streams() && owner != clients_.end() && (*owner)->line->write(bytes_of(message))) {
      lent_ |= 1u << oldest;
      sent_.add();
    } else {
      free_.fetch_or(1u << oldest, std::memory_order_release);
    }
  }
}

void V4l2Source::drop(const Client* client) {
  if (owner_ != client) return;
  owner_ = nullptr;
  streams_.store(false, std::memory_order_release);
  free_.fetch_or(std::exchange(lent_, 0), std::memory_order_release);
}

void V4l2Source::close_all() {
  std::error_code gone;
  if (listener_) fs::remove(link_, gone), fs::remove(node_, gone);
  listener_.reset();
  for (const auto& client : clients_) drop(client.get());
  clients_.clear();
}

}  // namespace sinew::hal
