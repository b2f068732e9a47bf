#include "rt/slot_reader.hpp"

namespace sinew::rt {

SlotReader::SlotReader(Segment& segment, ConnectionId id) {
  const TopicId topic = segment.connections_[id].topic;
  const TopicEntry& entry = segment.entry(topic);
  ring_ = segment.ring(topic);
  slots_ = &segment.at<std::byte>(entry.slots);
  stride_ = static_cast<std::size_t>(entry.slot_stride);
}

const SlotHeader* SlotReader::pin(std::uint32_t sequence) noexcept {
  const auto at = [this](std::uint32_t s) { return reinterpret_cast<const SlotHeader*>(slots_ + s * stride_); };
  std::uint32_t held = 0;
  const bool there = ring_.pin(
      sequence, 1, [&at](std::uint32_t s) { return at(s)->sequence; }, &slot_, held);
  return there && held == 1 ? at(slot_) : nullptr;
}

}  // namespace sinew::rt
