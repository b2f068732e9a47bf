// Servos on the kernel's CAN buses, for the VM bench: our drivers in one process, simulated servos in others, and only
// frames between them.
//
//   vm_servo_buses drives BIT_RATE:BUS:KIND:COUNT      servos 1..COUNT of one kind at the far end; until it is ended
//   vm_servo_buses master HZ TICKS ERRORS BIT_RATE:BUS:KIND:COUNT...
//
// KIND: cia402, ak80, damiao, cybergear. The master drives all of them through their hubs,
// and says on its output how far it is:
//   "running"   all joints are enabled; from here on each hub makes TICKS ticks, sees ERRORS error frames on the first
//               bus, and no joint may be lost
//   "arrived"   all joints are where they were told to go; now the drives of the last bus are to be ended
//   "alone"     the joints of the last bus are lost, and no other ever was; now they are to be started again
//   "again"     all joints are enabled again. Exit code 0.
// No frame may be lost, none be foreign, and no tick be late: for a guest whose time does not depend on the host.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/joints/cia402_servo.hpp"
#include "drivers/joints/cybergear_servo.hpp"
#include "drivers/joints/mit_servo.hpp"
#include "drivers/joints/servo_group.hpp"
#include "hal/linux/can/can.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_impedance.hpp"

namespace sinew::vm {
namespace {

using namespace std::chrono_literals;
using hal::Duration, hal::Time;

constexpr Duration kPatience = 10s, kLease = 500ms;
// The robot reads its buses before all else. The drives at the far end would have their own processor on a real robot:
// here they wait until a hub, which has 70, has sent all frames of a tick, so that these cost one change of threads and
// not five.
constexpr int kRobotsWatch = 72, kDrivesWatch = 60;
constexpr double kNear_rad = 0.05, kCountsPerTurn = 65536;

[[noreturn]] void give_up(const std::string& what) {
  std::printf("FAILED: %s\n", what.c_str());
  std::fflush(stdout);
  std::_Exit(1);
}

void say(const std::string& what) {
  std::printf("%s\n", what.c_str());
  std::fflush(stdout);
}

std::uint32_t number(std::string_view text) {
  std::uint32_t out = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), out).ec != std::errc())
    give_up(std::string(text) + " is no number");
  return out;
}

std::shared_ptr<hal::FdWatch> watch(int fifo_priority) {
  hal::ThreadOptions options;
  options.name = "watch";
  options.fifo_priority = fifo_priority;
  auto started = hal::FdWatch::start(hal::system_os(), options);
  if (!started) give_up("no watch");
  return *started;
}

std::unique_ptr<hal::CanBus> open_bus(const std::string& name, std::uint32_t bit_rate,
                                      const std::shared_ptr<hal::FdWatch>& watch) {
  hal::CanSpec spec;
  spec.transport = "socketcan", spec.address = name, spec.bit_rate = bit_rate;
  std::string why;
  auto bus = hal::open_can(spec, hal::system_os(), watch, why);
  if (!bus) give_up(why);
  if (!why.empty()) say(why);
  return std::move(*bus);
}

const wire::MitMotorType& mit_type(const std::string& kind) {
  const auto* type = wire::mit_motor_type(kind == "ak80" ? "ak80_9" : kind == "damiao" ? "dm4310" : "");
  if (!type) give_up(kind + ": cia402, ak80, damiao or cybergear");
  return *type;
}

/// "BIT_RATE:BUS:KIND:COUNT"
struct Place {
  explicit Place(const std::string& text) {
    const auto a = text.find(':'), b = text.find(':', a + 1), c = text.find(':', b + 1);
    if (c == text.npos) give_up(text + ": BIT_RATE:BUS:KIND:COUNT");
    bit_rate = number(text.substr(0, a));
    bus = text.substr(a + 1, b - a - 1);
    kind = text.substr(b + 1, c - b - 1);
    count = number(text.substr(c + 1));
  }
  std::string bus, kind;
  std::uint32_t bit_rate = 0, count = 0;
};

int drives(const Place& place) {
  hal::Os& os = hal::system_os();
  const std::string& kind = place.kind;
  const auto bus = open_bus(place.bus, place.bit_rate, watch(kDrivesWatch));
  sim_hil::SimServos servos(*bus);
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  for (std::uint32_t id = 1; id <= place.count; ++id) {
    sim_hil::JointModel& joint = *joints.emplace_back(std::make_unique<sim_hil::JointModel>());
    if (kind == "cia402") {
      sim_hil::SimCia402::Parameters p;
      p.node_id = id, p.counts_per_turn = kCountsPerTurn;
      servos.add<sim_hil::SimCia402>(joint, {}, p);
    } else if (kind == "cybergear") {
      servos.add<sim_hil::SimCyberGear>(joint, {}, sim_hil::SimCyberGear::Parameters{id, 0xC0FFEE00 + id});
    } else {
      servos.add<sim_hil::SimMitMotor>(joint, {}, sim_hil::SimMitMotor::Parameters{id, 0, mit_type(kind), kLease});
    }
  }
  for (;;) {
    servos.poll(os.now());
    os.sleep_until(os.now() + 1ms);
  }
}

/// One bus of the robot, with a group of joints that is on it alone.
struct Line {
  Line(const std::string& bus_name, std::uint32_t bit_rate, double hz, const std::shared_ptr<hal::FdWatch>& watch)
      : name(bus_name),
        bus(open_bus(name, bit_rate, watch)),
        group(hal::system_os(), name),
        hub(hal::system_os(), *bus, config(name, hz)) {}
  static drivers::CanHubConfig config(const std::string& bus_name, double hz) {
    drivers::CanHubConfig c;
    c.name = bus_name, c.tick_hz = hz, c.max_load = 0.95;
    c.thread.name = bus_name, c.thread.fifo_priority = 70;
    return c;
  }
  void add(const std::string& kind, std::uint32_t id) {
    drivers::ServoConfig c;
    c.name = name + "_" + std::to_string(id), c.node_id = id;
    c.kp = 60, c.kd = 2;
    c.limits = {-3, 3, 10, 2};
    c.feedback_timeout = 200ms;
    c.following.time = 10s;
    std::unique_ptr<drivers::ServoProtocol> servo;
    std::string wrong;
    if (kind == "cia402") {
      if (id == 1) hub.add(std::make_unique<drivers::CanopenMaster>());
      c.counts_per_turn = kCountsPerTurn;
      const drivers::Cia402Options options{.tick_hz = hub.config().tick_hz};
      wrong = to_string(drivers::check_cia402(c, options));
      servo = std::make_unique<drivers::Cia402Servo>(c, options);
    } else if (kind == "cybergear") {
      wrong = to_string(drivers::check_cybergear(c, 0xFD));
      servo = std::make_unique<drivers::CyberGearServo>(c);
    } else {
      const drivers::MitOptions options{mit_type(kind), 0};
      wrong = to_string(drivers::check_mit(c, options));
      servo = std::make_unique<drivers::MitServo>(c, options);
    }
    if (!wrong.empty()) give_up(wrong);
    if (!group.add(hub, std::move(servo))) give_up(name + ": too many joints");
  }
  std::uint32_t all() const { return (1u << group.size()) - 1; }
  bool ready() const { return state.count == group.size() && state.ready == all(); }

  std::string name;
  std::unique_ptr<hal::CanBus> bus;
  drivers::ServoGroup group;
  drivers::CanHub hub;
  msg::JointState state;
  std::uint64_t samples = 0, samples_not_ready = 0;
};

class Master {
 public:
  explicit Master(double hz) : period_(static_cast<std::int64_t>(1e9 / hz)), hz_(hz) {}
  void add(const Place& place) {
    lines_.push_back(std::make_unique<Line>(place.bus, place.bit_rate, hz_, watch_));
    for (std::uint32_t id = 1; id <= place.count; ++id) lines_.back()->add(place.kind, id);
  }
  void start() {
    if (const auto locked = hal::system_os().lock_memory(); !locked) give_up("memory is not locked");
    for (auto& line : lines_) {
      std::string why;
      if (!line->hub.configure(why)) give_up(why);
      if (!line->hub.start()) give_up(line->name + ": no thread");
    }
    next_ = hal::system_os().now();
  }
  /// Makes cycles until `holds`, or prints what did not happen.
  template <class F>
  void until(const char* what, F&& holds) {
    const Time deadline = hal::system_os().now() + kPatience;
    while (!holds()) {
      if (hal::system_os().now() > deadline) {
        report();
        give_up(std::string("not within ten seconds: ") + what);
      }
      cycle();
    }
  }
  void sway(bool on) { sway_ = on; }
  std::vector<std::unique_ptr<Line>>& lines() { return lines_; }
  double target(std::size_t line, std::size_t joint) const {
    const double place = 0.2 + 0.1 * static_cast<double>(joint) + 0.05 * static_cast<double>(line);
    return sway_ ? place * std::sin(static_cast<double>(cycles_) / hz_ * 3) : place;
  }
  void report() const {
    for (const auto& line : lines_) {
      const auto hub = line->hub.stats();
      const auto bus = line->bus->stats();
      std::printf(
          "%s: %zu joints, ready %x, %llu ticks (%llu late), load planned %.0f %%, measured %.0f %%, %llu frames in, "
          "%llu out, %llu lost in, %llu lost out, %llu error frames, %llu unknown, %llu malformed\n",
          line->name.c_str(), line->group.size(), line->state.ready, count(hub.ticks), count(hub.late_ticks),
          100 * hub.planned_load, 100 * hub.measured_load, count(bus.received), count(bus.sent), count(bus.rx_lost),
          count(bus.tx_lost), count(bus.error_frames), count(hub.unknown), count(hub.malformed));
      for (std::size_t i = 0; i < line->state.count; ++i)
        if ((line->state.ready & 1u << i) == 0)
          std::printf("  joint %zu: mode %u, faults %x, code %x\n", i, static_cast<unsigned>(line->state.mode[i]),
                      line->state.faults[i], line->state.fault_code[i]);
    }
    std::fflush(stdout);
  }

 private:
  static unsigned long long count(std::uint64_t n) { return n; }
  /// Writes setpoints and reads the joints' feedback, as a control loop does.
  void cycle() {
    ++cycles_;
    for (std::size_t l = 0; l < lines_.size(); ++l) {
      Line& line = *lines_[l];
      msg::ActuatorCommand command;
      command.stamp = hal::system_os().now();
      command.count = static_cast<std::uint32_t>(line.group.size());
      command.armed = 1;
      for (std::size_t j = 0; j < line.group.size(); ++j) command.value[j] = target(l, j);
      if (!line.group.write(command, kLease)) give_up(line.name + ": refuses setpoints");
      for (auto got = line.group.read(line.state); got && *got; got = line.group.read(line.state)) {
        ++line.samples;
        if (!line.ready()) ++line.samples_not_ready;
      }
    }
    next_ = std::max(next_ + period_, hal::system_os().now());
    hal::system_os().sleep_until(next_);
  }

  const std::shared_ptr<hal::FdWatch> watch_ = watch(kRobotsWatch);
  const Duration period_;
  const double hz_;
  std::vector<std::unique_ptr<Line>> lines_;
  Time next_{};
  std::uint64_t cycles_ = 0;
  bool sway_ = false;
};

bool all_ready(Master& m) {
  return std::all_of(m.lines().begin(), m.lines().end(), [](const auto& line) { return line->ready(); });
}

bool all_near(Master& m) {
  for (std::size_t l = 0; l < m.lines().size(); ++l)
    for (std::size_t j = 0; j < m.lines()[l]->group.size(); ++j)
      if (!(std::abs(m.lines()[l]->state.position_rad[j] - m.target(l, j)) < kNear_rad)) return false;
  return true;
}

/// Nothing was lost on the way, and nothing came too late.
void expect_nothing_lost(Master& m) {
  for (const auto& line : m.lines()) {
    const auto hub = line->hub.stats();
    const auto bus = line->bus->stats();
    if (hub.late_ticks + hub.unknown + hub.malformed + bus.rx_lost + bus.tx_lost == 0) continue;
    m.report();
    give_up(line->name + ": ticks were late, or frames were lost or foreign");
  }
}

/// No joint of these lines was lost since the counts were cleared, and there were samples.
void expect_always_ready(Master& m, std::size_t lines) {
  for (std::size_t l = 0; l < lines; ++l) {
    const Line& line = *m.lines()[l];
    if (line.samples == 0) give_up(line.name + ": no samples");
    if (line.samples_not_ready > 0) {
      m.report();
      give_up(line.name + ": not ready in " + std::to_string(line.samples_not_ready) + " samples");
    }
  }
}

int master(double hz, std::uint64_t ticks, std::uint64_t errors, const std::vector<std::string>& buses) {
  Master m(hz);
  for (const auto& bus : buses) m.add(Place(bus));
  m.start();
  m.until("all joints enabled", [&] { return all_ready(m); });
  m.sway(true);
  std::vector<std::uint64_t> from;
  for (auto& line : m.lines()) {
    line->samples = line->samples_not_ready = 0;
    from.push_back(line->hub.stats().ticks);
  }
  say("running");
  m.until("so many ticks and error frames", [&] {
    for (std::size_t l = 0; l < m.lines().size(); ++l)
      if (m.lines()[l]->hub.stats().ticks < from[l] + ticks) return false;
    return m.lines()[0]->bus->stats().error_frames >= errors;
  });
  expect_always_ready(m, m.lines().size());
  for (std::size_t l = 0; l < m.lines().size(); ++l)
    if (m.lines()[l]->bus->stats().error_frames != (l == 0 ? errors : 0)) give_up("error frames that nobody sent");
  m.sway(false);
  m.until("all joints at their places", [&] { return all_near(m); });
  expect_nothing_lost(m);
  m.report();
  say("arrived");
  m.until("the last bus silent", [&] { return m.lines().back()->state.ready == 0; });
  expect_always_ready(m, m.lines().size() - 1);
  say("alone");
  m.until("all joints enabled again", [&] { return all_ready(m) && all_near(m); });
  expect_always_ready(m, m.lines().size() - 1);
  expect_nothing_lost(m);
  m.report();
  say("again");
  for (auto& line : m.lines()) line->hub.stop();
  return 0;
}

}  // namespace
}  // namespace sinew::vm

int main(int argc, char** argv) {
  using namespace sinew::vm;
  const std::vector<std::string> a(argv + 1, argv + argc);
  if (a.size() == 2 && a[0] == "drives") return drives(Place(a[1]));
  if (a.size() > 4 && a[0] == "master")
    return master(number(a[1]), number(a[2]), number(a[3]), {a.begin() + 4, a.end()});
  std::fprintf(
      stderr,
      "usage: vm_servo_buses drives BIT_RATE:BUS:KIND:COUNT | master HZ TICKS ERRORS BIT_RATE:BUS:KIND:COUNT...\n");
  return 2;
}
