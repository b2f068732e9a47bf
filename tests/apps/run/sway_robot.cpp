// The whole `sinew` command with one module more: commands to joints that nothing measures.
#include <cmath>

#include "apps/command_line.hpp"
#include "apps/module_list.hpp"
#include "msg/actuators.hpp"
#include "rt/module.hpp"

using namespace sinew;

namespace test {

/// Sways slowly about zero, all channels together.
class Sway final : public rt::Module {
  void declare(rt::Declaration& d) override {
    d.out("command", out_);
    d.param("channels", channels_, {.min = 1, .max = 8, .doc = "of the actuator group"});
    d.param("amplitude", amplitude_, {.min = 0, .max = 10, .doc = "of every channel, in the group's unit"});
    d.param("middle", middle_, {.min = -10, .max = 10, .doc = "likewise"});
    d.state(begin_);
  }
  void reset() override { begin_ = {}; }
  rt::StepStatus step(const rt::Step& step) noexcept override {
    if (begin_.ns == 0) begin_ = step.now;
    msg::ActuatorCommand& command = out_.loan();
    command.stamp = step.now;
    command.count = static_cast<std::uint32_t>(channels_);
    command.armed = 1;
    for (std::size_t i = 0; i < command.count; ++i)
      command.value[i] = middle_ + amplitude_ * std::sin(msg::seconds(step.now - begin_));
    return rt::StepStatus::ok;
  }
  rt::Out<msg::ActuatorCommand> out_;
  double channels_ = 1, amplitude_ = 0.3, middle_ = 0;
  msg::Time begin_;
};

}  // namespace test

int main(int argc, char** argv) {
  rt::ModuleTypes types = app::all_modules();
  types.add<test::Sway>("test::Sway");
  return app::command_line(argc, argv, types);
}
