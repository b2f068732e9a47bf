#pragma once
#include <string>

#include "hal/clock.hpp"

namespace sinew::app {

// Exit codes of a worker, besides kDone and kNotBegun: another one is wanted, and how it went.
inline constexpr int kNetAnew = 75, kNetFailed = 76;

/// How long a worker may be silent, at least.
inline constexpr hal::Duration kNetHangs = std::chrono::seconds(15);

/// Starts `program --worker --attempt N --beat FD FILE` again and again until a signal comes, or it cannot begin at
/// all. A worker that ends by accident is started again after a pause, longer each time; one that has not called beat()
/// for `patience`, four times that before its first one, is killed first.
int supervise_net(const std::string& program, const std::string& file, hal::Duration patience);

/// A worker's sign that it does not hang, to the process that started it; `fd` as it was told. Thread: any.
void beat(int fd);

}  // namespace sinew::app
