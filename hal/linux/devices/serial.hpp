#pragma once
#include <string>
#include <utility>

#include "hal/connectors.hpp"

namespace sinew::hal {

/// A serial line of the kernel, "/dev/ttyS0", "/dev/serial/by-id/...": raw, eight bits, any bit rate that the driver
/// can do (100000 and 420000 included), held exclusively.
/// Errors:  bad_argument (bit rate 0), not_found, denied, busy (another process holds it), not_supported (no serial
///          line; a bit rate that the driver cannot do; `inverted`, for which Linux has no general way), io; `why` has
///          it in words.
Result<std::unique_ptr<Serial>> open_serial(const SerialSpec& spec, std::string& why);

/// A serial line without hardware: bytes written to `end` come in at the opener of `path`, and the other way round.
/// Destroying `end` unplugs the device. For simulated devices and tests.
struct PseudoSerial {
  std::unique_ptr<Serial> end;
  std::string path;
};
Result<PseudoSerial> make_pseudo_serial();

/// A new named pipe, held open by the returned object, so that it can be written before a reader opens it. It replaces
/// a character device like /dev/iio:deviceN. Its file is removed with it.
/// Errors:  busy when there is something of that name; not_found (folder), denied, io.
Result<std::unique_ptr<Serial>> make_pipe(const std::string& path);

}  // namespace sinew::hal
