// Who is on a half-duplex line: two servos of two makers, simulated with the times of their bytes.
#include <algorithm>
#include <cstdio>

#include "drivers/joints/serial_scan.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

using namespace sinew;

int main() {
  hal::ManualClock clock;
  clock.set(hal::Time{1'000'000'000});
  sim_hil::SimSerialLine line({.bit_rate = 1'000'000, .echo = true}, clock);
  sim_hil::JointModel hip, hand;
  sim_hil::SimSerialServo dynamixel(line, hip, {}, {.id = 7, .model = wire::servo_model("xm430_w350")});
  sim_hil::SimSerialServo feetech(line, hand, {}, {.id = 9, .model = wire::servo_model("sts3215")});

  drivers::SerialScan scan(line.host(), {.bit_rates = {1'000'000}, .most_id = 20});
  std::printf("at most %.0f ms\n", 1e3 * msg::seconds(scan.longest()));
  while (!scan.done()) {
    const auto next = scan.step(clock.now());
    if (!next) return 1;
    clock.set(std::max(clock.now() + hal::Duration{1000}, std::min(*next, line.next())));
    line.advance(clock.now());
  }
  for (const drivers::SerialFound& found : scan.found())
    std::printf("%s %d: %s\n", drivers::to_string(found.maker), found.id, describe(found).c_str());
  return scan.found().size() == 2 ? 0 : 1;
}
