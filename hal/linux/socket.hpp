#pragma once
// hal::Stream and hal::Listener on Unix sockets and TCP; hal/platform.hpp has the part common to every system.
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "hal/platform.hpp"

namespace sinew::hal {

struct Waiting {
  std::intptr_t handle = -1;  // of a Stream or Listener; negative: never ready
  bool room = false;          // waits for room to write, not for something to read
  bool ready = false;         // the answer; a stream whose peer went away is ready
};
inline constexpr std::size_t kMaxWaiting = 64;

/// Waits until at least one is ready, or `patience` is over. Errors: bad_argument for more than kMaxWaiting; io.
Status wait_ready(std::span<Waiting> items, Duration patience);

/// Both ends of a local connection.
Result<std::pair<std::unique_ptr<Stream>, std::unique_ptr<Stream>>> stream_pair();

}  // namespace sinew::hal
