// Two joints on one bus in memory, of each protocol; their drives and joints are simulated, SocketCAN is hal/linux's.
#include <cerrno>

#include "hal/linux/can/can.hpp"
#include "hal/platform.hpp"
#include "rig.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_dronecan.hpp"
#include "sim_hil/wire/sim_impedance.hpp"

namespace sinew::test {
namespace {

using sim_hil::MemoryCan, sim_hil::SimServo, sim_hil::SimServos;
using Keys = std::map<std::string, rt::ParamValue>;

/// The interface is called so here, as a machine that tests may have a can0.
constexpr const char *kInterface = "nocan0", *kOnARobot = "can0";

struct Protocol {
  std::string driver;
  Keys keys;
  SimServo& (*add)(SimServos& sims, sim_hil::SimJoint& joint, std::uint32_t id);
};

class Port final : public hal::CanBus {
 public:
  explicit Port(hal::CanBus& port) : port_(port) {}
  hal::Result<bool> read(msg::CanFrame& out) noexcept override { return port_.read(out); }
  hal::Status send(const msg::CanFrame& f, Time deadline) noexcept override { return port_.send(f, deadline); }
  hal::Status set_filters(std::span<const hal::CanFilter> f) override { return port_.set_filters(f); }
  void set_wake(hal::Wake* wake) noexcept override { port_.set_wake(wake); }
  hal::CanStats stats() const noexcept override { return port_.stats(); }
  std::uint32_t bit_rate() const noexcept override { return port_.bit_rate(); }

 private:
  hal::CanBus& port_;
};

class JointRig final : public Rig {
 public:
  JointRig(const Protocol& protocol, bool by_joints_of) : protocol_(protocol) {
    device = by_joints_of ? "joints" : "head";
    measures = "joints";
    is_group = true;
    names = {kInterface};
    if (by_joints_of) specs.devices.push_back(table("joints", "joints_of", {{"group", std::string("head")}}));
    specs.buses.push_back(table("can0", "socketcan", {{"address", std::string(kInterface)}}));
    drivers::DeviceSpec head = table("head", "can_servos", {});
    for (const std::int64_t id : {1, 2}) {
      Keys keys = protocol.keys;
      keys["bus"] = std::string("can0"), keys["id"] = id;
      keys["max_velocity_radps"] = 20.0;
      if (protocol.driver == "dronecan") keys["actuator_id"] = id;
      head.joints.push_back(table(id == 1 ? "pan" : "tilt", protocol.driver, keys));
      servos_.push_back(
          &protocol.add(sims_, joints_[static_cast<std::size_t>(id - 1)], static_cast<std::uint32_t>(id)));
    }
    specs.devices.push_back(head);
    connectors.open_can = [this](const hal::CanSpec& spec,
                                 std::string& why) -> hal::Result<std::unique_ptr<hal::CanBus>> {
      if (!real_socket_) return std::unique_ptr<hal::CanBus>(std::make_unique<Port>(wire_.attach()));
      hal::ThreadOptions options;
      options.name = "watch";
      auto watch = hal::FdWatch::start(hal::system_os(), options);
      if (!watch) return watch.error();
      return hal::open_can(spec, os, *watch, why);
    };
  }
  std::vector<Way> ways(Fault fault) const override {
    if (fault == Fault::absent || fault == Fault::unplugged) return {{.label = "the bus"}, {.label = "one drive"}};
    if (fault == Fault::busy) return {{.cannot = {Reason::shared}}};
    if (fault == Fault::slow) return {{.label = "half of its frames are lost"}};
    if (fault == Fault::duplicate) return {{.label = "a second drive of the same number"}};
    return {{}};
  }
  void inject(Fault fault, std::size_t way) override {
    if (fault == Fault::absent && way == 0) real_socket_ = true;
    if (fault == Fault::denied) real_socket_ = true, kernel.can_socket_errno = EPERM;
    if (fault == Fault::unplugged && way == 0) wire_.connect(false);
    if ((fault == Fault::absent || fault == Fault::unplugged) && way == 1) servos_[0]->power(false);
    servos_[0]->faults.silent = fault == Fault::silent;
    servos_[0]->faults.garbage = fault == Fault::garbage;
    servos_[0]->faults.stuck = fault == Fault::stuck;
    servos_[0]->faults.lost = fault == Fault::slow ? 0.5 : 0;
    if (fault != Fault::duplicate) return;
    twins_joint_.place(0.7);
    twin_ = &protocol_.add(sims_, twins_joint_, 1);
  }
  void heal() override {
    real_socket_ = false;
    kernel.can_socket_errno = 0;
    wire_.connect(true);
    servos_[0]->power(true);
    servos_[0]->faults = {};
    if (twin_) twin_->power(false);
  }
  void advance(Time now) override {
    while (os.now() + kStep <= now) {
      os.run_until(os.now() + kStep);
      sims_.poll(os.now());
    }
  }
  std::string as_on_a_robot(std::string text) const override {
    for (std::size_t at; (at = text.find(kInterface)) != std::string::npos;)
      text.replace(at, std::string(kInterface).size(), kOnARobot);
    return text;
  }

 private:
  static constexpr Duration kStep = 500us;
  const Protocol protocol_;
  MemoryCan wire_{1'000'000, &os.clock};
  SimServos sims_{wire_.attach()};
  std::array<sim_hil::JointModel, 2> joints_;
  sim_hil::JointModel twins_joint_;
  std::vector<SimServo*> servos_;
  SimServo* twin_ = nullptr;
  bool real_socket_ = false;
};

SimServo& add_cia402(SimServos& sims, sim_hil::SimJoint& joint, std::uint32_t id) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = id;
  p.serial = 1000 + id;
  return sims.add<sim_hil::SimCia402>(joint, sim_hil::SimMount{}, p);
}
SimServo& add_mit(SimServos& sims, sim_hil::SimJoint& joint, std::uint32_t id) {
  return sims.add<sim_hil::SimMitMotor>(
      joint, sim_hil::SimMount{}, sim_hil::SimMitMotor::Parameters{id, 0, *wire::mit_motor_type("ak80_9"), 100ms});
}
SimServo& add_cybergear(SimServos& sims, sim_hil::SimJoint& joint, std::uint32_t id) {
  return sims.add<sim_hil::SimCyberGear>(joint, sim_hil::SimMount{}, sim_hil::SimCyberGear::Parameters{id, 0xC0FFEE});
}
SimServo& add_dronecan(SimServos& sims, sim_hil::SimJoint& joint, std::uint32_t id) {
  sim_hil::SimDronecanServo::Parameters p;
  p.node_id = static_cast<std::uint8_t>(id);
  p.actuator_id = static_cast<std::uint8_t>(id);
  p.unique_id[0] = static_cast<std::uint8_t>(id);
  return sims.add<sim_hil::SimDronecanServo>(joint, sim_hil::SimMount{}, p);
}

}  // namespace

std::vector<RigKind> joint_rigs() {
  const Keys gains{{"kp", 60.0}, {"kd", 2.0}};
  Keys mit = gains;
  mit["motor"] = std::string("ak80_9");
  const std::vector<Protocol> protocols{
      {"cia402", {{"counts_per_turn", std::int64_t{65536}}, {"rated_effort_nm", 2.0}}, add_cia402},
      {"mit", mit, add_mit},
      {"cybergear", gains, add_cybergear},
      {"dronecan", {{"on_stop", std::string("hold")}}, add_dronecan}};
  std::vector<RigKind> rigs;
  for (const Protocol& p : protocols)
    rigs.push_back(
        {"can_servos", "`can_servos` with `" + p.driver + "`", [p] { return std::make_unique<JointRig>(p, false); }});
  rigs.push_back({"joints_of", "`joints_of`", [p = protocols[0]] { return std::make_unique<JointRig>(p, true); }});
  return rigs;
}

}  // namespace sinew::test
