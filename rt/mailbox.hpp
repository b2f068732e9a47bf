#pragma once
// The way into a running graph thread: a bounded mailbox that it empties between two cycles.
#include <atomic>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "hal/result.hpp"
#include "hal/wide.hpp"

namespace sinew::rt {

/// A request to a running graph thread. It carries no strings: assigning one could allocate.
struct Request {
  enum class Kind : std::uint8_t { set_param, enable, disable, set_period, arm, disarm, message };
  Kind kind = Kind::set_param;
  std::uint32_t thread = 0;                        // of the graph
  std::uint32_t module = 0;                        // of the graph; set_period: unused
  std::uint32_t index = 0;                         // set_param: in the module's declaration; message: its staged place
  std::variant<bool, std::int64_t, double> value;  // set_param; set_period: nanoseconds
};

/// What became of a request.
struct Effect {
  std::uint32_t step = 0;  // the module's first step with it; set_period: the thread's cycle, counted from the start
  bool refused = false;    // it was taken before that step, and changed nothing
  bool operator==(const Effect&) const = default;
};

/// Many posters, one taker; posts are taken in the order in which they were accepted.
/// Source:  the bounded queue of D. Vyukov (1024cores.net, 2010): each cell carries the number of the post that may use
///          it next; here with one taker.
class Mailbox {
 public:
  explicit Mailbox(std::uint32_t capacity = 64);  // a power of two, at least 2
  /// Thread:  any.   RT: yes, but may repeat while others post.
  /// Errors:  busy when the mailbox is full. The ticket asks effect() later.
  hal::Result<std::uint32_t> post(const Request& request) noexcept;
  /// The next request; null when there is none. Valid until done().
  /// Thread:  the taker.   RT: yes.
  const Request* take() noexcept;
  /// Finishes the request of take().
  void done(const Effect& effect) noexcept;
  /// Nothing while the request waits, or once a mailbox full of later requests is done.
  /// Thread:  any.
  std::optional<Effect> effect(std::uint32_t ticket) const noexcept;

 private:
  struct Cell {
    std::atomic<std::uint32_t> turn;  // acquire/release: hands `request` between poster and taker
    Request request;
    // Of the last request that was done: ticket << 32 | step; the ticket's lowest bit, which the cell implies, is
    // `refused` instead. One number, so that it is read whole.
    hal::Wide<std::uint64_t> done;
  };
  std::vector<Cell> cells_;
  const std::uint32_t mask_;
  std::atomic<std::uint32_t> next_post_{0};
  std::uint32_t next_take_ = 0;  // the taker's own
};

}  // namespace sinew::rt
