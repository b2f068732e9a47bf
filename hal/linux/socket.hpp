#pragma once
// hal::Stream and hal::Listener on Unix sockets and TCP; hal/platform.hpp has the part common to every system.
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
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

/// connect_stream(), which also ends, with `timeout`, soon after `leave` is true: it is asked some twenty times a
/// second. The look-up of a host's name is not ended.
Result<std::unique_ptr<Stream>> connect_stream_until(std::string_view endpoint, Duration patience,
                                                     const std::function<bool()>& leave);

/// The numeric address of the peer of a TCP connection, without its port; empty: it has none.
std::string peer_address(const Stream& stream);

/// Both ends of a local connection.
Result<std::pair<std::unique_ptr<Stream>, std::unique_ptr<Stream>>> stream_pair();

}  // namespace sinew::hal
