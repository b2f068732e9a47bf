#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "rt/port.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {

/// What the executor stamps on every message of one commit.
struct CommitInfo {
  Time now;  // commit instant
  std::int64_t origin_ns[kMaxChains] = {kNoOrigin.ns, kNoOrigin.ns, kNoOrigin.ns, kNoOrigin.ns,
                                        kNoOrigin.ns, kNoOrigin.ns, kNoOrigin.ns, kNoOrigin.ns};
};

/// The writer's side of one module: loans its output slots and makes them visible together.
/// Thread:  owner for construction and bind(), then executor.
/// RT:      yes, after construction: no allocation, lock, copy or system call; never waits for a reader.
/// Errors:  running out of slots aborts: SegmentPlan counted wrongly, or a reader pins more than was planned.
class Commit {
 public:
  Commit(Segment& segment, WriterId writer);
  Commit(const Commit&) = delete;
  Commit& operator=(const Commit&) = delete;
  ~Commit();

  /// Connects a port of the module with one output of the writer. Configure only.
  void bind(OutputBase& port, std::uint32_t output);

  /// A slot of the writer with every field at its default. Null when the burst is used up.
  void* try_loan(std::uint32_t output) noexcept;
  /// Takes the newest loan back. False when there is none.
  bool cancel(std::uint32_t output) noexcept;
  std::uint32_t loans(std::uint32_t output) const noexcept;
  std::uint32_t held(std::uint32_t output) const noexcept;

  /// Publishes all loans as one commit. Answers which outputs got messages: bit i is output i. Without loans nothing
  /// happens, and the commit number stays.
  std::uint32_t commit(const CommitInfo& info) noexcept;
  /// Gives all loans back; their sequence numbers are used by the next commit.
  void discard() noexcept;

  /// What the last commit() published on an output, oldest first; empty after discard(). Valid until the next loan.
  std::span<const SlotHeader* const> committed(std::uint32_t output) const noexcept;
  std::uint32_t number() const noexcept { return number_; }
  TopicId topic(std::uint32_t output) const noexcept;

 private:
  [[gnu::noinline]] std::uint32_t commit_any(const CommitInfo& info) noexcept;

  CommitLog<StdAtomics> log_;
  std::uint32_t number_ = 0;
  std::uint32_t committed_ = 0;  // bit i: the last commit had messages on output i
  std::uint32_t output_count_ = 0;
  std::unique_ptr<CommitOutput[]> outputs_;
};

}  // namespace sinew::rt
