// A module of one's own in a graph built by code, run in virtual time: ten seconds pass at once.
#include <cstdio>

#include "msg/sensors.hpp"
#include "rt/exec/discrete_executor.hpp"
using namespace sinew;
using namespace std::chrono_literals;
class Wave final : public rt::Module {  // stands in for a sensor
  void declare(rt::Declaration& d) override { d.out("range", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    out_.loan() = {step.now, 1 + 0.1 * step.random.uniform()};  // written in place, visible when this step completes
    return rt::StepStatus::ok;
  }
  rt::Out<msg::RangeSample> out_;
};

class LowPass final : public rt::Module {
  void declare(rt::Declaration& d) override {
    d.in("in", in_, {.max_age = 50ms});
    d.out("out", out_);
    d.param("time_s", time_s_, {.unit = "s", .min = 0.01, .max = 10, .doc = "time constant"});
    d.state(smooth_);
  }
  void reset() override { smooth_ = {msg::Time{-1}, 0}; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const msg::RangeSample* in = in_.fresh(step.now);
    if (!in) return rt::StepStatus::stale;          // none yet, or too old: nothing is published
    if (!in_.updated()) return rt::StepStatus::ok;  // only when new: the sample of the last step changes nothing
    if (smooth_.stamp.ns < 0) smooth_ = *in;        // the first sample: begin there, not at 0
    const double share = msg::seconds(in->stamp - smooth_.stamp) / time_s_;
    out_.loan() = smooth_ = {in->stamp, smooth_.range_m + share * (in->range_m - smooth_.range_m)};
    return rt::StepStatus::ok;
  }
  rt::In<msg::RangeSample> in_;
  rt::Out<msg::RangeSample> out_;
  msg::RangeSample smooth_{msg::Time{-1}, 0};  // before the first sample
  double time_s_ = 1;
};

int main() {
  rt::ModuleTypes types;
  types.add<Wave>("Wave");
  types.add<LowPass>("LowPass");
  const rt::ExecModel ten_us{rt::ExecModel::Kind::constant, 10us, {}, 1};
  rt::Graph graph({.threads = {{.name = "sensor", .priority = 20, .period = 10ms, .order = {{"wave"}}},
                               {.name = "loop", .priority = 10, .period = 1ms, .order = {{"smooth"}}}},
                   .modules = {{.name = "wave", .type = "Wave", .exec = ten_us},
                               {.name = "smooth", .type = "LowPass", .in = {{"in", {"wave.range"}}}, .exec = ten_us}}},
                  types);
  hal::EmptyBoard board;
  if (!graph.check({.virtual_time = true}).empty() || !graph.configure(board)) return 1;
  hal::ManualClock clock;
  hal::FixedGrant grants(hal::Time{10'000'000'000});
  rt::DiscreteExecutor executor(graph, clock, grants, {.duration = 10s});
  if (!executor.run()) return 1;
  const auto messages = executor.runner().topic_stats(graph.find_topic("smooth.out")).messages.value();
  std::printf("%d messages of 10000 steps\n", static_cast<int>(messages));
  return messages == 1'000 ? 0 : 1;
}
