#pragma once
// Stops all joints of a robot's serial lines without its runtime: for the parent process, when that is dead.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/joints/joint_keys.hpp"
#include "drivers/joints/serial_buses.hpp"
#include "hal/connectors.hpp"
#include "hal/os.hpp"
#include "hal/stop_line.hpp"

namespace sinew::drivers {

/// A half-duplex line has one user, and holds it exclusively. So stop() opens the lines, once the runtime has been
/// killed and its descriptors are gone, and then, on all lines at the same time:
/// - joints whose `on_stop` is torque_off, and all joints of a group that shall be limp: torque off in one packet for
///   all of a line, at once and every 20 ms;
/// - joints whose `on_stop` is hold: of mode position nothing, as a servo holds its last goal by itself; of mode
///   velocity the goal 0;
/// - each joint is asked until it has said that it is so, at most for kPatience.
/// A servo whose bus watchdog is set stops by itself some time after the last question, with its torque.
/// A runtime that lives would undo it; is_latching() is false.
/// Thread:  owner.   RT: no: stop() opens the lines that are not open yet; it sleeps, for kPatience at most.
class SerialStopLine final : public hal::StopLine {
 public:
  static constexpr hal::Duration kPatience = std::chrono::milliseconds(200);
  struct Group {
    std::string name;
    bool limp = false;  // also joints that would hold lose their torque
  };

  /// `specs` without problems; copied. Null: no group has joints on a serial line. Opens nothing.
  static std::unique_ptr<SerialStopLine> make(const DeviceSpecs& specs, std::span<const Group> groups,
                                              hal::Connectors& connectors, hal::Os& os);

  /// Ok: each joint has said that it has no torque, or that it holds where it was to hold.
  /// Errors:  closed: no line could be opened, last_report() says why; timeout: not every joint has said it.
  hal::Status stop() noexcept override;
  bool is_latching() const noexcept override { return false; }
  std::string last_report() const override;
  std::size_t joints() const noexcept { return joints_.size(); }

 private:
  enum class Said : std::uint8_t { nothing, off, holds, has_torque };
  struct Joint {
    std::string name;
    std::unique_ptr<SerialServo> servo;  // never ticks
    bool holds = false;
    Said said = Said::nothing;
  };
  struct Line {
    std::string name;
    hal::SerialSpec spec;
    SerialLineRate rate;
    std::vector<std::size_t> joints;
    std::unique_ptr<hal::Serial> port;
    std::unique_ptr<wire::DxlReader> reader;
    std::string trouble;                    // why it is not open, or was lost
    std::size_t turn = 0, asked = kNobody;  // places in `joints`
    bool writes_goal = false;               // the question was a goal of 0, and not for the torque
    hal::Time answer_by{}, off_again{}, busy_until{};
  };
  static constexpr std::size_t kNobody = ~std::size_t{0};

  SerialStopLine(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os)
      : specs_(specs), connectors_(connectors), os_(os) {}
  void add(const DeviceSpec& joint, bool limp);
  bool is_done(const Joint& joint) const noexcept;
  bool step(Line& line, hal::Time now);
  bool open(Line& line);
  void take_torque(Line& line, hal::Time now);
  void ask_next(Line& line);
  void listen(Line& line, hal::Time now);
  void hear(Line& line, std::uint8_t byte);
  bool send(Line& line, wire::DxlBuilder& packet);
  wire::DxlVersion version(const Line& line) const { return joints_[line.joints[0]].servo->model().version; }

  const DeviceSpecs specs_;
  hal::Connectors& connectors_;
  hal::Os& os_;
  std::vector<Line> lines_;
  std::vector<Joint> joints_;
  bool stopped_once_ = false;
};

}  // namespace sinew::drivers
