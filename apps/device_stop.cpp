#include "apps/device_stop.hpp"

#include "drivers/can_stop_line.hpp"
#include "hal/linux/connectors.hpp"
#include "hal/linux/os.hpp"

namespace sinew::app {
namespace {

/// The stop line with what it is made of.
class DeviceStop final : public hal::StopLine {
 public:
  static std::unique_ptr<hal::StopLine> open(const drivers::DeviceSpecs& devices,
                                             const std::vector<std::string>& groups, std::string& warning) {
    std::unique_ptr<DeviceStop> stop(new DeviceStop);
    std::string why;
    stop->line_ = drivers::CanStopLine::open(devices, groups, *stop->connectors_, hal::linux_os(), why);
    if (!why.empty() || !stop->line_)
      warning = "no stop line to " + (why.empty() ? "the actuators" : why) +
                ": when the runtime dies, joints there stop by their own time-outs (device_timeout_ms)";
    if (!stop->line_) return nullptr;
    return stop;
  }
  hal::Status stop() noexcept override { return line_->stop(); }
  bool lasts() const noexcept override { return line_->lasts(); }
  void tend() noexcept override { line_->tend(); }
  std::string told() const override { return line_->told(); }

 private:
  DeviceStop() = default;
  // Looked at every few milliseconds anyway: no thread has to watch.
  std::unique_ptr<hal::Connectors> connectors_ = hal::LinuxConnectors::unwatched(hal::linux_os());
  std::unique_ptr<drivers::CanStopLine> line_;
};

std::vector<std::string> linux_groups(const rt::GraphSpec& robot) {
  std::vector<std::string> groups;
  for (const rt::ActuatorSpec& a : robot.actuators) {
    const auto other = robot.device_boards.find(a.name);
    if ((other == robot.device_boards.end() ? robot.board : other->second.value) == "linux") groups.push_back(a.name);
  }
  return groups;
}

}  // namespace

void add_stops_of_linux_devices(const Prepared& prepared, std::vector<StopWay>& stops) {
  auto groups = linux_groups(prepared.graph->spec());
  if (groups.empty()) return;
  StopWay way{.name = "CAN"};
  // Once, beside the runtime: its buses come back by themselves.
  way.open = [&devices = prepared.robot.devices, groups = std::move(groups), warning = way.warning,
              opened = false]() mutable -> std::unique_ptr<hal::StopLine> {
    if (opened) return nullptr;
    opened = true;
    return DeviceStop::open(devices, groups, *warning);
  };
  stops.push_back(std::move(way));
}

}  // namespace sinew::app
