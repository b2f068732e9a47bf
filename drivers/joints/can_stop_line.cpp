#include "drivers/joints/can_stop_line.hpp"

#include <algorithm>

#include "drivers/joints/can_servos.hpp"

namespace sinew::drivers {
namespace {

using namespace std::chrono_literals;

constexpr Duration kRound = 10ms, kLook = 1ms;  // rounds: farewell, question, farewell, ...
constexpr int kRounds = static_cast<int>(CanStopLine::kPatience / kRound);
constexpr int kLeast = 4;             // rounds in any case: single frames may be lost
constexpr Duration kDeadline = 50ms;  // of a frame: a drive that comes back later is told again
constexpr int kFramesPerLook = 64;    // of one bus; what a full bus brings in 5 ms, so that nothing piles up
constexpr int kStale = 8192;          // more than a queue of the kernel holds

std::string lines(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : "; ") + text;
  return all;
}

}  // namespace

CanStopLine::CanStopLine(const DeviceSpecs& specs, hal::Connectors& connectors, hal::Os& os)
    : specs_(specs), os_(os), can_(specs_, connectors, os) {}

std::unique_ptr<CanStopLine> CanStopLine::open(const DeviceSpecs& specs, std::span<const std::string> groups,
                                               hal::Connectors& connectors, hal::Os& os, std::string& why) {
  std::unique_ptr<CanStopLine> line(new CanStopLine(specs, connectors, os));
  std::vector<std::string> lost;
  for (const DeviceSpec& device : line->specs_.devices) {
    if (std::find(groups.begin(), groups.end(), device.name) == groups.end()) continue;
    if (device.driver != "can_servos") continue;
    for (const DeviceSpec& joint : device.joints) line->add(joint, lost);
  }
  for (const auto& bus : line->buses_) static_cast<void>(bus->bus_.set_filters(bus->filters_));  // else more is read
  why = lines(lost);
  return line->joints_.empty() ? nullptr : std::move(line);
}

bool CanStopLine::add(const DeviceSpec& spec, std::vector<std::string>& lost) {
  std::vector<rt::Problem> told;  // reported when the robot file was read
  DeviceKeys keys(spec, "", told);
  JointConfig joint = read_joint(keys, specs_);
  std::string why;
  auto opened = can_.open(joint.bus, why);
  if (!opened) {
    if (std::find(lost.begin(), lost.end(), why) == lost.end()) lost.push_back(why);
    without_bus_.push_back("joint '" + spec.name + "' (" + joint.bus + ") could not be reached from the start");
    return false;
  }
  auto bus = std::find_if(buses_.begin(), buses_.end(), [&](const auto& b) { return b->name_ == joint.bus; });
  if (bus == buses_.end()) {
    buses_.push_back(std::make_unique<Bus>(joint.bus, *(*opened)->bus, os_));
    bus = buses_.end() - 1;
  }
  auto servo = joint.make(**opened);
  for (const Interest& interest : servo->interests()) (*bus)->filters_.push_back(interest);
  joints_.push_back({spec.name, std::move(servo), static_cast<std::size_t>(bus - buses_.begin())});
  return true;
}

void CanStopLine::Bus::send(const msg::CanFrame& frame) noexcept {
  // A queue that is full (the kernel's holds 10 frames by default) has room again in a moment.
  auto sent = bus_.send(frame, os_.now() + kDeadline);
  while (!sent && sent.error().code == hal::Errc::timeout && os_.now() < patient_until_) {
    os_.sleep_until(os_.now() + kLook);
    sent = bus_.send(frame, os_.now() + kDeadline);
  }
  if (sent) {
    ++sent_;
  } else {
    ++refused_;
    error_ = sent.error().code;
  }
}

bool CanStopLine::concerns(const ServoProtocol& servo, const msg::CanFrame& frame) noexcept {
  for (const Interest& i : servo.interests())
    if (i.extended == frame.extended() && ((frame.id ^ i.id) & i.mask) == 0) return !frame.error();
  return false;
}

void CanStopLine::poll() noexcept {
  msg::CanFrame frame;
  for (const auto& bus : buses_) {
    for (int i = 0; i < kFramesPerLook; ++i)
      if (const auto got = bus->bus_.read(frame); !got || !*got) break;
  }
}

/// Even rounds send farewell(), odd ones the question. From half time on a drive that still has torque gets insist(),
/// once.
void CanStopLine::say(int round) noexcept {
  for (const auto& bus : buses_) bus->patient_until_ = os_.now() + kRound;
  for (Joint& joint : joints_) {
    FrameSink& out = *buses_[joint.bus];
    const bool off = joint.said == TorqueSaid::off;
    if (!off && round >= kRounds / 2 && !joint.insisted) {
      joint.insisted = true;
      joint.said = TorqueSaid::nothing;  // what it said was before
      joint.servo->insist(out);
    } else if (round % 2 == 0) {
      if (!off || round < kLeast) joint.servo->farewell(out);
    } else if (!off || round < kLeast) {
      joint.servo->ask_torque(out);
    }
  }
}

/// `believe`: what is heard now can be an answer to us.
void CanStopLine::listen(bool believe) noexcept {
  msg::CanFrame frame;
  for (std::size_t b = 0; b < buses_.size(); ++b) {
    for (int i = 0; i < kStale; ++i) {
      if (const auto got = buses_[b]->bus_.read(frame); !got || !*got) break;
      for (Joint& joint : joints_) {
        if (joint.bus != b || !concerns(*joint.servo, frame)) continue;
        const TorqueSaid said = joint.servo->torque_said(frame, os_.now());
        if (believe && said != TorqueSaid::nothing) joint.said = said;
      }
    }
  }
}

bool CanStopLine::all_off() const noexcept {
  return std::all_of(joints_.begin(), joints_.end(), [](const Joint& j) { return j.said == TorqueSaid::off; });
}

hal::Status CanStopLine::stop() noexcept {
  stopped_once_ = true;
  for (Joint& joint : joints_) joint.said = TorqueSaid::nothing, joint.insisted = false;
  for (const auto& bus : buses_) bus->sent_ = bus->refused_ = 0;
  say(0);  // at once; what was said before this is old
  listen(false);
  const Time begin = os_.now();
  for (int round = 1; round <= kRounds; ++round) {
    const Time until = begin + round * kRound;
    do {
      os_.sleep_until(os_.now() + kLook);
      listen(round > 1);
    } while (os_.now() < until);
    if (round >= kLeast && all_off()) break;
    if (round < kRounds) say(round);
  }
  if (all_off() && without_bus_.empty()) return {};
  const bool any_sent = std::any_of(buses_.begin(), buses_.end(), [](const auto& b) { return b->sent_ > 0; });
  if (!any_sent) return hal::Error{hal::Errc::closed, "no CAN bus took a frame"};
  return hal::Error{
      hal::Errc::timeout, "not every joint has said that it is without torque",
      static_cast<std::int64_t>(without_bus_.size()) +
          std::count_if(joints_.begin(), joints_.end(), [](const Joint& j) { return j.said != TorqueSaid::off; })};
}

std::string CanStopLine::last_report() const {
  if (!stopped_once_) return {};
  std::vector<std::string> texts;
  for (const auto& bus : buses_)
    if (bus->sent_ == 0)
      texts.push_back("bus '" + bus->name_ + "' takes no frame (" + hal::to_string(bus->error_) + ")");
  texts.insert(texts.end(), without_bus_.begin(), without_bus_.end());
  std::size_t off = 0;
  for (const Joint& joint : joints_) {
    const std::string& bus = buses_[joint.bus]->name_;
    if (joint.said == TorqueSaid::off) ++off;
    if (joint.said == TorqueSaid::on) texts.push_back("joint '" + joint.name + "' (" + bus + ") still has torque");
    if (joint.said == TorqueSaid::nothing) texts.push_back("joint '" + joint.name + "' (" + bus + ") did not answer");
  }
  return std::to_string(off) + " of " + std::to_string(joints_.size() + without_bus_.size()) +
         " joints are without torque" + (texts.empty() ? "" : "; " + lines(texts));
}

}  // namespace sinew::drivers
