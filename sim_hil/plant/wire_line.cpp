#include "sim_hil/plant/wire_line.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "msg/joints.hpp"

namespace sinew::plant {
namespace {

using namespace std::chrono_literals;
using hal::Time;

constexpr hal::Duration kLineSleep = 1ms;  // the servos' loops run at least so often
constexpr hal::Duration kNobody = 500us;   // between two looks at a port that nobody has open

bool read_number(std::string_view text, double least, double most, double& out) {
  const char* const end = text.data() + text.size();
  const auto [rest, wrong] = std::from_chars(text.data(), end, out);
  return wrong == std::errc() && rest == end && out >= least && out <= most;
}

/// "gone@S", or the name of another event, "=ID@S".
bool read_event(std::string_view text, std::vector<WireLineSpec::Event>& events) {
  using Kind = WireLineSpec::Event::Kind;
  WireLineSpec::Event event;
  const auto at = text.find('@');
  if (at == std::string_view::npos || !read_number(text.substr(at + 1), 0, 1e6, event.at_s)) return false;
  std::string_view what = text.substr(0, at);
  constexpr std::pair<std::string_view, Kind> kNames[] = {
      {"reboot=", Kind::reboot}, {"off=", Kind::off}, {"overload=", Kind::overload}, {"hot=", Kind::hot}};
  event.kind = Kind::gone;
  for (const auto& [name, kind] : kNames)
    if (what.starts_with(name)) event.kind = kind;
  double id = 0;
  if (event.kind == Kind::gone ? what != "gone" : !read_number(what.substr(what.find('=') + 1), 0, 253, id))
    return false;
  event.id = static_cast<std::uint32_t>(id);
  events.push_back(event);
  return event.id == id;
}

}  // namespace

std::optional<WireLineSpec> parse_wire_line(const std::string& whole, std::string& why) {
  WireLineSpec spec;
  std::string_view rest = whole;
  const auto next = [&rest] {
    const auto comma = rest.find(',');
    const std::string_view one = rest.substr(0, comma);
    rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
    return one;
  };
  spec.path = next();
  bool good = !spec.path.empty();
  while (good && !rest.empty()) {
    const std::string_view one = next();
    const auto equals = one.find('=');
    const std::string_view key = one.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? "" : one.substr(equals + 1);
    double number = 0;
    if (one == "echo") {
      spec.line.echo = true;
    } else if (key == "bit_rate" && read_number(value, 9600, 4.5e6, number)) {
      spec.line.bit_rate = static_cast<std::uint32_t>(number);
    } else if (key == "latency_ms" && read_number(value, 0, 50, number)) {
      spec.line.latency = hal::Duration{static_cast<std::int64_t>(number * 1e6)};
    } else if (key == "lost" && read_number(value, 0, 0.5, number)) {
      spec.lost = number;
    } else if (key == "delay_us" && read_number(value, 0, 508, number)) {
      spec.return_delay = static_cast<std::uint8_t>(number / 2);
    } else if (read_event(one, spec.events)) {
    } else {
      good = false;
    }
  }
  if (good) return spec;
  why =
      "'" + whole +
      "' is not PATH and then, with commas between them, any of bit_rate=9600..4500000, echo, latency_ms=0..50 (of the "
      "adapter), lost=0..0.5 (of the bytes), delay_us=0..508 (of the servos at first), reboot=ID@SECOND, "
      "off=ID@SECOND, overload=ID@SECOND, hot=ID@SECOND, gone@SECOND";
  return std::nullopt;
}

/// The line's thread sees a copy of the joint, and leaves the effort in it.
class WireLine::Joint final : public sim_hil::SimJoint {
 public:
  Joint(PlantJoints& joints, std::size_t index) : joints_(joints), index_(index) { exchange(); }
  double position_rad() const override { return motion_.position_rad; }
  double velocity_radps() const override { return motion_.velocity_radps; }
  void set_effort(double nm) override { effort_nm_ = nm; }
  void advance(hal::Duration) override {}  // the world does
  void exchange() {
    motion_ = joints_.motion(index_);
    joints_.drive(index_,
                  effort_nm_ == 0 ? JointDrive{} : JointDrive{.mode = DriveMode::effort, .effort_nm = effort_nm_});
  }

 private:
  PlantJoints& joints_;
  std::size_t index_;
  JointMotion motion_{};
  double effort_nm_ = 0;
};

WireLine::WireLine(hal::Os& os, std::unique_ptr<hal::Serial> end, WireLineSpec spec, int fifo_priority)
    : os_(os), end_(std::move(end)), spec_(std::move(spec)), fifo_priority_(fifo_priority) {}
WireLine::~WireLine() { clear(); }

void WireLine::clear() {
  ending_.store(true, std::memory_order_relaxed);  // joined below
  thread_.reset();
  servos_.clear();
  line_.reset();
}

sim_hil::SimDrive& WireLine::add(PlantJoints& joints, std::size_t index, const wire::ServoModel& model,
                                 std::uint32_t id, double zero_rad) {
  if (!line_) line_ = std::make_unique<sim_hil::SimSerialLine>(spec_.line, os_);
  sim_hil::SimSerialServo::Parameters p;
  p.id = static_cast<std::uint8_t>(id), p.model = &model, p.return_delay = spec_.return_delay;
  Servo& servo = servos_.emplace_back();
  servo.joint = std::make_unique<Joint>(joints, index);
  servo.servo =
      std::make_unique<sim_hil::SimSerialServo>(*line_, *servo.joint, sim_hil::SimMount{.zero_rad = zero_rad}, p);
  servo.id = id;
  servo.model = &model;
  return *servo.servo;
}

hal::Status WireLine::start() {
  if (!line_) line_ = std::make_unique<sim_hil::SimSerialLine>(spec_.line, os_);
  if (spec_.lost > 0)
    line_->set_tamper([this](std::uint8_t byte) -> std::optional<std::uint8_t> {
      return random_.uniform() < spec_.lost ? std::nullopt : std::optional(byte);
    });
  happened_.assign(spec_.events.size(), false);
  ending_.store(false, std::memory_order_relaxed);  // the thread is made after it
  hal::ThreadOptions options;
  options.name = "plant_line";
  options.fifo_priority = fifo_priority_;
  options.stack_bytes = std::size_t{256} * 1024;
  auto thread = os_.start_thread(options, [this] { run(); });
  if (!thread) return thread.error();
  thread_ = std::move(*thread);
  return {};
}

void WireLine::run() {
  std::array<std::uint8_t, 512> bytes;
  while (!ending_.load(std::memory_order_relaxed)) {
    Time next;
    {
      const std::lock_guard lock(mutex_);
      if (gone_) end_.reset();
      // Of a port that nobody has open an error: silence.
      const auto heard = end_ ? end_->read_now(bytes) : hal::Result<std::size_t>(std::size_t{0});
      if (heard && *heard > 0) static_cast<void>(line_->host().write_now({bytes.data(), *heard}));
      line_->advance(os_.now());
      const auto said = line_->host().read_now(bytes);
      if (end_ && said && *said > 0) static_cast<void>(end_->write_now({bytes.data(), *said}));  // full: lost
      next = std::min(line_->next(), os_.now() + kLineSleep);
    }
    // This thread alone takes the port away.
    if (!end_ || !end_->wait_readable(next)) os_.sleep_until(std::min(next, os_.now() + kNobody));
  }
}

void WireLine::step(Time plant_now) {
  const std::lock_guard lock(mutex_);
  for (Servo& servo : servos_) servo.joint->exchange();
  for (std::size_t i = 0; i < spec_.events.size(); ++i) {
    if (msg::seconds(plant_now) < spec_.events[i].at_s) continue;
    act(spec_.events[i], !happened_[i]);
    happened_[i] = true;
  }
}

void WireLine::act(const WireLineSpec::Event& event, bool first) {
  using Kind = WireLineSpec::Event::Kind;
  if (event.kind == Kind::gone) gone_ = true;
  for (Servo& s : servos_) {
    sim_hil::SimSerialServo& servo = *s.servo;
    if (s.id != event.id) continue;
    const auto fails = [&](std::uint32_t faults) { servo.fail(wire::servo_fault_bits(*s.model, faults)); };
    if (event.kind == Kind::reboot && first) servo.reboot(os_.now());
    if (event.kind == Kind::off && first) servo.power(false);
    if (event.kind == Kind::overload && servo.live()) fails(msg::kJointOverload);
    if (event.kind == Kind::hot && !servo.faulty()) fails(msg::kJointOverTemperature);
  }
}

}  // namespace sinew::plant
