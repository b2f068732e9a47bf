#pragma once
#include "rt/segment.hpp"

namespace sinew::rt {

/// Reads single messages of one topic by their numbers, from a thread that is none of the graph's: pins one slot at a
/// time, so that nothing it looks at is written meanwhile, and the writer never waits.
/// Thread:  owner.   RT: yes.
class SlotReader {
 public:
  /// `id`: a latest connection of the plan, for this reader alone: its pin is counted there.
  SlotReader(Segment& segment, ConnectionId id);
  /// Null when the slot holds another message by now. What it answers is released by unpin().
  const SlotHeader* pin(std::uint32_t sequence) noexcept;
  void unpin() noexcept { ring_.unpin(&slot_, 1); }

 private:
  TopicRing<StdAtomics> ring_;
  const std::byte* slots_;
  std::size_t stride_;
  std::uint32_t slot_ = 0;
};

}  // namespace sinew::rt
