#pragma once
#include <atomic>
#include <memory>
#include <vector>

#include "hal/os.hpp"
#include "hal/result.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {

/// The words on which programs beside the robot sleep: one for each writer of the segment, holding the number of one of
/// its newest commits. They are in memory that others may map read-only, so the robot writes them and never reads them.
/// A thread of ordinary priority rings them (tap::TopicNotifier); for a topic with `wake_outsiders = true` the
/// committing thread itself does, while a program asks for it: docs/decisions/0017-a-writer-may-wake-one-program.md.
/// Thread:  any.
class OutsideBells {
 public:
  /// Errors:  what making shared memory says.
  static hal::Result<std::unique_ptr<OutsideBells>> make(hal::Os& os, std::uint32_t writers);

  const hal::SharedMemory& page() const { return *page_; }
  /// Wakes all that sleep on the writer's word. RT: yes, with one system call.
  void ring(WriterId writer, std::uint32_t number) noexcept;
  /// After a commit of a topic with `wake_outsiders`. RT: yes; without a program that asks for it, one look at a word.
  void committed(WriterId writer, std::uint32_t number) noexcept {
    if (askers_[writer].load(std::memory_order_relaxed) != 0) ring(writer, number);
  }
  /// One program more, or one less, asks to be woken by the committing thread itself.
  void ask(WriterId writer) noexcept { askers_[writer].fetch_add(1, std::memory_order_relaxed); }
  void end_asking(WriterId writer) noexcept { askers_[writer].fetch_sub(1, std::memory_order_relaxed); }

 private:
  OutsideBells(std::unique_ptr<hal::SharedMemory> page, std::uint32_t writers);
  std::unique_ptr<hal::SharedMemory> page_;
  std::vector<std::atomic<std::uint32_t>> askers_;  // by writer; a late look costs one message's wake-up, no message
};

}  // namespace sinew::rt
