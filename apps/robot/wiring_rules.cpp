#include "apps/robot/wiring_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>

#include "apps/robot/board_rules.hpp"
#include "drivers/board/driver_list.hpp"
#include "drivers/board/kernel_drivers.hpp"
#include "drivers/device_reader.hpp"
#include "drivers/joints/can_servos.hpp"
#include "drivers/text/text_spec.hpp"
#include "hal/did_you_mean.hpp"
#include "robots/robot_kind.hpp"
#include "rt/graph_check.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

using drivers::DeviceSpec;

constexpr const char* kActuators = "actuators";

int line_or(int line, int otherwise) { return line ? line : otherwise; }

/// The range of one joint in the unit of its setpoints.
std::pair<double, double> range_of(const drivers::ServoConfig& joint) {
  const drivers::ServoLimits& l = joint.limits;
  if (joint.mode == drivers::ServoMode::velocity) return {-l.velocity_radps, l.velocity_radps};
  if (joint.mode == drivers::ServoMode::effort) return {-l.effort_nm, l.effort_nm};
  return {l.position_min_rad, l.position_max_rad};
}

/// `[a, b]`
std::string range_text(double from, double to) {
  return fmt::format("[{}, {}]", rt::format_number(from), rt::format_number(to));
}

/// A joint of a group, or a drive of a robot that speaks text, with its range.
struct ChannelRange {
  const char* what;
  std::string name;
  double from, to;
};
std::vector<ChannelRange> ranges_of(const DeviceSpec& group, const drivers::DeviceSpecs& devices) {
  std::vector<ChannelRange> all;
  if (group.driver == "text") {
    for (const DeviceSpec& d : group.drives) {
      std::vector<rt::Problem> told;
      drivers::DeviceKeys keys(d, "", told);
      drivers::TextDrive drive;
      drivers::read_text_drive(keys, drive);
      if (drive.scale == 0) continue;
      const auto setpoint = [&](double in_text) { return (in_text - drive.offset) / drive.scale; };
      const auto [from, to] = std::minmax({setpoint(drive.range.min), setpoint(drive.range.max)});
      all.push_back({"drive", d.name, from, to});
    }
  }
  for (const DeviceSpec& j : group.joints) {
    std::vector<rt::Problem> told;
    drivers::DeviceKeys keys(j, "", told);
    const auto [from, to] = range_of(drivers::read_joint(keys, devices).servo);
    all.push_back({"joint", j.name, from, to});
  }
  return all;
}

class WiringCheck {
 public:
  WiringCheck(const RobotFile& robot, const rt::Graph& graph) : robot_(robot), graph_(graph) {}

  std::vector<rt::Problem> all() {
    for (const rt::GraphModule& m : graph_.modules()) module(m);
    for (const rt::ActuatorSpec& a : graph_.spec().actuators) actuator(a);
    if (knows_all_readers_) boards_of_nobody();
    return std::move(problems_);
  }

 private:
  void add(int line, std::string key, std::string value, std::string allowed) {
    problems_.push_back({line, std::move(key), std::move(value), std::move(allowed)});
  }
  const DeviceSpec* table(std::string_view name) const {
    const auto& all = robot_.devices.devices;
    const auto it = std::find_if(all.begin(), all.end(), [&](const DeviceSpec& d) { return d.name == name; });
    return it == all.end() ? nullptr : &*it;
  }

  /// "[device.NAME] with ...: imu, mag", the names of those that there are.
  std::string tables_that_give(std::string_view what, const std::string& asked) const {
    std::string names;
    std::vector<std::string> known;
    for (const DeviceSpec& d : robot_.devices.devices)
      if (gives(d, what)) names += (names.empty() ? "" : ", ") + d.name, known.push_back(d.name);
    return fmt::format("the name of a [device.NAME] that gives {}: {}{}", what, names.empty() ? "there is none" : names,
                       hal::did_you_mean(asked, known));
  }
  static std::string drivers_that_give(std::string_view what) {
    std::string names;
    for (const drivers::DriverKind& d : drivers::all_drivers())
      if (drivers::gives(d, what)) names += (names.empty() ? "" : ", ") + std::string(d.name);
    return names.empty() ? "there is no driver of such" : "driver one of " + names;
  }
  static bool gives(const DeviceSpec& device, std::string_view what) {
    const auto all = drivers::all_drivers();
    return std::any_of(all.begin(), all.end(),
                       [&](const auto& d) { return d.name == device.driver && drivers::gives(d, what); });
  }

  /// Devices of the plant that sinew starts itself; empty: those of another plant are not known.
  std::span<const plant::WorldDevice> world() const {
    if (robot_.sim.plant != "auto") return {};
    const plant::WorldInfo* world = robots::find_world(robot_.sim.world);
    return world ? world->of(robot_.sim.options).devices : std::span<const plant::WorldDevice>();
  }
  const plant::WorldDevice* part(std::string_view name, std::string_view what) const {
    for (const plant::WorldDevice& p : world())
      if (p.name == name && plant::to_string(p.part) == what) return &p;
    return nullptr;
  }
  bool world_has_radio(std::string_view what) const {
    const plant::WorldInfo* world = robots::find_world(robot_.sim.world);
    return what == "radio" && world && world->has_radio();
  }
  bool world_gives(std::string_view name, std::string_view what) const {
    return part(name, what) || (world_has_radio(what) && name == plant::kRadioName);
  }
  std::string parts_that_give(std::string_view what) const {
    std::string names;
    if (world_has_radio(what)) names = plant::kRadioName;
    for (const plant::WorldDevice& p : world())
      if (plant::to_string(p.part) == what) names += (names.empty() ? "" : ", ") + std::string(p.name);
    return fmt::format("the name of {} in the world {}: {}", what, robot_.sim.world,
                       names.empty() ? "there is none" : names);
  }

  /// Checks `device`, which `user` ("module.imu") has at `line` under `key`. Returns its table; null where it is wrong.
  const DeviceSpec* wired(const std::string& device, std::string_view what, const std::string& user, std::string key,
                          int line) {
    if (std::find(used_.begin(), used_.end(), device) == used_.end()) used_.push_back(device);
    const DeviceSpec* spec = table(device);
    if (board_of(graph_.spec(), device) == "sim" && !world_gives(device, what) && !world().empty())
      add(line, key, rt::quoted(device), parts_that_give(what));
    if (!spec) {
      if (board_of(graph_.spec(), device) == "linux")
        add(line, std::move(key), rt::quoted(device), tables_that_give(what, device));
    } else if (!gives(*spec, what)) {
      add(line_or(line, spec->line), std::move(key), fmt::format("\"{}\", with driver \"{}\"", device, spec->driver),
          fmt::format("a device that gives {}, as {} reads: {}", what, user, drivers_that_give(what)));
      return nullptr;
    }
    return spec;
  }

  void module(const rt::GraphModule& m) {
    if (!m.driver || m.guardian || m.external) return;
    const auto* reader = dynamic_cast<const drivers::DeviceReader*>(m.module.get());
    const auto* param = rt::find_param(m.declaration, "device");
    if (!reader || !param) {
      knows_all_readers_ = false;
      return;
    }
    const auto given = m.spec.params.find("device");
    const bool said = given != m.spec.params.end();
    const auto* name = std::get_if<std::string>(said ? &given->second.value : &param->default_value);
    if (!name) return;  // wrong type: reported already
    const std::string user = "module." + m.spec.name;
    const DeviceSpec* device = wired(*name, reader->reads(), user, said ? user + ".params.device" : user,
                                     said ? line_or(given->second.line, m.spec.line) : m.spec.line);
    if (reader->reads() == "camera") camera(m, *name, device);
  }

  void camera(const rt::GraphModule& m, const std::string& name, const DeviceSpec* device) {
    if (device) {
      const hal::CameraSpec spec = drivers::camera_of(*device);
      const auto key = device->keys.find("width");
      frames(m, key == device->keys.end() ? device->line : key->second.line, "device." + name, spec.width, spec.height,
             spec.format);
    }
    if (board_of(graph_.spec(), name) == "sim" && robot_.sim.plant == "auto")
      frames(m, robot_.sim.camera_line, "sim.camera", robot_.sim.camera_width, robot_.sim.camera_height,
             msg::PixelFormat::yuyv);
  }

  /// Whether frames of this size fit into what the module publishes.
  void frames(const rt::GraphModule& m, int line, std::string key, std::uint32_t width, std::uint32_t height,
              msg::PixelFormat format) {
    const std::uint64_t bytes = std::uint64_t{width} * height * msg::bytes_per_pixel(format);
    for (std::size_t p = 0; p < m.topic.size(); ++p) {
      if (!m.declaration.ports[p].output || m.topic[p] == rt::kNone) continue;
      const rt::GraphTopic& topic = graph_.topics()[m.topic[p]];
      if (!topic.type->has_bulk() || bytes <= topic.image_bytes) continue;
      add(line, std::move(key), fmt::format("{}x{} {}, {} bytes", width, height, msg::pixel_format_name(format), bytes),
          fmt::format("at most {} bytes, as topic.\"{}\".image has room for: every frame would be dropped",
                      topic.image_bytes, topic.name));
      return;
    }
  }

  void actuator(const rt::ActuatorSpec& a) {
    const std::string key = "actuator." + a.name;
    const DeviceSpec* device = wired(a.name, kActuators, "[" + key + "]", key, a.line);
    const plant::WorldDevice* simulated = board_of(graph_.spec(), a.name) == "sim" ? part(a.name, kActuators) : nullptr;
    if (simulated && a.channels != simulated->channels)
      add(line_or(a.channels_line, a.line), key + ".channels", std::to_string(a.channels),
          fmt::format("{}, as {} has in the world {}", simulated->channels, a.name, robot_.sim.world));
    if (device && device->driver == "text" && !device->drives.empty() && a.channels != device->drives.size())
      add(line_or(a.channels_line, a.line), key + ".channels", std::to_string(a.channels),
          fmt::format("{}, as [device.{}] has drives", device->drives.size(), a.name));
    if (!device || (device->joints.empty() && device->drives.empty())) return;
    if (!device->joints.empty() && a.channels != device->joints.size())
      add(line_or(a.channels_line, a.line), key + ".channels", std::to_string(a.channels),
          fmt::format("{}, as [device.{}] has joints", device->joints.size(), a.name));
    const int line = line_or(a.limit_line, a.line);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    std::uint32_t channel = 0;
    const auto ranges = ranges_of(*device, robot_.devices);
    for (const ChannelRange& j : ranges) {
      const rt::ActuatorSpec::Range limit = a.limit(channel++);
      low = std::min(low, j.from), high = std::max(high, j.to);
      if (limit.max < j.from || limit.min > j.to)
        add(line, key + ".limit", range_text(limit.min, limit.max),
            fmt::format("a range that has something of {}, that of the {} {} of [device.{}]: it could follow nothing",
                        range_text(j.from, j.to), j.what, j.name, a.name));
      else if (!a.channel_limits.empty() && (limit.min < j.from || limit.max > j.to))
        add(line, key + ".limit", range_text(limit.min, limit.max),
            fmt::format("within {}, the range of the {} {} of [device.{}]: what is beyond is pulled in",
                        range_text(j.from, j.to), j.what, j.name, a.name));
    }
    if (!ranges.empty() && a.channel_limits.empty() && (a.min < low || a.max > high))
      add(line, key + ".limit", range_text(a.min, a.max),
          fmt::format("within {}, the widest range of the {}s of [device.{}]: what is beyond is pulled in",
                      range_text(low, high), ranges.front().what, a.name));
  }

  /// Boards for devices that nothing uses; run reports them, too, after configuring.
  void boards_of_nobody() {
    for (const auto& [device, board] : graph_.spec().device_boards)
      if (std::find(used_.begin(), used_.end(), device) == used_.end())
        add(board.line, "robot.device_boards." + device, rt::quoted(board.value),
            "a device that a module or an actuator uses: " + rt::listed_for(device, used_));
  }

  const RobotFile& robot_;
  const rt::Graph& graph_;
  std::vector<std::string> used_;
  bool knows_all_readers_ = true;
  std::vector<rt::Problem> problems_;
};

}  // namespace

std::vector<rt::Problem> check_wiring(const RobotFile& robot, const rt::Graph& graph) {
  return WiringCheck(robot, graph).all();
}

std::vector<std::string> narrower_joints(const RobotFile& robot) {
  std::vector<std::string> all;
  for (const rt::ActuatorSpec& a : robot.graph.actuators) {
    for (const DeviceSpec& d : robot.devices.devices) {
      if (d.name != a.name || board_of(robot.graph, a.name) != "linux") continue;
      std::uint32_t channel = 0;
      for (const ChannelRange& j : ranges_of(d, robot.devices)) {
        const rt::ActuatorSpec::Range limit = a.limit(channel++);
        if (j.from > limit.min || j.to < limit.max)
          all.push_back(fmt::format("actuator.{}.limit {}: {} {} goes from {} to {}, and is pulled in beyond", a.name,
                                    range_text(limit.min, limit.max), j.what, j.name,
                                    rt::format_number(std::max(j.from, limit.min)),
                                    rt::format_number(std::min(j.to, limit.max))));
      }
    }
  }
  return all;
}

}  // namespace sinew::app
