#pragma once
// The functions that every system provides: hal/linux or hal/wince_stub implements them, whichever is linked as
// sinew::hal_platform.
#include <memory>
#include <string_view>

#include "hal/file.hpp"
#include "hal/os.hpp"
#include "hal/stream.hpp"

namespace sinew::hal {

/// On Linux CLOCK_MONOTONIC, SCHED_FIFO, private futexes, memfd; on Windows those of its calls that CE has.
/// Thread: any.
Os& system_os();

/// Tries until a listener answers there or `patience` is over (the peer may still be starting). "tcp:HOST:PORT"
/// ("tcp:[::1]:4560" for IPv6) everywhere, "unix:PATH" where there are such sockets; text with a '/' and without a
/// prefix is a path, HOST:PORT without a prefix is TCP. The addresses of a host are tried in turn.
/// Errors:  bad_argument for an endpoint that cannot be read; not_found when the host is unknown or the file does not
///          exist, closed when there is no listener (the last try's reason); not_supported; denied, io.
Result<std::unique_ptr<Stream>> connect_stream(std::string_view endpoint, Duration patience);

/// Unix: mode 0600, and a file left behind by a dead process is replaced. TCP: port 0 lets the system choose.
/// Errors:  bad_argument; busy when another listener is there already; not_supported; denied, io.
Result<std::unique_ptr<Listener>> listen_stream(std::string_view endpoint);

}  // namespace sinew::hal
