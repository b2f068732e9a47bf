#pragma once
// hal::Stream and hal::Listener on Unix sockets and TCP.
// Endpoints are written "unix:PATH" or "tcp:HOST:PORT" ("tcp:[::1]:4560" for IPv6); text with a '/' and without a
// prefix is a path, HOST:PORT without a prefix is TCP.
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "hal/stream.hpp"

namespace sinew::hal {

/// Tries until somebody listens there or `patience` is over (the peer may still be starting).
/// Errors:  bad_argument for an endpoint that cannot be read; not_found when the host is unknown or the file does not
///          exist, closed when nobody listens there (the last try's reason); denied, io.
Result<std::unique_ptr<Stream>> connect_stream(std::string_view endpoint, Duration patience);

/// Unix: mode 0600, and a file left behind by a dead process is replaced. TCP: port 0 lets the system choose.
/// Errors:  bad_argument; busy when somebody listens there already; denied, io.
Result<std::unique_ptr<Listener>> listen_stream(std::string_view endpoint);

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
