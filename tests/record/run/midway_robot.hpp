#pragma once
#include "hal/silent_board.hpp"
#include "record/check.hpp"
#include "record/run/replay.hpp"
#include "record/run/run_review.hpp"
#include "recorded_robot.hpp"

namespace sinew::record {

/// Publishes a plan in its first step, and never again.
class Plan final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override { d.out("out", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (step.number != 0) return rt::StepStatus::ok;
    rt::Pair& plan = out_.loan();
    plan.stamp = step.now;
    plan.value[0] = 42;
    return rt::StepStatus::ok;
  }

 private:
  rt::Out<rt::Pair> out_;
};

/// Adds up the plan's value in every step.
class Follows final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override {
    d.in("plan", plan_, {.optional = true});
    d.out("out", out_);
    d.state(sum_);
  }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (!plan_.get()) return rt::StepStatus::stale;
    rt::Pair& sum = out_.loan();
    sum.stamp = step.now;
    sum.value[0] = sum_ += plan_.get()->value[0];
    return rt::StepStatus::ok;
  }

 private:
  rt::In<rt::Pair> plan_;
  rt::Out<rt::Pair> out_;
  double sum_ = 0;
};

inline void make_robot_with_plan(rt::Robot& robot) {
  using namespace std::chrono_literals;
  make_robot(robot);
  robot.add<Plan>("plan");
  robot.add<Follows>("follows", {{"plan", "plan.out"}});
  robot.periodic("mission", 1, 20ms, {"plan", "follows"});
}

/// The recorded robot with a difficulty for a start in the middle of its run: a message that was published once.
class MidwayRobot : public RecordedRobot {
 protected:
  MidwayRobot() {
    robot.add<Plan>("plan");
    robot.add<Follows>("follows", {{"plan", "plan.out"}});
    robot.periodic("mission", 1, std::chrono::milliseconds(20), {"plan", "follows"});
  }

  std::unique_ptr<hal::OutputFile> disk(unsigned number) {
    while (disks.size() <= number) disks.push_back(std::make_unique<Disk>());
    return std::make_unique<MemoryOutput>(*disks[number]);
  }

  static ReplayReport again(const Bytes& file, const ReplayOptions& options = {}) {
    const auto reader = read(file);
    rt::Robot other;
    make_robot_with_plan(other);
    for (const auto& [name, value] : read_metadata(*reader, "sinew.params"))
      if (name == "numbers.gain") other.module("numbers").params["gain"] = {std::stod(value), 0};
    rt::Graph graph(other.spec, other.types);
    hal::SilentBoard board;
    EXPECT_TRUE(graph.configure(board));
    std::string why;
    auto report = replay(*reader, graph, options, why);
    EXPECT_TRUE(report) << why;
    return report ? *report : ReplayReport{};
  }
  static void expect_identical(const ReplayReport& report) {
    if (const auto* d = report.first_difference())
      ADD_FAILURE() << d->module << " step " << d->step << ": " << d->what << ": " << d->recorded << ", " << d->again;
    for (const auto& m : report.modules) {
      EXPECT_EQ(m.stopped, "") << m.name;
      EXPECT_GT(m.steps, 0u) << m.name;
    }
    EXPECT_TRUE(report.problems.empty());
  }
  static void expect_it_says_what_is_in_it(const Bytes& file) {
    MemoryInput whole(file);
    for (const FileProblem& p : check(whole)) ADD_FAILURE() << to_string(p);
    const auto reader = read(file);
    const RunReview found = review(*reader);
    EXPECT_TRUE(found.ended);
    EXPECT_TRUE(found.differences.empty()) << found.differences.front();
    for (const ModuleVerdict& v : found.verdict)
      EXPECT_EQ(read_metadata(*reader, "sinew.verdict")[v.module], to_text(v)) << v.module;
  }
};

}  // namespace sinew::record
