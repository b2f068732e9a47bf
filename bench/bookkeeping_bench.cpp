// The executor's own time per period, beside the modules' steps and the kernel's sleep. Periods follow each other at
// once, because sleeping only moves the clock on.
#include <atomic>
#include <cstring>
#include <thread>

#include "executor_rig.hpp"
#include "hal/platform.hpp"
#include "pairs.hpp"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr int kBatch = 1000;  // periods

/// The kernel, except that sleeping takes no time: the clock jumps, which costs one read of the clock. Reads of the
/// clock cost their real time.
class JumpingOs final : public hal::Os {
 public:
  hal::Time now() const noexcept override { return os_.now() + hal::Duration{ahead_ns_}; }
  void sleep_until(hal::Time t) noexcept override { ahead_ns_ = (t - os_.now()).count(); }
  void wait(hal::WakeWord&, std::uint32_t, hal::Time) noexcept override {}
  void wake(hal::WakeWord&) noexcept override {}
  hal::Duration thread_cpu_time() noexcept override { return os_.thread_cpu_time(); }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions& options,
                                                         std::function<void()> body) override {
    return os_.start_thread(options, std::move(body));
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return os_.shared_memory(name, bytes);
  }
  hal::Status lock_memory() override { return {}; }

 private:
  hal::Os& os_ = hal::system_os();
  std::int64_t ahead_ns_ = 0;  // of the one thread
};

/// Takes the time of every batch of periods.
class Batches final : public rt::RunObserver {
 public:
  explicit Batches(std::size_t count) : want(count) { ns.reserve(count); }
  void completed(const rt::StepRecord& r) noexcept override {
    if (r.module != 0 || ++periods % kBatch != 0 || done.load()) return;
    const hal::Time now = os.now();
    if (before.ns != 0) ns.push_back(static_cast<double>((now - before).count()) / kBatch);
    before = now;
    if (ns.size() == want) done = true;
  }
  hal::Os& os = hal::system_os();
  std::size_t want;
  std::vector<double> ns;
  hal::Time before{};
  std::uint64_t periods = 0;
  std::atomic<bool> done{false};
};

std::vector<double> periods_of(int modules, std::size_t batches) {
  rt::ThreadSpec spec;
  spec.name = "loop";
  spec.period = 1ms;
  spec.priority = 50;  // it never sleeps, but runs far less than a second at a time
  spec.cpus = {0};
  const auto graph = one_thread(spec, modules);
  JumpingOs os;
  Batches watch(batches);
  rt::RealTimeOptions options;
  options.keep_awake = false;
  options.start_delay = 0ms;
  options.runner.observer = &watch;
  rt::RealTimeExecutor executor(*graph, os, options);
  if (!executor.start()) std::exit(2);
  while (!watch.done) std::this_thread::sleep_for(5ms);
  executor.stop();
  return watch.ns;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  using namespace sinew;
  using namespace sinew::bench;
  if (argc == 3 && std::strcmp(argv[1], "--count") == 0) {  // for callgrind
    periods_of(1, std::strtoul(argv[2], nullptr, 10));
    return 0;
  }
  hal::Os& os = hal::system_os();
  std::vector<double> reads;
  for (int i = 0; i < 400; ++i) {
    const hal::Time begin = os.now();
    for (int k = 0; k < kBatch; ++k) keep(os.now());
    reads.push_back(static_cast<double>((os.now() - begin).count()) / kBatch);
  }
  auto one = periods_of(1, 400), four = periods_of(4, 400);
  const double p50 = median(one) - median(reads);  // less the clock read that stands for the kernel's sleep
  const bool good = report_figure("bookkeeping_period", p50, 300, "ns");
  report_figure("bookkeeping_period_p99", quantile(one, 0.99) - median(reads), 0, "ns");
  report_figure("bookkeeping_per_further_module", (median(four) - median(one)) / 3, 0, "ns");
  report_figure("clock_read", median(reads), 0, "ns");
  return good ? 0 : 1;
}
