#pragma once
#include <string>

namespace sinew::app {

// Exit codes of a worker, besides kDone and kNotBegun: another one is wanted, and how it went.
inline constexpr int kNetAnew = 75, kNetFailed = 76, kNetHung = 77;

/// Starts `program --worker --attempt N FILE` again and again until a signal comes, or it cannot begin at all. A worker
/// that ends by accident is started again after a pause, longer each time.
int supervise_net(const std::string& program, const std::string& file);

}  // namespace sinew::app
