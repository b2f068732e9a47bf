#include "robot.hpp"

#include "drivers/board/driver_list.hpp"
#include "robot_modules.hpp"
#include "rt/guardian.hpp"
#include "rt/safety_text.hpp"

namespace sinew::test {
namespace {

template <class Source, class M>
void add_pair(rt::ModuleTypes& types, Seen& seen) {
  types.add<Source>("test::Source");
  types.add("test::Watch", [&seen] { return std::make_unique<Watch<M>>(seen); });
}

void add_source(const std::string& measures, rt::ModuleTypes& types, Seen& seen) {
  if (measures == "imu") add_pair<drivers::ImuSource, msg::ImuSample>(types, seen);
  if (measures == "baro") add_pair<drivers::BaroSource, msg::BaroSample>(types, seen);
  if (measures == "mag") add_pair<drivers::MagSource, msg::MagSample>(types, seen);
  if (measures == "battery") add_pair<drivers::BatterySource, msg::BatterySample>(types, seen);
  if (measures == "range") add_pair<drivers::RangeSource, msg::RangeSample>(types, seen);
  if (measures == "gnss") add_pair<drivers::GnssSource, msg::GnssSample>(types, seen);
  if (measures == "rc") add_pair<drivers::RcSource, msg::RcSample>(types, seen);
  if (measures == "joints") add_pair<drivers::JointSource, msg::JointState>(types, seen);
  if (measures == "camera") add_pair<drivers::CameraSource, msg::Image>(types, seen);
}

rt::ModuleSpec module(const std::string& name, const std::string& type) {
  rt::ModuleSpec m;
  m.name = name, m.type = type;
  m.exec = {rt::ExecModel::Kind::constant, 10us, {}, 1.0};
  return m;
}

rt::ThreadSpec thread(const std::string& name, int priority, Duration period, const std::vector<std::string>& order) {
  rt::ThreadSpec t;
  t.name = name, t.priority = priority, t.period = period;
  for (const std::string& m : order) t.order.push_back({m, 0});
  return t;
}

}  // namespace

Robot::Robot(Rig& rig) : rig_(rig) {
  add_modules();
  add_failsafes();
  board_ = std::make_unique<drivers::DeviceBoard>(rig.specs, drivers::all_drivers(), rig.connectors, rig.os);
  graph_ = std::make_unique<rt::Graph>(spec_, types_);
}
Robot::~Robot() = default;

void Robot::add_modules() {
  spec_.robot = "matrix", spec_.board = "linux";
  add_source(rig_.measures, types_, seen);
  types_.add("test::Controller", [this] { return std::make_unique<Controller>(setpoint); });
  spec_.modules = {module(rig_.measures, "test::Source"), module("watch", "test::Watch"),
                   module("controller", "test::Controller")};
  spec_.modules[0].params["device"] = {rt::ParamValue{rig_.device}, 0};
  spec_.modules[1].in["in"] = {rig_.measures + ".raw", 0};
  spec_.modules[2].in["safety"] = {"guardian.state", 0};
  spec_.threads = {thread("sensing", 50, 4ms, {rig_.measures, "watch"}), thread("control", 40, 10ms, {"controller"})};
  if (rig_.measures == "camera") {
    rt::TopicSpec images;
    images.name = "camera.raw";
    images.image_bytes = 320 * 240 * 3;
    spec_.topics.push_back(images);
  }
  rt::ActuatorSpec group;
  group.name = rig_.is_group ? "head" : "motors";
  group.command = {"controller.out", 0};
  group.channels = 2;
  group.min = -1, group.max = 1;
  group.lease = 50ms;
  spec_.actuators.push_back(group);
  spec_.guardian.arming = rt::GuardianSpec::Arming::manual;
}

void Robot::add_failsafes() {
  using Kind = rt::FailsafeSpec::Kind;
  const std::string& m = rig_.measures;
  const auto add = [&](const char* what, Kind kind, Duration time) -> rt::FailsafeSpec& {
    rt::FailsafeSpec f;
    f.name = m + "_" + what;
    f.topic = {m + ".raw", 0};
    f.kind = kind, f.time = time;
    f.action = msg::FailsafeAction::stop;
    spec_.failsafes.push_back(f);
    return spec_.failsafes.back();
  };
  const auto out_of = [&](const char* field, double below, double above) {
    rt::FailsafeSpec& f = add("nonsense", Kind::value, 20ms);
    f.field = {field, 0};
    f.below = below, f.above = above;
  };
  const bool is_slow = m == "gnss" || m == "rc";
  add("silent", Kind::silent, is_slow ? 1000ms : m == "camera" ? 500ms : 200ms);
  if (m != "camera") add("stuck", Kind::stuck, is_slow ? 2000ms : 400ms);
  if (m == "imu") out_of("gyro_radps.x", -20, 20);
  if (m == "battery") out_of("voltage_v", 14, 17);
  if (m == "joints") out_of("position_rad[0]", -1.6, 1.6);
  if (m == "rc") {
    rt::FailsafeSpec& f = add("lost", Kind::value, 300ms);
    f.field = {"lost", 0};
    f.above = 0.5;
  }
}

std::vector<std::string> Robot::open() {
  for (const rt::Problem& p : check_devices(rig_.specs, drivers::all_drivers())) return {rt::to_string(p, "robot")};
  for (const rt::Problem& p : graph_->check({.virtual_time = true})) return {rt::to_string(p, "robot")};
  const auto configured = graph_->configure(*this, {.taps = {"guardian.state"}});
  const auto started = configured ? board_->start() : configured;
  std::vector<std::string> texts;
  if (started) return texts;
  std::string all = board_->problem() + "\n";
  for (std::size_t end; (end = all.find('\n')) != std::string::npos; all.erase(0, end + 1))
    if (end > 0) texts.push_back(all.substr(0, end));
  if (texts.empty()) texts.push_back(std::string("(no text) ") + started.error().where);
  return texts;
}

hal::Result<hal::Actuators*> Robot::actuators(std::string_view name) {
  if (rig_.is_group) return board_->actuators(name);
  return &motors;
}

void Robot::run(Script& script) {
  script_ = &script;
  latch_ = std::make_unique<rt::Latch>(graph_->segment());
  latch_->bind(safety_, graph_->taps()[0]);
  rt::DiscreteOptions options;
  options.start = rig_.os.now();
  rt::DiscreteExecutor executor(*graph_, rig_.os.clock, *this, options);
  (void)executor.run();  // ends when the script says so
}

hal::Result<Time> Robot::next_grant(Time done_to) {
  rig_.os.clock.set(done_to);
  latch_->latch();
  if (const auto* s = safety_.get()) state_ = *s;
  latch_->release();
  if (!script_->at(done_to)) return hal::Error{hal::Errc::closed, "end of the script"};
  const Time next = done_to + kStep;
  rig_.advance(next);
  rig_.os.run_until(next);
  return next;
}

std::vector<std::string> Robot::reasons() const { return rt::not_ready(spec_, state_); }

}  // namespace sinew::test
