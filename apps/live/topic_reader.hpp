#pragma once
// The messages of one topic of a running robot, in order, read from its memory.
#include <optional>
#include <vector>

#include "apps/live/live_robot.hpp"
#include "hal/os.hpp"

namespace sinew::app {

/// Thread:  owner.
class TopicReader {
 public:
  /// Nothing after printing why: no such topic (with a list), or its memory cannot be read.
  static std::optional<TopicReader> open(LiveRobot& robot, const std::string& topic);

  enum class Got { message, nothing, end };
  /// Waits for the next message, until `deadline`; `end`: the robot ended (after printing that), or Ctrl-C.
  Got next(hal::Time deadline);

  /// Header of the message that next() copied.
  const rt::SlotHeader& header() const { return *reinterpret_cast<const rt::SlotHeader*>(copy_.data()); }
  const void* message() const { return copy_.data() + sizeof(rt::SlotHeader); }
  const tap::Topic& topic() const { return reader_->topics()[index_]; }
  std::uint64_t lost() const { return cursor_.lost; }

 private:
  TopicReader(LiveRobot& robot, const tap::SegmentReader& reader, std::uint32_t index);
  bool take();

  LiveRobot* robot_;
  const tap::SegmentReader* reader_;
  std::uint32_t index_;
  tap::Cursor cursor_;
  std::optional<hal::Time> heard_{};  // when the last message came, or the robot's word that it still runs
  struct alignas(64) Block {
    std::byte bytes[64];
  };
  std::vector<Block> blocks_;
  std::span<std::byte> copy_;
};

}  // namespace sinew::app
