// What recording costs the thread that takes the steps: a module that reads one topic and writes another of 64 bytes,
// with its steps recorded and not. The recorder reads the log between batches: that time is not the writer's.
#include <cstdlib>
#include <cstring>

#include "pairs.hpp"
#include "record/run/step_log.hpp"
#include "rt/exec/runner.hpp"

namespace sinew::bench {

struct Sample {
  msg::Time stamp;
  std::array<double, 7> value{};
};

}  // namespace sinew::bench

namespace sinew::msg {

template <>
struct Description<bench::Sample> {
  static constexpr std::string_view name = "Sample", doc = "64 bytes.";
  static constexpr auto fields = describe(field<&bench::Sample::stamp>("ns"), field<&bench::Sample::value>("1"));
};

}  // namespace sinew::msg

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr double kGoal_ns = 100;
constexpr int kSteps = 200;  // in a batch

class Source final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("out", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    out_.loan().stamp = step.now;
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<Sample> out_;
};

class Through final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("in", in_);
    d.out("out", out_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    Sample& out = out_.loan();
    out = *in_.get();
    out.stamp = step.now;
    return rt::StepStatus::ok;
  }

 private:
  rt::In<Sample> in_;
  rt::Out<Sample> out_;
};

struct Nobody final : record::StepLog::Visitor {
  void step(const record::LoggedStep&) override { ++steps; }
  void request(const record::LoggedRequest&) override {}
  void state(const record::LoggedState&) override {}
  void lost(std::uint32_t, std::uint64_t entries) override { lost_entries += entries; }
  std::uint64_t steps = 0, lost_entries = 0;
};

/// The two modules in two threads, the way most topics are read.
struct Robot {
  explicit Robot(bool recorded) {
    rt::GraphSpec spec;
    spec.robot = "bench";
    rt::ModuleTypes types;
    types.add<Source>("bench::Source");
    types.add<Through>("bench::Through");
    for (const char* name : {"source", "through"}) {
      rt::ModuleSpec m;
      m.name = name;
      m.type = name[0] == 's' ? "bench::Source" : "bench::Through";
      if (name[0] == 't') m.in["in"] = {"source.out", 0};
      rt::ThreadSpec t;
      t.name = name;
      t.priority = 1;
      t.period = 1ms;
      t.order.push_back({name, 0});
      spec.modules.push_back(m);
      spec.threads.push_back(t);
    }
    spec.chains.push_back({"chain", {"source.out", 0}, {"through.out", 0}});
    graph = std::make_unique<rt::Graph>(spec, types);
    hal::EmptyBoard board;
    rt::ConfigureOptions how;
    how.recorded = recorded;
    if (!graph->check({}).empty() || !graph->configure(board, how)) std::exit(2);
    if (recorded) log = std::make_unique<record::StepLog>(*graph, 1s);
    rt::RunnerOptions options;
    options.observer = log.get();
    runner = std::make_unique<rt::Runner>(*graph, options);
  }
  void steps(int n) {
    for (int i = 0; i < n; ++i) {
      now = now + 1ms;
      for (std::uint32_t t = 0; t < 2; ++t) {
        rt::ThreadRunner& thread = runner->thread(t);
        thread.begin(now, false, now);
        thread.start(0, now);
        thread.complete(0, now + 5us, 5us);
        thread.end(now + 5us);
      }
    }
  }
  void read() {
    for (std::uint32_t t = 0; log && t < 2; ++t) log->read(t, nobody);
  }
  std::unique_ptr<rt::Graph> graph;
  std::unique_ptr<record::StepLog> log;
  std::unique_ptr<rt::Runner> runner;
  Nobody nobody;
  rt::Time now;
};

std::vector<double> batches(Robot& robot, int count) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> us;
  for (int i = 0; i < count; ++i) {
    const auto start = Clock::now();
    robot.steps(kSteps);
    us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count() / (2 * kSteps));
    robot.read();
  }
  return us;
}

int measure(int pairs) {
  Robot recorded(true), bare(false);
  Pairs all;
  for (int i = 0; i < pairs; ++i) {
    auto ours = batches(recorded, 50), floor = batches(bare, 50);
    all.add(std::move(ours), std::move(floor));
  }
  const Ratio r = all.ratio();
  const double more_ns = 1e3 * (r.ours_us - r.floor_us);
  const bool good = more_ns <= kGoal_ns && recorded.nobody.lost_entries == 0;
  std::printf(
      "%-34s %.0f ns a step more than %.0f ns (%.2fx [%.2f..%.2f]), %llu recorded, %llu lost  goal %.0f ns  %s\n",
      "recorded step with a message", more_ns, 1e3 * r.floor_us, r.ratio, r.low, r.high,
      static_cast<unsigned long long>(recorded.nobody.steps),
      static_cast<unsigned long long>(recorded.nobody.lost_entries), kGoal_ns, good ? "ok" : "MISS");
  return good ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::measure(argc > 1 ? std::atoi(argv[1]) : 15); }
