// Two robots that hear each other: each has a ball that bounces, and says its height; each looks at the other's.
//   example_mates run mates.toml & example_mates run mates_bee.toml        `example_mates topic echo mates.state`
#include <algorithm>

#include "apps/command_line.hpp"
#include "apps/module_list.hpp"
#include "msg/sensors.hpp"
#include "msg/team.hpp"
#include "rt/module.hpp"

using namespace sinew;
namespace my {

/// Rises and falls once a second.
class Ball final : public rt::Module {
  void declare(rt::Declaration& d) override { d.out("height", out_); }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const double s = static_cast<double>(step.now.ns % 1'000'000'000) * 1e-9;
    out_.loan() = {step.now, 4 * s * (1 - s)};
    return rt::StepStatus::ok;
  }
  rt::Out<msg::RangeSample> out_;
};

/// Publishes the greatest height that any mate said, and the height of one mate's ball, as if it were here.
class Judge final : public rt::Module {
  void declare(rt::Declaration& d) override {
    d.in("mates", mates_);
    d.in("other", other_);
    d.out("greatest", greatest_);
    d.out("of_other", of_other_);
    d.state(best_m_);
  }
  void reset() override { best_m_ = 0; }
  rt::StepStatus step(const rt::Step&) noexcept override {
    for (const msg::FromMate<msg::RangeSample>& heard : mates_)  // heard.robot says whose it is
      best_m_ = std::max(best_m_, heard.message.range_m);
    if (!mates_.empty()) greatest_.loan() = {mates_.back().stamp, best_m_};
    const msg::RangeSample* other = other_.get();
    if (!other) return rt::StepStatus::ok;  // silent for longer than max_age_ms
    of_other_.loan() = *other;
    return rt::StepStatus::ok;
  }
  rt::InQueue<msg::FromMate<msg::RangeSample>> mates_;
  rt::In<msg::RangeSample> other_;
  rt::Out<msg::RangeSample> greatest_, of_other_;
  double best_m_ = 0;
};

}  // namespace my

int main(int argc, char** argv) {
  rt::ModuleTypes types = app::all_modules();
  types.add<my::Ball>("my::Ball");
  types.add<my::Judge>("my::Judge");
  return app::command_line(argc, argv, types);
}
