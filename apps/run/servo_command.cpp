// servo: shows one servo on a serial line, and changes its id or bit rate.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>

#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/run/commands.hpp"
#include "drivers/joints/serial_setup.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

struct ServoOptions {
  std::string path;
  unsigned id = 1, bit_rate = 1'000'000;
  std::optional<unsigned> new_id{}, new_bit_rate{};
  bool json = false;
};

int servo_command(const ServoOptions& o) {
  hal::Os& os = hal::system_os();
  const auto connectors = hal::LinuxConnectors::unwatched(os);
  hal::SerialSpec spec;
  spec.path = o.path, spec.bit_rate = o.bit_rate, spec.low_latency = true;
  std::string why;
  auto line = connectors->serial(spec, why);
  if (!line) return fail(why);
  if (!why.empty()) std::fprintf(stderr, "warning: %s\n", why.c_str());
  drivers::SerialChange change;
  change.id = static_cast<std::uint8_t>(o.id), change.bit_rate = o.bit_rate;
  if (o.new_id) change.new_id = static_cast<std::uint8_t>(*o.new_id);
  change.new_bit_rate = o.new_bit_rate;
  change.latency = 50ms;  // few questions are asked: also an adapter whose timer could not be set answers in time
  const auto servo = drivers::change_servo(**line, os, change, why);
  if (!servo) return fail(o.path + ": " + why, kFailed);
  if (o.json)
    std::printf("%s\n", Json{{"id", servo->id},
                             {"bit_rate", servo->bit_rate},
                             {"family", drivers::to_string(servo->maker)},
                             {"model_number", servo->number},
                             {"model", servo->model ? Json(std::string(servo->model->name)) : Json(nullptr)},
                             {"firmware", servo->firmware}}
                            .dump()
                            .c_str());
  else
    std::printf("id %u at %u bit/s: %s\n", static_cast<unsigned>(servo->id), static_cast<unsigned>(servo->bit_rate),
                describe(*servo).c_str());
  return kDone;
}

}  // namespace

void add_servo_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<ServoOptions>();
  CLI::App& servo = *app.add_subcommand("servo", "one servo on a serial line: who it is; its id or bit rate changed");
  servo.add_option("line", o->path, "the serial line, e.g. /dev/ttyUSB0; nobody else uses it")
      ->required()
      ->type_name(kFileHint);
  servo.add_option("--id", o->id, "as it is")->check(CLI::Range(0u, 253u))->capture_default_str()->type_name("ID");
  servo.add_option("--bit-rate", o->bit_rate, "as it is")
      ->check(CLI::Range(9'600u, 4'500'000u))
      ->capture_default_str()
      ->type_name("BIT/S");
  servo.add_option("--new-id", o->new_id, "written into the servo; it has no torque then")
      ->check(CLI::Range(0u, 253u))
      ->type_name("ID");
  servo.add_option("--new-bit-rate", o->new_bit_rate, "likewise")
      ->check(CLI::Range(9'600u, 4'500'000u))
      ->type_name("BIT/S");
  servo.add_flag("--json", o->json, "as one JSON object");
  servo.callback([&context, o] { context.action = [o] { return servo_command(*o); }; });
}

}  // namespace sinew::app
