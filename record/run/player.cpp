#include "record/run/player.hpp"

#include <algorithm>
#include <cstring>

#include "msg/image.hpp"

namespace sinew::record {
namespace {

constexpr std::uint32_t kRoom = 256, kImageRoom = 8;  // messages that wait; powers of two
constexpr std::uint32_t kBurst = 32;                  // of one topic in one step; the rest follows in the next

std::size_t size_of(const msg::TypeInfo& type, const void* message) {
  return type.size + (type.has_bulk() ? static_cast<const msg::Image*>(message)->bulk_used() : 0);
}

}  // namespace

struct Player::Port : rt::OutputBase {
  void* loan() { return loan_erased(); }
  std::uint32_t loans = 0;  // of this step
};

Player::Player(std::vector<Topic> topics) : topics_(std::move(topics)) {
  std::size_t largest = 0;
  bool images = false;
  for (const Topic& t : topics_) {
    ports_.push_back(std::make_unique<Port>());
    largest = std::max<std::size_t>(largest, t.type->size + t.bulk_bytes);
    images = images || t.bulk_bytes > 0;
  }
  places_.resize(images ? kImageRoom : kRoom);
  for (Place& place : places_) place.bytes.resize(largest);
}

Player::~Player() = default;

void Player::declare(rt::Declaration& d) {
  for (std::size_t i = 0; i < topics_.size(); ++i)
    d.ports.push_back({topics_[i].port, rt::Declaration::PortKind::output, topics_[i].type, nullptr, ports_[i].get(), 0,
                       topics_[i].bulk_bytes > 0 ? 1 : kBurst});
}

Player::Handed Player::hand(std::uint32_t topic, rt::Time due, const void* message) noexcept {
  const Topic& about = topics_[topic];
  const std::size_t bytes = size_of(*about.type, message);
  if (bytes > about.type->size + about.bulk_bytes) return Handed::too_large;
  const std::uint32_t number = handed_.load(std::memory_order_relaxed);
  if (number - said_.load(std::memory_order_acquire) == places_.size()) return Handed::no_room;
  Place& place = places_[number % places_.size()];
  place.due = due;
  place.topic = topic;
  std::memcpy(place.bytes.data(), message, bytes);
  handed_.store(number + 1, std::memory_order_release);
  return Handed::yes;
}

bool Player::idle() const noexcept {
  return handed_.load(std::memory_order_acquire) == said_.load(std::memory_order_acquire);
}

rt::StepStatus Player::step(const rt::Step& step) noexcept {
  for (const auto& port : ports_) port->loans = 0;
  const std::uint32_t handed = handed_.load(std::memory_order_acquire);
  for (std::uint32_t number = said_.load(std::memory_order_relaxed); number != handed; ++number) {
    const Place& place = places_[number % places_.size()];
    const Topic& about = topics_[place.topic];
    Port& port = *ports_[place.topic];
    if (place.due > step.now || port.loans == (about.bulk_bytes > 0 ? 1 : kBurst)) break;
    ++port.loans;
    void* const slot = port.loan();
    if (about.type->has_bulk()) {
      auto& image = *static_cast<msg::Image*>(slot);
      const std::uint32_t capacity = image.capacity_bytes;
      std::memcpy(slot, place.bytes.data(), size_of(*about.type, place.bytes.data()));
      image.capacity_bytes = capacity;  // the slot's own
    } else {
      std::memcpy(slot, place.bytes.data(), about.type->size);
    }
    said_.store(number + 1, std::memory_order_release);
  }
  return rt::StepStatus::ok;
}

}  // namespace sinew::record
