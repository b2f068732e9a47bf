// How late a 1 kHz thread is: the real-time executor beside a bare clock_nanosleep loop and cyclictest, in turns, on an
// idle and on a loaded machine; then the precise wake-up, what it costs, and its floor: a bare loop that wakes up 300
// us early and looks at the clock.
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>

#include <atomic>
#include <cstring>
#include <thread>

#include "executor_rig.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"
#include "pairs.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr int kWindow = 400;  // wake-ups in a batch
constexpr int kPriority = 80;

std::vector<int> last_cpu() { return {static_cast<int>(hal::usable_cpus()) - 1}; }

class Lateness final : public rt::RunObserver {
 public:
  Lateness() { us.reserve(kWindow); }
  void completed(const rt::StepRecord& r) noexcept override {
    if (us.size() == us.capacity()) return done.store(true, std::memory_order_release);
    us.push_back(static_cast<double>((r.now - r.release).count()) * 1e-3);
  }
  std::vector<double> us;
  std::atomic<bool> done{false};
};

struct Window {
  std::vector<double> late_us;
  double cpu_percent = 0;
};

double cpu_s() {
  rusage r{};
  getrusage(RUSAGE_SELF, &r);
  return static_cast<double>(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
         static_cast<double>(r.ru_utime.tv_usec + r.ru_stime.tv_usec) * 1e-6;
}

Window ours(bool precise) {
  rt::ThreadSpec spec;
  spec.name = "loop";
  spec.priority = kPriority;
  spec.period = 1ms;
  spec.cpus = last_cpu();
  spec.precise = precise;
  const auto graph = one_thread(spec);
  hal::Os& os = hal::system_os();
  Lateness lateness;
  rt::RealTimeOptions options;
  options.runner.observer = &lateness;
  options.lock_memory = false;  // the whole program's memory is locked already
  options.start_delay = 2ms;
  rt::RealTimeExecutor executor(*graph, os, options);
  if (!executor.start()) std::exit(2);
  for (const auto& line : executor.shortfalls()) std::printf("not as meant: %s\n", line.c_str());
  const double cpu = cpu_s();
  const hal::Time begin = os.now();
  while (!lateness.done.load(std::memory_order_acquire)) os.sleep_until(os.now() + 100ms);
  const double share = 100 * (cpu_s() - cpu) / msg::seconds(os.now() - begin);
  executor.stop();
  return {std::move(lateness.us), share};
}

/// `look` is how long before a release the loop wakes up and begins to look at the clock.
std::vector<double> bare(hal::Duration look = {}) {
  std::vector<double> us;
  us.reserve(kWindow);
  hal::ThreadOptions options;
  options.name = "bare";
  options.fifo_priority = kPriority;
  options.cpus = last_cpu();
  const auto clock_ns = [] {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  };
  auto thread = hal::system_os().start_thread(options, [&] {
    std::int64_t next = clock_ns() + 2'000'000;
    for (int i = 0; i < kWindow; ++i, next += 1'000'000) {
      const std::int64_t wake = next - look.count();
      const timespec t{wake / 1'000'000'000, wake % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
      std::int64_t now = clock_ns();
      while (now < next) now = clock_ns();
      us.push_back(static_cast<double>(now - next) * 1e-3);
    }
  });
  if (!thread) std::exit(2);
  (*thread)->join();
  return us;
}

/// As many wake-ups as the other two; empty where the program is not installed.
std::vector<double> cyclictest() {
  const std::string command = "cyclictest -q -m -t1 -h4000 -i1000 -p" + std::to_string(kPriority) + " -l" +
                              std::to_string(kWindow) + " -a" + std::to_string(last_cpu()[0]) + " 2>/dev/null";
  std::vector<double> us;
  std::FILE* out = ::popen(command.c_str(), "r");
  if (!out) return us;
  char line[256];
  while (std::fgets(line, sizeof(line), out)) {
    unsigned late = 0, count = 0;
    if (line[0] != '#' && std::sscanf(line, "%u %u", &late, &count) == 2)
      us.insert(us.end(), count, static_cast<double>(late) + 0.5);  // cyclictest gives whole microseconds
  }
  ::pclose(out);
  return us;
}

/// Two ordinary threads that keep both cores and the memory busy.
class Load {
 public:
  Load() {
    for (int i = 0; i < 2; ++i)
      threads_.emplace_back([this] {
        std::vector<char> a(16 << 20, 1), b(16 << 20);
        while (!stop_.load()) {
          std::memcpy(b.data(), a.data(), a.size());
          keep(b[0]);
        }
      });
  }
  ~Load() {
    stop_ = true;
    for (auto& t : threads_) t.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

bool measure(const std::string& machine, int pairs) {
  Pairs loops, precise_loops;
  std::vector<double> others, precise_us, precise_cpu, loop_cpu;
  for (int i = 0; i < pairs; ++i) {
    Window window;
    std::vector<double> floor;
    if (i % 2 == 0)
      window = ours(false), floor = bare();
    else
      floor = bare(), window = ours(false);
    loops.add(std::move(window.late_us), std::move(floor));
    loop_cpu.push_back(window.cpu_percent);
    const auto other = cyclictest();
    others.insert(others.end(), other.begin(), other.end());
    Window precise = ours(true);
    precise_us.insert(precise_us.end(), precise.late_us.begin(), precise.late_us.end());
    precise_cpu.push_back(precise.cpu_percent);
    precise_loops.add(std::move(precise.late_us), bare(300us));
  }
  bool good = report(("wakeup_" + machine).c_str(), loops.ratio(), 1.05);
  if (others.empty())
    std::printf("%-34s not installed\n", "  cyclictest");
  else
    std::printf("%-34s p50 %.1f us, p99 %.1f us\n", "  cyclictest", median(others), quantile(others, 0.99));
  good &= report_figure(("precise_" + machine + "_p50").c_str(), median(precise_us), 0.5, "us");
  report_figure(("precise_" + machine + "_p99").c_str(), quantile(precise_us, 0.99), 0, "us");
  report(("precise_" + machine + "_beside_bare").c_str(), precise_loops.ratio(), 0);
  if (machine == "idle") {  // else it includes the load's own time
    good &= report_figure("precise_idle_processor", median(precise_cpu), 6, "% of a core");
    report_figure("wakeup_idle_processor", median(loop_cpu), 0, "% of a core");
  }
  return good;
}

int run(int pairs) {
  mlockall(MCL_CURRENT | MCL_FUTURE);
  const auto awake = hal::system_os().keep_awake();  // for the bare loop too
  bool good = measure("idle", pairs);
  const Load load;
  return measure("loaded", pairs) && good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::run(std::max(15, argc > 1 ? std::atoi(argv[1]) : 15)); }
