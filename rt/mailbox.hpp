#pragma once
// The way into a running graph thread: a bounded mailbox that it empties between two cycles.
#include <atomic>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "hal/result.hpp"

namespace sinew::rt {

/// What may be asked of a running module. Strings are not among it: assigning one could allocate.
struct Request {
  enum class Kind : std::uint8_t { set_param, enable, disable } kind = Kind::set_param;
  std::uint32_t module = 0;  // of the graph
  std::uint32_t param = 0;   // of its declaration
  std::variant<bool, std::int64_t, double> value;
};

/// Many posters, one taker; posts are taken in the order in which they were accepted.
/// Source:  the bounded queue of D. Vyukov (1024cores.net, 2010): each cell carries the number of the post that may use
///          it next; here with one taker.
class Mailbox {
 public:
  explicit Mailbox(std::uint32_t capacity = 64);  // a power of two
  /// Thread:  any.   RT: yes, but may repeat while others post.
  /// Errors:  busy when the mailbox is full. The ticket asks taken_at() later.
  hal::Result<std::uint32_t> post(const Request& request) noexcept;
  /// The next request; null when there is none. Valid until done().
  /// Thread:  the taker.   RT: yes.
  const Request* take() noexcept;
  /// Finishes the request of take(): it took effect from this step of its module on.
  void done(std::uint32_t step) noexcept;
  /// The step from which a request took effect; nothing while it waits, or when a mailbox full of later ones was done.
  /// Thread:  any.
  std::optional<std::uint32_t> taken_at(std::uint32_t ticket) const noexcept;

 private:
  struct Cell {
    std::atomic<std::uint32_t> turn;  // acquire/release: hands `request` between poster and taker
    Request request;
    std::atomic<std::uint64_t> done{0};  // ticket << 32 | step, of the last request that was done
  };
  std::vector<Cell> cells_;
  const std::uint32_t mask_;
  std::atomic<std::uint32_t> next_post_{0};
  std::uint32_t next_take_ = 0;  // the taker's own
};

}  // namespace sinew::rt
