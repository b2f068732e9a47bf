#pragma once
#include <string>
#include <string_view>

#include "hal/result.hpp"

namespace sinew::hal {

/// Advice for a user whose device cannot be opened.
struct OpenHint {
  std::string_view absent;  // the remedy for a missing device: "load its module: modprobe i2c-dev"
};

/// Turns errno of open() or the first ioctl into an Error, and into words: path, reason, who may open it, what to do.
/// Errors:  not_found, denied, busy, not_supported, io.
Error open_error(const std::string& path, int why_errno, const OpenHint& hint, const char* where, std::string& why);
/// "no such file or directory" for ENOENT, in the C library's words. Thread: any.
std::string errno_text(int why_errno);

}  // namespace sinew::hal
