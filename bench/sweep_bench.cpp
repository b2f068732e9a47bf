// What a sweep's pool of processes takes for a case that does nothing (/bin/true): beside `xargs -P`, which starts the
// same program as often, as many at a time, and reads none of its output. One ratio of the times of two batches a turn.
#include <cstdlib>
#include <string>

#include "apps/sweep/process_pool.hpp"
#include "hal/linux/piped_process.hpp"
#include "hal/linux/process.hpp"
#include "pairs.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr int kCases = 200;
constexpr const char* kNothing = "/bin/true";

[[noreturn]] void give_up(const char* what) {
  std::printf("sweep_bench: %s\n", what);
  std::exit(2);
}

void by_pool(unsigned jobs) {
  sweep::ProcessPool pool(jobs, 60s);
  int given = 0, good = 0;
  pool.run(
      [&]() -> std::optional<sweep::Job> {
        if (given++ == kCases) return std::nullopt;
        return sweep::Job{.argv = {kNothing}};
      },
      [&](std::uint64_t, const sweep::JobResult& result) {
        good += result.code == 0;
        return true;
      });
  if (good != kCases) give_up("a case failed");
}

void by_xargs(unsigned jobs, const std::string& cases) {
  std::string_view left = cases;
  hal::PipedIo io;
  io.input = [&left] { return std::exchange(left, {}); };
  const auto code = hal::run_piped({"xargs", "-P", std::to_string(jobs), "-n", "1", kNothing}, io);
  if (!code || *code != 0) give_up("xargs failed");
}

int run(int pairs) {
  std::string cases;
  for (int i = 0; i < kCases; ++i) cases += std::to_string(i) + "\n";
  const unsigned jobs = hal::usable_cpus();
  const Ratio all = alternate(
      pairs, 1, [&] { by_pool(jobs); }, [&] { by_xargs(jobs, cases); });
  return report("sweep_empty_case", all.times(1.0 / kCases), 1.1) ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::run(std::max(15, argc > 1 ? std::atoi(argv[1]) : 31)); }
