// How a module is tested: alone on the rig, with the real ports, one step at a time. No threads, no clock.
#include <cstdio>

#include "control/mixer.hpp"
#include "rt/exec/module_rig.hpp"

using namespace sinew;
using namespace std::chrono_literals;

int main() {
  control::Mixer mixer;
  rt::ModuleRig rig(mixer);
  rig.set("thrust_max_n", 6.0);

  msg::WrenchSetpoint hover;
  hover.stamp = {1'000'000};
  hover.thrust_n = 12;  // half of what four rotors can
  hover.armed = 1;
  rig.put("wrench", hover);
  if (rig.step({1'000'000}, 1ms) != rt::StepStatus::ok) return 1;
  const auto* motors = rig.get<msg::ActuatorCommand>("motors");
  if (!motors) return 1;
  std::printf("hover:  %.3f %.3f %.3f %.3f\n", motors->value[0], motors->value[1], motors->value[2], motors->value[3]);

  // 50 ms later the same setpoint is too old: nothing is published, and the guardian's lease would run out.
  const bool refused =
      rig.step({51'000'000}, 50ms) == rt::StepStatus::stale && !rig.get<msg::ActuatorCommand>("motors");
  std::printf("stale:  %s\n", refused ? "nothing published" : "published, which is wrong");
  return refused ? 0 : 1;
}
