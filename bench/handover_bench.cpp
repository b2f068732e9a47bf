// A message handed over inside one thread (loan, write, commit, latch, read, release) beside a virtual call that does
// the same reading and writing. `handover_bench --count N 64|921600 shared|own` only runs N of them, for callgrind.
#include <cstdlib>
#include <string_view>

#include "hal/platform.hpp"
#include "handover_topics.hpp"
#include "pairs.hpp"

namespace sinew::bench {
namespace {

constexpr int kBatch = 1000;

struct Sink {
  virtual ~Sink() = default;
  virtual void on(const void* message, std::int64_t n) = 0;
};

/// Reads the clock, returns n.
inline std::int64_t now_then(hal::Os& os, std::int64_t n) {
  keep(os.now());
  return n;
}

template <class M>
struct Check final : Sink {
  bool good = true;
  void on(const void* message, std::int64_t n) override { good &= marked(*static_cast<const M*>(message), n); }
};

constexpr double kNoGoal = 0;  // printed for information

/// With the clock, both sides read it once: a read costs as much as many virtual calls and would hide what is measured.
template <class M>
bool measure(const char* name, bool same_thread, bool with_clock, int pairs, double goal) {
  Topic<M> topic(same_thread), floor_topic(true);
  M& floor_message = floor_topic.out.loan();
  Check<M> check;
  Sink* sink = &check;
  hal::Os& os = hal::system_os();
  std::int64_t n = 0;
  bool good = true;
  const auto ours = [&] {
    for (int i = 0; i < kBatch; ++i) {
      ++n;
      topic.write(n, with_clock ? os.now() : msg::Time{n});
      good &= topic.read(n);
    }
  };
  const auto floor = [&] {
    for (int i = 0; i < kBatch; ++i) {
      ++n;
      mark(floor_message, with_clock ? now_then(os, n) : n);
      keep(sink);
      sink->on(&floor_message, n);
      keep(check.good);
    }
  };
  const Ratio r = alternate(pairs, 50, ours, floor);
  if (!good || !check.good) std::printf("%s: a message was not what was written\n", name);
  return report(name, r.times(1000.0 / kBatch), goal, "ns") && good && check.good;
}

/// What one clock read costs, in virtual calls.
void measure_clock(int pairs) {
  hal::Os& os = hal::system_os();
  Small message;
  Check<Small> check;
  Sink* sink = &check;
  std::int64_t n = 0;
  const auto read = [&] {
    for (int i = 0; i < kBatch; ++i) keep(os.now());
  };
  const auto call = [&] {
    for (int i = 0; i < kBatch; ++i) {
      mark(message, ++n);
      keep(sink);
      sink->on(&message, n);
      keep(check.good);
    }
  };
  const Ratio r = alternate(pairs, 50, read, call);
  report("clock_read_alone", r.times(1000.0 / kBatch), kNoGoal, "ns");
}

template <class M>
int count(long n, bool same_thread) {
  Topic<M> topic(same_thread);
  bool good = true;
  for (long i = 1; i <= n; ++i) {
    topic.write(i, msg::Time{i});
    good &= topic.read(i);
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) {
  using namespace sinew;
  using namespace sinew::bench;
  if (argc == 5 && std::string_view(argv[1]) == "--count") {
    const bool own = std::string_view(argv[4]) == "own";
    const long n = std::atol(argv[2]);
    return std::string_view(argv[3]) == "64" ? count<Small>(n, own) : count<msg::Image>(n, own);
  }
  const int pairs = std::max(15, argc > 1 ? std::atoi(argv[1]) : 25);
  bool good = true;
  good &= measure<Small>("handover_thread_64", true, false, pairs, 10);
  good &= measure<msg::Image>("handover_thread_921600", true, false, pairs, 10);
  good &= measure<Small>("handover_thread_clock_64", true, true, pairs, 10);
  good &= measure<msg::Image>("handover_thread_clock_921600", true, true, pairs, 10);
  measure_clock(pairs);
  // As in virtual time, where every reader pins.
  measure<Small>("handover_pinned_64", false, false, pairs, kNoGoal);
  measure<msg::Image>("handover_pinned_921600", false, false, pairs, kNoGoal);
  return good ? 0 : 1;
}
