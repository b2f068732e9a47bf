#pragma once
// Ports: what a module holds to read and write messages. Declared in Module::declare(), bound by the robot file, filled
// by the executor before a step and emptied after it. A reference or pointer taken from a port ends with the step.
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>

#include "msg/describe.hpp"
#include "msg/time.hpp"

namespace sinew::rt {

using msg::Duration;
using msg::Time;

inline constexpr std::size_t kMaxChains = 8;
inline constexpr Time kNoOrigin{INT64_MAX};

/// In front of every message in its slot. Written by the writer before the commit, read-only afterwards.
struct alignas(64) SlotHeader {
  std::uint32_t sequence = 0;               // of the topic; compare by signed difference
  std::uint32_t commit = 0;                 // number of the commit that published it
  Time stamp;                               // copy of the message's `stamp`
  Time published;                           // commit instant on the executor's clock
  std::int64_t origin_ns[kMaxChains] = {};  // per chain: oldest source stamp that went in; kNoOrigin if none
  std::uint32_t slot = 0;                   // this slot's index in its topic; written once, before the start
  std::uint32_t reserved[9] = {};

  const void* message() const { return this + 1; }
  void* message() { return this + 1; }
};
static_assert(sizeof(SlotHeader) == 128);

/// The messages that one input port holds for one step. Filled by the latch, or from a record.
class InputBase {
 public:
  std::size_t size() const { return count_; }
  /// Messages of this connection lost to a full queue since the last step / since the start.
  std::uint32_t dropped() const { return dropped_; }
  std::uint64_t dropped_total() const { return dropped_total_; }
  const SlotHeader* header(std::size_t i) const { return slots_[i]; }
  /// Latest ports: the message is another one than in the previous step of this module.
  bool updated() const { return updated_; }

 protected:
  friend class Latch;
  friend class SavedState;
  friend class StepAgain;
  /// Per chain in `carried_chains` the oldest origin of what is held and of what `oldest_ns` has.
  void merge_origins(std::uint32_t carried_chains, std::int64_t (&oldest_ns)[kMaxChains]) const noexcept;

  const SlotHeader** slots_ = nullptr;  // room for the depth, oldest first
  std::uint32_t count_ = 0;
  std::uint32_t dropped_ = 0;
  std::uint64_t dropped_total_ = 0;
  bool updated_ = false;
  Duration max_age_{INT64_MAX};
};

/// A *latest* port: state. Holds the newest message of its topic, or none.
template <msg::Described M>
class In : public InputBase {
 public:
  using Message = M;
  /// The newest message, however old; null before the first.
  const M* get() const { return count_ ? static_cast<const M*>(slots_[0]->message()) : nullptr; }
  /// The newest message if its stamp is at most max_age (of the declaration) before `now`, else null.
  const M* fresh(Time now) const {
    return count_ && now - slots_[0]->stamp <= max_age_ ? static_cast<const M*>(slots_[0]->message()) : nullptr;
  }
};

/// A *latest* port for messages of whatever type its topic has.
class AnyIn : public InputBase {
 public:
  /// Null until the graph has bound it.
  const msg::TypeInfo* type() const { return type_; }
  const void* get() const { return count_ ? slots_[0]->message() : nullptr; }

 private:
  friend class Graph;
  const msg::TypeInfo* type_ = nullptr;
};

/// A *queue* port: events since the last step, oldest first, bounded by its depth.
template <msg::Described M>
class InQueue : public InputBase {
 public:
  using Message = M;
  const M& operator[](std::size_t i) const { return *static_cast<const M*>(slots_[i]->message()); }
  bool empty() const { return count_ == 0; }
  const M& back() const { return (*this)[count_ - 1]; }

  class Iterator {
   public:
    explicit Iterator(const SlotHeader* const* at) : at_(at) {}
    const M& operator*() const { return *static_cast<const M*>((*at_)->message()); }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator==(const Iterator&) const = default;

   private:
    const SlotHeader* const* at_;
  };
  Iterator begin() const { return Iterator(slots_); }
  Iterator end() const { return Iterator(slots_ + count_); }
};

class Commit;  // rt/commit.hpp: the writer's side of one module
struct CommitOutput;

/// The source of an output's loans.
class OutputBase {
 protected:
  friend class Commit;
  void* loan_erased();  // for code that knows the type only at run time: a fresh message, as Out::loan()
  void* claim();        // a slot as it was left; aborts when the burst is exceeded (a bug of the module)
  void* try_claim();    // null when the burst is used up
  void cancel_newest();
  const void* newest_committed() const;
  void* hold_slot();                 // null: as many are held as were asked for
  bool publish_held(void* message);  // false: the burst is used up
  void put_back_held(void* message);

  /// Every field at its default; the bulk stays as it was.
  template <class M>
  M* fresh(void* slot) const {
    M* message = new (slot) M();
    if constexpr (msg::HasBulk<M>) message->set_bulk_capacity(bulk_bytes_);
    return message;
  }

 private:
  CommitOutput* output_ = nullptr;
  std::uint32_t bulk_bytes_ = 0;
};

/// An output. Loaned slots are written in place and become visible together when the step returns ok.
template <msg::Described M>
class Out : public OutputBase {
 public:
  using Message = M;
  /// A fresh message with every field at its default. At most `burst` a step.
  M& loan() { return *fresh<M>(claim()); }
  /// Takes the newest loan of this step back, as if it had not been made.
  void cancel() { cancel_newest(); }
  /// The newest message of the step just committed, null when it published none here. For DriverModule::emit().
  const M* committed() const { return static_cast<const M*>(newest_committed()); }
};

/// An output whose messages have the type of the inputs that read it. At least one input with a type reads it.
class AnyOut : public OutputBase {
 public:
  /// Null until the graph has bound it.
  const msg::TypeInfo* type() const { return type_; }
  /// As Out::loan().
  void* loan() { return loan_erased(); }
  void cancel() { cancel_newest(); }

 private:
  friend class Graph;
  const msg::TypeInfo* type_ = nullptr;
};

/// The raw topic of a driver module: written by collect(), read as a queue by the step() that follows, and by others.
template <msg::Described M>
class Raw : public InQueue<M>, public OutputBase {
 public:
  using Message = M;
  /// Inside collect() only. Null when the burst is used up: leave the rest for the next cycle.
  M* loan() {
    void* slot = try_claim();
    return slot ? this->template fresh<M>(slot) : nullptr;
  }
  void cancel() { cancel_newest(); }

  // Slots that stay with the driver over its steps, for a device that fills them itself: as many as configure() asked
  // for with Setup::hold(). In the hooks of the driver only: a slot that a step kept would be state outside of every
  // record.
  /// A fresh message that is the driver's until it publishes it or puts it back. Null when all are held.
  M* hold() {
    void* slot = hold_slot();
    return slot ? this->template fresh<M>(slot) : nullptr;
  }
  /// Inside collect() only. The next message of this topic, in place of a loan. False when the burst is used up; it is
  /// still held then.
  bool publish(M& held) { return publish_held(&held); }
  void put_back(M& held) { put_back_held(&held); }
};

}  // namespace sinew::rt
