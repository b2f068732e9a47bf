// A message handed to another thread on the same core and back: topics and the executor's trigger beside a bare futex
// with a shared slot. One-way times are half a round trip.
#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <memory>

#include "hal/platform.hpp"
#include "handover_topics.hpp"
#include "pairs.hpp"
#include "rt/exec/trigger.hpp"

namespace sinew::bench {
namespace {

constexpr int kRoundTrips = 300;
constexpr std::int64_t kStop = -1;

/// The machine's limit: a counter to sleep on and the slot itself; it enters the kernel only for a sleeper.
template <class M>
struct FutexLane {
  alignas(64) std::atomic<std::uint32_t> word{0}, sleeping{0};
  std::unique_ptr<std::byte[]> memory = std::make_unique<std::byte[]>(sizeof(M) + kFrameBytes);
  std::uint32_t seen = 0;

  M& slot() { return *reinterpret_cast<M*>(memory.get()); }
  static void futex(std::atomic<std::uint32_t>& w, int op, std::uint32_t v) {
    syscall(SYS_futex, &w, op | FUTEX_PRIVATE_FLAG, v, nullptr, nullptr, 0);
  }
  void send(std::int64_t n) {
    mark(slot(), n);
    word.store(word.load(std::memory_order_relaxed) + 1, std::memory_order_seq_cst);
    if (sleeping.load(std::memory_order_seq_cst)) futex(word, FUTEX_WAKE, 1);
  }
  bool receive(std::int64_t n) {
    while (word.load(std::memory_order_acquire) == seen) {
      sleeping.store(1, std::memory_order_seq_cst);
      futex(word, FUTEX_WAIT, seen);
      sleeping.store(0, std::memory_order_relaxed);
    }
    ++seen;
    return marked(slot(), n);
  }
  std::int64_t newest() { return slot().stamp.ns; }
};

template <class M>
struct TopicLane {
  hal::Os& os = hal::system_os();
  Topic<M> topic{false};
  rt::Trigger trigger{os};

  void send(std::int64_t n) {
    const msg::Time now = os.now();
    topic.write(n, now);
    trigger.fire(now);
  }
  bool receive(std::int64_t n) {
    trigger.wait(hal::kNever);
    trigger.take();
    return topic.read(n);
  }
};

/// Two lanes and a thread that answers; all on one core.
template <class Lane>
struct PingPong {
  Lane there, back;
  std::atomic<bool> stop{false};
  bool good = true, echo_good = true;
  std::int64_t n = 0;
  hal::Os& os = hal::system_os();
  std::vector<double> single_us;  // every round trip
  std::unique_ptr<hal::Thread> echo;

  explicit PingPong(const hal::ThreadOptions& options) {
    single_us.reserve(1 << 20);
    auto thread = hal::system_os().start_thread(options, [this] {
      for (std::int64_t i = 1;; ++i) {
        const bool whole = there.receive(i);
        if (stop) return;
        echo_good &= whole;
        back.send(i);
      }
    });
    if (!thread) std::exit(2);
    echo = std::move(*thread);
  }
  ~PingPong() {
    stop = true;
    there.send(kStop);
    echo->join();
  }
  void run() {
    std::int64_t before = os.now().ns;
    for (int i = 0; i < kRoundTrips; ++i) {
      there.send(++n);
      good &= back.receive(n);
      const std::int64_t now = os.now().ns;
      single_us.push_back(static_cast<double>(now - before) * 1e-3);
      before = now;
    }
  }
};

template <class M>
bool measure(const char* name, const hal::ThreadOptions& options, int pairs, double goal) {
  PingPong<TopicLane<M>> ours(options);
  PingPong<FutexLane<M>> floor(options);
  Ratio r = alternate(
      pairs, 10, [&] { ours.run(); }, [&] { floor.run(); });
  const bool whole = ours.good && ours.echo_good && floor.good && floor.echo_good;
  if (!whole) std::printf("%s: a message was not what was written\n", name);
  r = r.times(1.0 / kRoundTrips);
  r.ours_p99_us = quantile(ours.single_us, 0.99), r.floor_p99_us = quantile(floor.single_us, 0.99);
  return report(name, r.times(0.5), goal) && whole;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  using namespace sinew;
  using namespace sinew::bench;
  const int pairs = std::max(15, argc > 1 ? std::atoi(argv[1]) : 25);
  hal::ThreadOptions options;
  options.name = "bench";
  options.fifo_priority = 50;
  options.cpus = {0};
  bool good = true;
  // The measuring thread is one of the two threads, so it runs with the same options.
  auto body = hal::system_os().start_thread(options, [&] {
    good &= measure<Small>("handover_one_core_64", options, pairs, 1.15);
    good &= measure<msg::Image>("handover_one_core_921600", options, pairs, 1.15);
  });
  if (!body) return 2;
  (*body)->join();
  if (!(*body)->shortfall().empty()) std::printf("not as meant: %s\n", (*body)->shortfall().c_str());
  return good ? 0 : 1;
}
