// Two servos on one half-duplex line behind /dev/ttyUSB0, of each kind of packets. The port is hal/linux's; the line
// has its byte times.
#include <cerrno>

#include "math/random.hpp"
#include "msg/joints.hpp"
#include "rig.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::test {
namespace {

using sim_hil::SimSerialServo;

constexpr const char* kPath = "/dev/ttyUSB0";
class SerialJointRig final : public Rig {
 public:
  explicit SerialJointRig(const wire::ServoModel& model) : model_(model) {
    device = "head", measures = "joints";
    is_group = true;
    names = {kPath};
    specs.buses.push_back(table("neck", "serial", {{"path", std::string(kPath)}, {"latency_ms", 2.0}}));
    drivers::DeviceSpec head = table("head", "serial_servos", {});
    const std::string driver = model.maker == wire::ServoMaker::feetech ? "feetech" : "dynamixel";
    for (const std::int64_t id : {1, 2}) {
      head.joints.push_back(table(id == 1 ? "pan" : "tilt", driver,
                                  {{"model", std::string(model.name)},
                                   {"bus", std::string("neck")},
                                   {"id", id},
                                   {"max_velocity_radps", 4.0},
                                   {"min_rad", -1.4},
                                   {"max_rad", 1.4}}));
      servos_.push_back(add(joints_[static_cast<std::size_t>(id - 1)], id));
    }
    specs.devices.push_back(head);
    plug();
  }
  std::vector<Fault> faults() const override {
    std::vector<Fault> all = Rig::faults();
    all.insert(all.end(), {Fault::reboots, Fault::alarm});
    return all;
  }
  std::vector<Way> ways(Fault fault) const override {
    switch (fault) {
      case Fault::absent:
      case Fault::unplugged:
        return {{.label = "the line"}, {.label = "one servo"}};
      case Fault::garbage:
        return {{.label = "from one servo"},
                {.label = "noise on the line"},
                {.label = "one byte in 200 is wrong", .harmless = true}};
      case Fault::slow:
        return {{.label = "one byte in 200 is lost"}, {.label = "answers 16 ms late, as the adapter's timer has it"}};
      case Fault::duplicate:
        return {{.label = "a second servo of the same number, with the factory's return delay"},
                {.label = "a second servo of the same number, as it answers at once"},
                {.label = "the line echoes"}};
      case Fault::reboots:
        return {{.label = "once"}, {.label = "each second"}};
      case Fault::alarm:
        return {{.label = "overload, for as long as it has torque"}, {.label = "too hot"}};
      default:
        return {{}};
    }
  }
  void inject(Fault fault, std::size_t way) override {
    fault_ = fault, way_ = way, since_ = os.now();
    const bool line = way == 0;
    if (fault == Fault::absent || fault == Fault::unplugged) line ? unplug() : servos_[0]->power(false);
    if (fault == Fault::denied) kernel.refuse(kPath, EACCES);
    if (fault == Fault::busy) node_->held = true;
    servos_[0]->faults.silent = fault == Fault::silent;
    servos_[0]->faults.stuck = fault == Fault::stuck;
    servos_[0]->faults.garbage = fault == Fault::garbage && way == 0;
    if (fault == Fault::garbage && way > 0) disturb(way == 1 ? 0.5 : 0.005, false);
    if (fault == Fault::slow && way == 0) disturb(0.005, true);
    if (fault == Fault::slow && way == 1) line_.set_latency(16ms);
    if (fault == Fault::duplicate && way == 2) line_.set_echo(true);
    if (fault == Fault::duplicate && way < 2) {
      twins_joint_.place(0.7);
      twin_ = add(twins_joint_, 1);
      if (way == 1) twin_->set_number(model_.return_delay, 0);
    }
    if (fault == Fault::reboots) servos_[0]->reboot(os.now());
  }
  void heal() override {
    fault_.reset();
    if (!plugged_) plug();
    kernel.refuse(kPath, 0);
    node_->held = false;
    servos_[0]->power(true);
    servos_[0]->faults = {};
    servos_[0]->fail(0);
    line_.set_tamper({});
    line_.set_latency(0ms);
    line_.set_echo(false);
    if (twin_) twin_->power(false);
  }
  void advance(Time now) override {
    while (os.now() + kStep <= now) {
      os.run_until(os.now() + kStep);
      again();
      if (const auto heard = node_->heard(); plugged_ && !heard.empty()) (void)line_.host().write_now(heard);
      line_.advance(os.now());
      std::array<std::uint8_t, 512> bytes;
      if (const auto n = line_.host().read_now(bytes); n && *n > 0) node_->send({bytes.data(), *n});
    }
  }

 private:
  SimSerialServo* add(sim_hil::SimJoint& joint, std::int64_t id) {
    SimSerialServo::Parameters p;
    p.id = static_cast<std::uint8_t>(id), p.model = &model_, p.kp = 20;
    sims_.push_back(std::make_unique<SimSerialServo>(line_, joint, sim_hil::SimMount{}, p));
    return sims_.back().get();
  }
  void plug() {
    node_ = std::make_shared<SerialNode>();
    kernel.add(kPath, node_);
    line_.connect(true);
    plugged_ = true;
  }
  void unplug() {
    node_->unplug();
    kernel.remove(kPath);
    line_.connect(false);
    plugged_ = false;
  }
  /// This share of the bytes is lost, or any other byte.
  void disturb(double share, bool lost) {
    line_.set_tamper([this, share, lost](std::uint8_t byte) -> std::optional<std::uint8_t> {
      if (random_.uniform() >= share) return byte;
      return lost ? std::nullopt : std::optional(static_cast<std::uint8_t>(256 * random_.uniform()));
    });
  }
  /// What does not end by a reboot.
  void again() {
    SimSerialServo& servo = *servos_[0];
    if (fault_ == Fault::reboots && way_ == 1 && os.now() - since_ >= 1s) since_ = os.now(), servo.reboot(os.now());
    if (fault_ != Fault::alarm || servo.faulty()) return;
    if (way_ == 0 && !servo.live()) return;
    servo.fail(wire::servo_fault_bits(model_, way_ == 1 ? msg::kJointOverTemperature : msg::kJointOverload));
  }

  static constexpr Duration kStep = 200us;
  const wire::ServoModel& model_;
  sim_hil::SimSerialLine line_{{}, os};
  std::array<sim_hil::JointModel, 2> joints_;
  sim_hil::JointModel twins_joint_;
  std::vector<std::unique_ptr<SimSerialServo>> sims_;
  std::vector<SimSerialServo*> servos_;
  SimSerialServo* twin_ = nullptr;
  std::shared_ptr<SerialNode> node_;
  bool plugged_ = false;
  std::optional<Fault> fault_;
  std::size_t way_ = 0;
  Time since_{};
  math::Random random_{1};
};

}  // namespace

std::vector<RigKind> serial_joint_rigs() {
  std::vector<RigKind> rigs;
  for (const char* name : {"xm430_w350", "mx28", "sts3215"}) {
    const wire::ServoModel& model = *wire::servo_model(name);
    rigs.push_back({"serial_servos", "`serial_servos` with `" + std::string(name) + "`",
                    [&model] { return std::make_unique<SerialJointRig>(model); }});
  }
  return rigs;
}

}  // namespace sinew::test
