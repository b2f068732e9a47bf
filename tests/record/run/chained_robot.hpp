#pragma once
// A robot in which modules continue with the messages of others: numbers -> sieve -> follower. Recorded into memory.
#include <functional>

#include "../../rt/graph_fixture.hpp"
#include "../memory_file.hpp"
#include "hal/silent_board.hpp"
#include "modules.hpp"
#include "record/run/replay.hpp"
#include "record/run/run_recorder.hpp"

namespace sinew::record {

using namespace std::chrono_literals;

/// Passes on messages whose number `every` divides.
class Sieve final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("in", in_);
    d.out("out", out_);
    d.param("every", every_, {.min = 1, .max = 100});
  }
  rt::StepStatus step(const rt::Step&) noexcept override {
    if (!in_.get() || !in_.updated() || in_.get()->number % static_cast<std::uint32_t>(every_) != 0)
      return rt::StepStatus::stale;
    out_.loan() = *in_.get();
    return rt::StepStatus::ok;
  }

 private:
  rt::In<rt::Pair> in_;
  rt::Out<rt::Pair> out_;
  std::int64_t every_ = 2;
};

/// Publishes what it holds: value = the newest, the length of the queue, whether it is a new message.
class Follower final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("latest", latest_, {.optional = true});
    d.in("all", all_, {.depth = 8, .optional = true});
    d.out("out", out_);
    d.state(sum_);
  }
  void reset() override { sum_ = 0; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const rt::Pair* latest = latest_.get();
    if (latest) sum_ += latest->value[0];
    rt::Pair& pair = out_.loan();
    pair.stamp = step.now;
    pair.number = latest ? latest->number : 0;
    pair.value = {latest ? latest->value[0] : 0, static_cast<double>(all_.size()), latest_.updated() ? 1.0 : 0.0, sum_};
    return rt::StepStatus::ok;
  }

 private:
  rt::In<rt::Pair> latest_;
  rt::InQueue<rt::Pair> all_;
  rt::Out<rt::Pair> out_;
  double sum_ = 0;
};

struct ChainedRobot {
  /// Readers come before writers in the file.
  static void build(rt::Robot& robot) {
    robot.add<Follower>("follower", {{"latest", "sieve.out"}, {"all", "sieve.out"}});
    robot.add<Sieve>("sieve", {{"in", "numbers.out"}});
    robot.add<Numbers>("numbers");
    robot.periodic("slow", 1, 5ms, {"follower"});
    robot.on_topics("middle", 2, {"numbers.out"}, {"sieve"});
    robot.periodic("fast", 3, 1ms, {"numbers"});
    robot.spec.seed = 7;
  }

  ChainedRobot() { build(robot); }

  void fly(rt::Duration duration, const RecorderOptions& options = {}) {
    robot.configure_options.recorded = true;
    auto recorder = RunRecorder::open(
        robot.build(), RunRecorder::Pace::waited_for,
        [this](unsigned) -> hal::Result<std::unique_ptr<hal::OutputFile>> {
          return std::unique_ptr<hal::OutputFile>(new MemoryOutput(disk));
        },
        {}, options);
    ASSERT_TRUE(recorder);
    robot.grants.end = rt::Time{duration.count()};
    rt::DiscreteOptions discrete;
    discrete.observer = &(*recorder)->observer();
    rt::DiscreteExecutor executor(robot.graph(), robot.clock, robot.grants, discrete);
    ASSERT_TRUE(executor.run());
    if (before_end) before_end(**recorder);
    ASSERT_TRUE((*recorder)->finish());
  }

  struct Change {
    std::string module, param;
    rt::ParamValue value;
  };
  /// `with` gets the graph before the replay.
  ReplayReport again(const ReplayOptions& options, const std::vector<Change>& changes = {},
                     const std::function<void(Reader&, rt::Graph&)>& with = {}) {
    FileProblem problem;
    auto reader = Reader::open(std::make_unique<MemoryInput>(disk.bytes), problem);
    EXPECT_TRUE(reader) << to_string(problem);
    rt::Robot other;
    build(other);
    for (const Change& c : changes) other.module(c.module).params[c.param] = {c.value, 0};
    rt::Graph graph(other.spec, other.types);
    hal::SilentBoard board;
    EXPECT_TRUE(graph.configure(board));
    if (with) with(*reader, graph);
    std::string why;
    auto report = replay(*reader, graph, options, why);
    EXPECT_TRUE(report) << why;
    return report ? *report : ReplayReport{};
  }
  static const ReplayedModule& of(const ReplayReport& report, std::string_view name) {
    return *std::find_if(report.modules.begin(), report.modules.end(), [&](const auto& m) { return m.name == name; });
  }

  rt::Robot robot;
  Disk disk;
  std::function<void(RunRecorder&)> before_end{};
};

}  // namespace sinew::record
