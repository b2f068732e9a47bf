#include "apps/net/supervisor.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "apps/command/command.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {

using namespace std::chrono_literals;

int supervise_net(const std::string& program, const std::string& file) {
  hal::Os& os = hal::system_os();
  int attempt = 0, accidents = 0;
  while (!hal::stop_requested()) {
    hal::ChildOptions options;
    options.hears_terminal = false;  // we end it
    options.killed_when_we_die = true;
    auto worker = hal::ChildProcess::start({program, "--worker", "--attempt", std::to_string(attempt), file}, options);
    if (!worker) return fail(program + ": " + hal::to_string(worker.error().code));
    const hal::Time begin = os.now();
    std::optional<int> code;
    while (!(code = (*worker)->poll()) &&
           !hal::stop_requested())  // seldom: ChildProcess::wait() looks 500 times a second
      os.sleep_until(os.now() + 100ms);
    if (!code) {
      (*worker)->terminate();
      // After a changed address Cyclone may not end by itself.
      if (!(*worker)->wait(2s)) (*worker)->kill_now();
      break;
    }
    if (*code == kDone || *code == kNotBegun) return *code;
    attempt = *code == kNetFailed ? std::min(attempt + 1, 30) : 0;
    if (*code == kNetAnew || *code == kNetFailed) {
      accidents = 0;
      continue;
    }
    if (os.now() - begin > 10s) accidents = 0;
    const hal::Duration pause = std::min<hal::Duration>(200ms * (1 << std::min(accidents++, 10)), 10s);
    std::fprintf(stderr, "sinew-net: %s; started again in %lld ms\n", hal::describe_exit(*code).c_str(),
                 static_cast<long long>(pause / 1ms));
    for (const hal::Time until = os.now() + pause; os.now() < until && !hal::stop_requested();)
      os.sleep_until(std::min(until, os.now() + 100ms));
  }
  return kDone;
}

}  // namespace sinew::app
