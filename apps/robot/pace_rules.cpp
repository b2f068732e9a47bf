#include "apps/robot/pace_rules.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/robot/board_rules.hpp"
#include "drivers/board/kernel_drivers.hpp"
#include "drivers/device_reader.hpp"
#include "drivers/joints/can_servos.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

using drivers::DeviceSpec;
using rt::Duration;

/// At most once each `every`, for the reason `why`. 0: not known.
struct Pace {
  Duration every{};
  std::string why{};
};

std::string in_ms(Duration d) { return rt::format_number(static_cast<double>(d.count()) / 1e6); }
Duration period_of(double hz) { return Duration{static_cast<std::int64_t>(1e9 / hz)}; }
const Pace& slower(const Pace& a, const Pace& b) { return a.every < b.every ? b : a; }

class PaceCheck {
 public:
  PaceCheck(const RobotFile& robot, const rt::Graph& graph) : robot_(robot), graph_(graph) {}

  std::vector<rt::Problem> all() {
    for (const rt::FailsafeSpec& f : graph_.spec().failsafes)
      if (f.kind == rt::FailsafeSpec::Kind::silent)
        check(f.line, "failsafe." + f.name + ".silent_ms", f.time, pace_of(graph_.find_topic(f.topic.value)));
    for (const rt::ActuatorSpec& a : graph_.spec().actuators)
      check(a.line, "actuator." + a.name + ".lease_ms", a.lease,
            slower(pace_of(graph_.find_topic(a.command.value)), pace_of_device(a.name)));
    return std::move(problems_);
  }

 private:
  void check(int line, std::string key, Duration time, const Pace& pace) {
    if (pace.every == Duration{} || time > pace.every) return;
    problems_.push_back(
        {line, std::move(key), in_ms(time), fmt::format("more than {}, {}", in_ms(pace.every), pace.why)});
  }

  /// `depth`: threads may release each other in a ring.
  Pace pace_of(std::uint32_t topic, std::size_t depth = 0) const {
    if (topic == rt::kNone || graph_.topics()[topic].writer == rt::kNone) return {};
    const rt::GraphModule& writer = graph_.modules()[graph_.topics()[topic].writer];
    if (writer.thread == rt::kNone || writer.guardian || writer.external) return {};
    const auto* reader = dynamic_cast<const drivers::DeviceReader*>(writer.module.get());
    return reader ? slower(pace_of_thread(writer.thread, depth), pace_of_device(device_of(writer)))
                  : pace_of_thread(writer.thread, depth);
  }

  Pace pace_of_thread(std::uint32_t thread, std::size_t depth) const {
    const rt::ThreadSpec& spec = graph_.threads()[thread].spec;
    if (spec.trigger == rt::ThreadSpec::Trigger::period) return {spec.period, "the period of the thread " + spec.name};
    if (spec.trigger != rt::ThreadSpec::Trigger::topics || depth > graph_.threads().size()) return {};
    Pace quickest;  // each of them releases it
    for (const auto& topic : spec.topics) {
      Pace one = pace_of(graph_.find_topic(topic.value), depth + 1);
      if (one.every == Duration{}) return {};
      if (quickest.every == Duration{} || one.every < quickest.every) quickest = std::move(one);
    }
    return quickest;
  }

  static std::string device_of(const rt::GraphModule& reader) {
    const auto* param = rt::find_param(reader.declaration, "device");
    if (!param) return {};
    const auto given = reader.spec.params.find("device");
    const auto* name =
        std::get_if<std::string>(given != reader.spec.params.end() ? &given->second.value : &param->default_value);
    return name ? *name : std::string{};
  }

  Pace pace_of_device(const std::string& name) const {
    if (board_of(graph_.spec(), name) != "linux") return {};
    const auto& devices = robot_.devices.devices;
    const auto it = std::find_if(devices.begin(), devices.end(), [&](const DeviceSpec& d) { return d.name == name; });
    if (it == devices.end()) return {};
    if (it->driver == "v4l2" || it->driver == "libcamera" || it->driver == "grab" || it->driver == "usarsim_images") {
      const double hz = drivers::camera_of(*it).rate_hz;
      if (hz > 0) return {period_of(hz), fmt::format("as [device.{}] has rate_hz {}", name, rt::format_number(hz))};
    }
    Pace slowest;
    for (const DeviceSpec& joint : it->joints) slowest = slower(slowest, tick_of(joint));
    return slowest;
  }

  Pace tick_of(const DeviceSpec& joint) const {
    std::vector<rt::Problem> told;
    drivers::DeviceKeys keys(joint, "", told);
    const std::string bus = drivers::read_joint(keys, robot_.devices).bus;
    for (const DeviceSpec& spec : robot_.devices.buses) {
      if (spec.name != bus) continue;
      const double hz = drivers::bus_tick_hz(spec);
      return {period_of(hz), fmt::format("as [bus.{}] has tick_hz {}", bus, rt::format_number(hz))};
    }
    return {};
  }

  const RobotFile& robot_;
  const rt::Graph& graph_;
  std::vector<rt::Problem> problems_;
};

}  // namespace

std::vector<rt::Problem> check_paces(const RobotFile& robot, const rt::Graph& graph) {
  return PaceCheck(robot, graph).all();
}

}  // namespace sinew::app
