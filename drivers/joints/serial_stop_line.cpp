#include "drivers/joints/serial_stop_line.hpp"

#include <algorithm>
#include <array>

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;
using hal::Duration;
using hal::Time;
using wire::DxlBuilder;
using wire::DxlInstruction;
using wire::DxlPacket;
using wire::DxlVersion;
using wire::ServoRegister;

constexpr Duration kStopLook = 1ms;    // between two looks at the lines
constexpr Duration kOffAgain = 20ms;   // single bytes may be lost
constexpr Duration kStopAnswer = 3ms;  // a servo that is not set up waits 500 us; this process may be late
constexpr int kStopBytes = 64 * 1024;  // of one look; more than a queue of the kernel holds

Duration bytes_time(std::size_t bytes, std::uint32_t bit_rate) {
  return Duration{static_cast<std::int64_t>(bytes) * 10'000'000'000 / static_cast<std::int64_t>(bit_rate)};
}

}  // namespace

std::unique_ptr<SerialStopLine> SerialStopLine::make(const DeviceSpecs& specs, std::span<const Group> groups,
                                                     hal::Connectors& connectors, hal::Os& os) {
  std::unique_ptr<SerialStopLine> stop(new SerialStopLine(specs, connectors, os));
  for (const DeviceSpec& device : stop->specs_.devices) {
    const auto group =
        std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.name == device.name; });
    if (group == groups.end() || device.driver != "serial_servos") continue;
    for (const DeviceSpec& joint : device.joints) stop->add(joint, group->limp);
  }
  return stop->joints_.empty() ? nullptr : std::move(stop);
}

void SerialStopLine::add(const DeviceSpec& spec, bool limp) {
  std::vector<rt::Problem> told;  // reported when the robot file was read
  DeviceKeys keys(spec, "", told);
  JointConfig joint = read_joint(keys, specs_);
  auto line = std::find_if(lines_.begin(), lines_.end(), [&](const Line& l) { return l.name == joint.bus; });
  if (line == lines_.end()) {
    const auto bus = std::find_if(specs_.buses.begin(), specs_.buses.end(),
                                  [&](const DeviceSpec& b) { return b.name == joint.bus; });
    if (bus == specs_.buses.end() || !joint.make_serial) return;
    DeviceKeys bus_keys(*bus, "", told);
    const SerialBusConfig config = read_serial_bus(bus_keys);
    line = lines_.insert(lines_.end(), Line{});
    line->name = joint.bus, line->spec = config.spec, line->rate = config.hub.rate;
  }
  line->joints.push_back(joints_.size());
  joints_.push_back({spec.name, joint.make_serial(), !limp && joint.servo.stop == StopAction::hold});
}

bool SerialStopLine::is_done(const Joint& joint) const noexcept {
  return joint.said == Said::off || (joint.holds && joint.said == Said::holds);
}

bool SerialStopLine::open(Line& line) {
  std::string why;
  auto port = connectors_.serial(line.spec, why);
  if (!port) {
    line.trouble = why;
    return false;
  }
  line.port = std::move(*port);
  line.trouble.clear();
  line.reader = std::make_unique<wire::DxlReader>(version(line));
  line.asked = kNobody, line.off_again = {};
  return true;
}

bool SerialStopLine::send(Line& line, DxlBuilder& packet) {
  const auto bytes = packet.finish();
  const auto n = line.port->write_now(bytes);
  if (!n) {
    line.trouble = "the serial line is gone (unplugged?)";
    line.port.reset();
    return false;
  }
  line.busy_until = std::max(line.busy_until, os_.now()) + bytes_time(bytes.size(), line.rate.bit_rate);
  return true;
}

/// In one packet for all that shall lose it; nobody answers.
void SerialStopLine::take_torque(Line& line, Time now) {
  line.off_again = now + kOffAgain;
  std::vector<ServoRegister> done;
  for (const std::size_t first : line.joints) {
    const ServoRegister reg = joints_[first].servo->model().torque_enable;
    const auto same = [&](const ServoRegister& r) { return r.address == reg.address; };
    if (std::any_of(done.begin(), done.end(), same)) continue;
    done.push_back(reg);
    DxlBuilder packet = wire::dxl_sync_write(version(line), reg.address, reg.size);
    bool any = false;
    for (const std::size_t i : line.joints) {
      if (joints_[i].holds || !same(joints_[i].servo->model().torque_enable)) continue;
      packet.byte(joints_[i].servo->id()).byte(0);
      any = true;
    }
    if (any && !send(line, packet)) return;
  }
}

/// Asks the next joint that has not said it; one that shall stand still and holds a velocity gets the velocity 0 first.
void SerialStopLine::ask_next(Line& line) {
  for (std::size_t k = 0; k < line.joints.size(); ++k) {
    const std::size_t at = (line.turn + k) % line.joints.size();
    const Joint& joint = joints_[line.joints[at]];
    if (is_done(joint)) continue;
    const SerialServo& servo = *joint.servo;
    const DxlVersion v = version(line);
    const ServoRegister torque = servo.model().torque_enable;
    line.writes_goal = joint.holds && servo.config().mode == ServoMode::velocity;
    DxlBuilder packet = line.writes_goal ? wire::dxl_write(v, servo.id(), servo.goal_register().address,
                                                           wire::servo_bytes(servo.model(), servo.goal_register(), 0))
                                         : wire::dxl_read(v, servo.id(), torque.address, torque.size);
    if (!send(line, packet)) return;
    line.turn = at + 1;
    line.asked = at;
    line.answer_by = line.busy_until + bytes_time(wire::dxl_status_bytes(v, 1), line.rate.bit_rate) + kStopAnswer +
                     line.rate.latency;
    return;
  }
}

/// An echo of our own bytes is no answer: of 2.0 it is no status, of 1.0 it has another length than the answer.
void SerialStopLine::hear(Line& line, std::uint8_t byte) {
  const DxlVersion v = version(line);
  line.reader->push(byte, [&](const DxlPacket& packet) {
    if (line.asked == kNobody || (v == DxlVersion::two && !packet.is(DxlInstruction::status))) return;
    Joint& joint = joints_[line.joints[line.asked]];
    if (packet.id != joint.servo->id() || packet.parameters.size() != (line.writes_goal ? 0u : 1u)) return;
    line.asked = kNobody;
    if (!line.writes_goal)
      joint.said = packet.parameters[0] == 0 ? Said::off : joint.holds ? Said::holds : Said::has_torque;
    else  // 2.0 refuses a goal when the bus watchdog has stopped the servo: it stands still
      joint.said = Said::holds;
  });
}

void SerialStopLine::listen(Line& line, Time now) {
  std::array<std::uint8_t, 256> bytes;
  for (int taken = 0; taken < kStopBytes;) {
    const auto n = line.port->read_now(bytes);
    if (!n) {
      line.trouble = "the serial line is gone (unplugged?)";
      line.port.reset();
      return;
    }
    for (std::size_t k = 0; k < *n; ++k) hear(line, bytes[k]);
    taken += static_cast<int>(*n);
    if (*n < bytes.size()) break;
  }
  if (line.asked == kNobody || now < line.answer_by) return;
  line.asked = kNobody;
  line.reader->gap();
}

/// True: all joints on it have said it.
bool SerialStopLine::step(Line& line, Time now) {
  if (!line.port && !open(line)) return false;
  listen(line, now);
  if (!line.port || line.asked != kNobody) return false;
  if (now >= line.off_again) take_torque(line, now);
  if (line.port) ask_next(line);
  return std::all_of(line.joints.begin(), line.joints.end(), [&](std::size_t i) { return is_done(joints_[i]); });
}

hal::Status SerialStopLine::stop() noexcept {
  stopped_once_ = true;
  for (Joint& joint : joints_) joint.said = Said::nothing;
  for (Line& line : lines_) line.asked = kNobody, line.off_again = {};
  bool all = false;
  for (const Time end = os_.now() + kPatience; !all;) {
    all = true;
    for (Line& line : lines_) all = step(line, os_.now()) && all;
    if (all || os_.now() >= end) break;
    os_.sleep_until(std::min(end, os_.now() + kStopLook));
  }
  if (all) return {};
  if (std::none_of(lines_.begin(), lines_.end(), [](const Line& l) { return l.port != nullptr; }))
    return hal::Error{hal::Errc::closed, "no serial line could be opened"};
  return hal::Error{hal::Errc::timeout, "not every joint has said that it has stopped",
                    std::count_if(joints_.begin(), joints_.end(), [&](const Joint& j) { return !is_done(j); })};
}

std::string SerialStopLine::last_report() const {
  if (!stopped_once_) return {};
  std::size_t off = 0, holding = 0;
  std::string texts;
  for (const Line& line : lines_) {
    if (!line.port) texts += "; bus '" + line.name + "': " + line.trouble;
    for (const std::size_t i : line.joints) {
      const Joint& joint = joints_[i];
      if (joint.said == Said::off) ++off;
      if (joint.said == Said::holds) ++holding;
      const std::string name = "; joint '" + joint.name + "' (" + line.name + ")";
      if (joint.said == Said::has_torque) texts += name + " still has torque";
      if (line.port && joint.said == Said::nothing) texts += name + " did not answer";
    }
  }
  std::string all = std::to_string(off) + " of " + std::to_string(joints_.size()) + " joints are without torque";
  if (holding > 0) all += ", " + std::to_string(holding) + (holding == 1 ? " holds" : " hold");
  return all + texts;
}

}  // namespace sinew::drivers
