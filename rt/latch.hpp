#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "rt/port.hpp"
#include "rt/segment.hpp"

namespace sinew::rt {

/// The reader's side of one module: gives all its input ports one consistent set of messages for a step. Ports on
/// outputs of one writer all see the same commit of it.
/// Thread:  owner for construction and bind(), then executor.
/// RT:      yes, after bind(): no allocation, lock, copy or system call. latch() starts again only when a writer of
///          higher priority made so many commits meanwhile that its slots or records came round.
class Latch {
 public:
  explicit Latch(Segment& segment);
  Latch(const Latch&) = delete;
  Latch& operator=(const Latch&) = delete;
  ~Latch();

  /// Connects an input port with its connection. Configure only. A queue sees messages published before its first
  /// latch as pending, bounded by its depth.
  /// `carried_chains`: bit c: the origin of chain c goes on through this port.
  /// `expires`: a latest port does not hold a message whose stamp is longer ago.
  void bind(InputBase& input, ConnectionId id, Duration max_age = Duration{INT64_MAX},
            std::uint32_t carried_chains = ~0U, Duration expires = Duration{INT64_MAX});

  /// Fills the ports from the newest commit of each writer. `now`: the step's.
  void latch(Time now = {}) noexcept;
  /// Empties the ports; queues have consumed what they held. Every latch() is followed by one release().
  void release() noexcept;

  /// Per chain the oldest origin among the messages held now by ports that carry it; kNoOrigin where there is none.
  void merge_origins(std::int64_t (&oldest_ns)[kMaxChains]) const noexcept;

 private:
  struct Port;
  struct Group;  // the ports on outputs of one writer
  struct Near;   // a latest port on an output of the same thread

  /// A latest port whose message may be too old.
  struct Expiry {
    InputBase* input;
    Duration expires;
  };

  void take_groups() noexcept;
  void expire(Time now) noexcept;

  Segment& segment_;
  std::vector<Group> groups_;
  std::vector<Near> near_;
  std::vector<Expiry> expiring_;
};

}  // namespace sinew::rt
