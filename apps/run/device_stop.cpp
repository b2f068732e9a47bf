#include "apps/run/device_stop.hpp"

#include <algorithm>
#include <atomic>
#include <span>

#include "apps/robot/board_rules.hpp"
#include "drivers/joints/can_stop_line.hpp"
#include "drivers/joints/serial_stop_line.hpp"
#include "hal/linux/devices/connectors.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kPatience = 200ms, kStopLook = 2ms;

/// The stop line with its parts. Connecting to a bus behind a network may take seconds, and the owner of this object
/// watches the runtime: so a thread connects, and the owner never waits for it longer than kPatience.
/// Thread:  owner.
class DeviceStop final : public hal::StopLine {
 public:
  /// Null: no bus can be opened, and `warning` says why.
  static std::unique_ptr<hal::StopLine> open(const drivers::DeviceSpecs& devices,
                                             const std::vector<std::string>& groups,
                                             const std::shared_ptr<StopWarning>& warning) {
    warning->known.store(false);
    std::unique_ptr<DeviceStop> stop(new DeviceStop(warning));
    hal::ThreadOptions options;
    options.name = "stop_line";
    options.stack_bytes = std::size_t{256} * 1024;  // looking up a host takes some
    auto opener =
        hal::system_os().start_thread(options, [s = stop.get(), &devices, groups] { s->connect(devices, groups); });
    if (!opener) {
      warning->text = std::string("no stop line to the actuators: no thread: ") + opener.error().where;
      warning->known.store(true, std::memory_order_release);
      return nullptr;
    }
    stop->opener_ = std::move(*opener);
    if (stop->opened() && !stop->line_) return nullptr;
    return stop;
  }
  hal::Status stop() noexcept override {
    if (!opened()) return hal::Error{hal::Errc::timeout, "its buses are still being connected to"};
    if (!line_) return hal::Error{hal::Errc::closed, "no bus could be connected to"};
    return line_->stop();
  }
  bool is_latching() const noexcept override { return false; }
  void poll() noexcept override {
    if (ready_.load(std::memory_order_acquire) && line_) line_->poll();
  }
  std::string last_report() const override {
    return ready_.load(std::memory_order_acquire) && line_ ? line_->last_report() : std::string();
  }

 private:
  explicit DeviceStop(std::shared_ptr<StopWarning> warning) : warning_(std::move(warning)) {}
  void connect(const drivers::DeviceSpecs& devices, const std::vector<std::string>& groups) {
    std::string why;
    line_ = drivers::CanStopLine::open(devices, groups, *connectors_, hal::system_os(), why);
    if (!why.empty() || !line_)
      warning_->text = "no stop line to " + (why.empty() ? "the actuators" : why) +
                       ": when the runtime dies, joints there stop by their own time-outs (device_timeout_ms)";
    warning_->known.store(true, std::memory_order_release);
    ready_.store(true, std::memory_order_release);  // with the acquires above: line_ is whole
  }
  /// Whether connecting has ended; waits up to kPatience for that.
  bool opened() const noexcept {
    hal::Os& os = hal::system_os();
    for (const hal::Time end = os.now() + kPatience; !ready_.load(std::memory_order_acquire);) {
      if (os.now() >= end) return false;
      os.sleep_until(os.now() + kStopLook);
    }
    return true;
  }

  // The line is polled every few milliseconds anyway: no thread has to watch it.
  std::unique_ptr<hal::Connectors> connectors_ = hal::LinuxConnectors::unwatched(hal::system_os());
  std::unique_ptr<drivers::CanStopLine> line_;  // the opener's until it is ready
  const std::shared_ptr<StopWarning> warning_;
  std::atomic<bool> ready_{false};
  std::unique_ptr<hal::Thread> opener_;  // last: ends before what it uses
};

/// Serial lines are opened in the stop itself, as the runtime holds them until it is dead.
class SerialStop final : public hal::StopLine {
 public:
  SerialStop(const drivers::DeviceSpecs& devices, std::span<const drivers::SerialStopLine::Group> groups)
      : line_(drivers::SerialStopLine::make(devices, groups, *connectors_, hal::system_os())) {}
  hal::Status stop() noexcept override { return line_->stop(); }
  bool is_latching() const noexcept override { return false; }
  std::string last_report() const override { return line_->last_report(); }
  bool has_joints() const { return line_ != nullptr; }

 private:
  std::unique_ptr<hal::Connectors> connectors_ = hal::LinuxConnectors::unwatched(hal::system_os());
  std::unique_ptr<drivers::SerialStopLine> line_;
};

bool on_serial_lines(const drivers::DeviceSpecs& devices, const std::string& group) {
  return std::any_of(devices.devices.begin(), devices.devices.end(),
                     [&](const drivers::DeviceSpec& d) { return d.name == group && d.driver == "serial_servos"; });
}

}  // namespace

void add_stops_of_linux_devices(const Prepared& prepared, std::vector<StopWay>& stops) {
  const rt::GraphSpec& robot = prepared.graph->spec();
  const drivers::DeviceSpecs& devices = prepared.robot.devices;
  std::vector<std::string> groups;
  std::vector<drivers::SerialStopLine::Group> serial;
  for (const rt::ActuatorSpec& a : robot.actuators) {
    if (board_of(robot, a.name) != "linux") continue;
    if (on_serial_lines(devices, a.name))
      serial.push_back({a.name, a.safe == rt::ActuatorSpec::Safe::torque_off});
    else
      groups.push_back(a.name);
  }
  if (!serial.empty()) {
    auto line = std::make_unique<SerialStop>(devices, serial);
    if (line->has_joints()) stops.push_back({.name = "serial lines", .line = std::move(line)});
  }
  if (groups.empty()) return;
  StopWay way{.name = "CAN"};
  // Opened once, after the start of the runtime: lost buses come back without another open().
  way.open = [&devices, groups = std::move(groups), warning = way.warning,
              opened = false]() mutable -> std::unique_ptr<hal::StopLine> {
    if (opened) return nullptr;
    opened = true;
    return DeviceStop::open(devices, groups, warning);
  };
  stops.push_back(std::move(way));
}

}  // namespace sinew::app
