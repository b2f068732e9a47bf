// A program of one's own: its modules in a list, and with them the whole `sinew` command.
//   example_own_program run own_program.toml --virtual        and check, graph, top, param set, ...
#include <algorithm>

#include "apps/command_line.hpp"
#include "msg/sensors.hpp"
#include "rt/module.hpp"

using namespace sinew;
namespace my {

/// Falls from a metre's height and bounces.
class Ball final : public rt::Module {
  void declare(rt::Declaration& d) override {
    d.out("height", out_);
    d.param("restitution", restitution_, {.min = 0, .max = 1, .doc = "speed after a bounce to speed before it"});
    d.state(height_m_, speed_mps_);
  }
  void reset() override { height_m_ = 1, speed_mps_ = 0; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    const double dt_s = msg::seconds(step.dt);
    speed_mps_ -= 9.81 * dt_s;
    height_m_ += speed_mps_ * dt_s;
    if (height_m_ < 0) height_m_ = 0, speed_mps_ *= -restitution_;
    out_.loan() = {step.now, height_m_};
    return rt::StepStatus::ok;
  }
  rt::Out<msg::RangeSample> out_;
  double restitution_ = 0.7, height_m_ = 1, speed_mps_ = 0;
};

/// Publishes the highest point since the last time that the ball touched the ground.
class Apex final : public rt::Module {
  void declare(rt::Declaration& d) override {
    d.in("height", in_);
    d.out("apex", out_);
    d.state(apex_m_);
  }
  void reset() override { apex_m_ = 0; }
  rt::StepStatus step(const rt::Step&) noexcept override {
    const auto* height = in_.get();
    if (!height) return rt::StepStatus::stale;  // nothing is published
    apex_m_ = height->range_m == 0 ? 0 : std::max(apex_m_, height->range_m);
    out_.loan() = {height->stamp, apex_m_};
    return rt::StepStatus::ok;
  }
  rt::In<msg::RangeSample> in_;
  rt::Out<msg::RangeSample> out_;
  double apex_m_ = 0;
};

}  // namespace my

int main(int argc, char** argv) {
  rt::ModuleTypes types;  // or app::all_modules(), to have Sinew's own as well
  types.add<my::Ball>("my::Ball");
  types.add<my::Apex>("my::Apex");
  return app::command_line(argc, argv, types);
}
