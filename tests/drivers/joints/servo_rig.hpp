#pragma once
// Joints behind real drivers and simulated servos on buses in memory, in virtual time.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/joints/cia402_servo.hpp"
#include "drivers/joints/cybergear_servo.hpp"
#include "drivers/joints/mit_servo.hpp"
#include "drivers/joints/servo_group.hpp"
#include "rt/trap.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_cia402.hpp"
#include "sim_hil/wire/sim_impedance.hpp"

namespace sinew::drivers {

using namespace std::chrono_literals;

/// Time that stands still until it is moved; no threads.
class StillOs final : public hal::Os {
 public:
  Time now() const noexcept override { return clock.now(); }
  void sleep_until(Time) noexcept override {}
  void wait(hal::WakeWord&, std::uint32_t, Time) noexcept override {}
  void wake(hal::WakeWord&) noexcept override {}
  Duration thread_cpu_time() noexcept override { return {}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions&, std::function<void()>) override {
    return hal::Error{hal::Errc::not_supported, "no threads here"};
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return hal::Error{hal::Errc::not_supported, "no memory here"};
  }
  hal::Status lock_memory() override { return {}; }
  hal::ManualClock clock;
};

enum class Protocol { cia402, ak80, damiao, cybergear };
inline const char* name_of(Protocol p) {
  const char* names[] = {"Cia402", "Ak80", "Damiao", "CyberGear"};
  return names[static_cast<int>(p)];
}

/// The bus in memory locks and allocates, unlike a real bus: the trap is off in there, and only there.
class Untrapped final : public hal::CanBus {
 public:
  explicit Untrapped(hal::CanBus& bus) : bus_(bus) {}
  hal::Result<bool> read(msg::CanFrame& out) noexcept override {
    const rt::trap::Scope off(nullptr);
    auto got = bus_.read(out);
    if (got && *got && tamper) tamper(out);
    return got;
  }
  hal::Status send(const msg::CanFrame& frame, Time deadline) noexcept override {
    const rt::trap::Scope off(nullptr);
    return bus_.send(frame, deadline);
  }
  hal::Status set_filters(std::span<const hal::CanFilter> filters) override { return bus_.set_filters(filters); }
  void set_wake(hal::Wake* wake) noexcept override { bus_.set_wake(wake); }
  hal::CanStats stats() const noexcept override { return bus_.stats(); }
  std::uint32_t bit_rate() const noexcept override { return bus_.bit_rate(); }
  std::function<void(msg::CanFrame&)> tamper;  // changes what the hub reads

 private:
  hal::CanBus& bus_;
};

/// One bus with its hub and the simulated servos at its other end.
struct RigBus {
  RigBus(StillOs& os, const CanHubConfig& config, std::uint32_t bit_rate)
      : wire(bit_rate, &os.clock),
        port(wire.attach()),
        far(wire.attach()),
        sims(far),
        bus(port),
        hub(os, bus, config) {}
  /// As on the hub's thread: a call in there that allocates, locks or blocks ends the test.
  Time step(Time now) {
    const rt::trap::Scope trap("hub");
    return hub.step(now);
  }
  sim_hil::MemoryCan wire;
  sim_hil::MemoryCanPort &port, &far;
  sim_hil::SimServos sims;
  Untrapped bus;
  CanHub hub;
  bool has_master = false;
};

class ServoRig {
 public:
  explicit ServoRig(const CanHubConfig& config = {}, int buses = 1, std::uint32_t bit_rate = 1'000'000) {
    os.clock.set({1'000'000'000});
    for (int i = 0; i < buses; ++i) bus.push_back(std::make_unique<RigBus>(os, config, bit_rate));
    groups.push_back(std::make_unique<ServoGroup>(os, "joints"));
  }
  ~ServoRig() { bus.clear(); }

  /// The configuration that most tests use for a joint with this number.
  static ServoConfig plain(Protocol protocol, std::uint32_t id) {
    ServoConfig c;
    c.name = "joint" + std::to_string(id);
    c.node_id = id;
    c.kp = 60;
    c.kd = 2;
    c.limits = {-3, 3, 10, 2};
    if (protocol == Protocol::cia402) c.counts_per_turn = 65536;
    return c;
  }

  /// One more joint of the last group, with a servo at the other end.
  sim_hil::SimServo& add(Protocol protocol, ServoConfig c, std::size_t b = 0) {
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    add_driver(protocol, c, b);
    return add_sim(protocol, c, *joints.back(), b);
  }
  void add_driver(Protocol protocol, const ServoConfig& c, std::size_t b) {
    std::unique_ptr<ServoProtocol> servo;
    std::string wrong;
    if (protocol == Protocol::cia402) {
      if (!bus[b]->has_master) bus[b]->hub.add(std::make_unique<CanopenMaster>());
      bus[b]->has_master = true;
      const Cia402Options options{
          .tick_hz = bus[b]->hub.config().tick_hz, .temperature_object = {0x2300, 1}, .temperature_unit_c = 0.1};
      wrong = to_string(check_cia402(c, options));
      servo = std::make_unique<Cia402Servo>(c, options);
    } else if (protocol == Protocol::cybergear) {
      wrong = to_string(check_cybergear(c, 0xFD));
      servo = std::make_unique<CyberGearServo>(c);
    } else {
      const MitOptions options = mit(protocol);
      wrong = to_string(check_mit(c, options));
      servo = std::make_unique<MitServo>(c, options);
    }
    EXPECT_EQ(wrong, "");
    ASSERT_TRUE(groups.back()->add(bus[b]->hub, std::move(servo)));
  }
  sim_hil::SimServo& add_sim(Protocol protocol, const ServoConfig& c, sim_hil::SimJoint& joint, std::size_t b = 0) {
    const sim_hil::SimMount mount{c.sign, c.gear_ratio, c.zero_rad};
    sim_hil::SimServos& sims = bus[b]->sims;
    if (protocol == Protocol::cia402) {
      sim_hil::SimCia402::Parameters p;
      p.node_id = c.node_id;
      p.counts_per_turn = c.counts_per_turn;
      return sims.add<sim_hil::SimCia402>(joint, mount, p);
    }
    if (protocol == Protocol::cybergear) {
      return sims.add<sim_hil::SimCyberGear>(joint, mount, sim_hil::SimCyberGear::Parameters{c.node_id, 0xC0FFEE});
    }
    return sims.add<sim_hil::SimMitMotor>(joint, mount,
                                          sim_hil::SimMitMotor::Parameters{c.node_id, 0, mit(protocol).type, 100ms});
  }
  static MitOptions mit(Protocol p) { return {*wire::mit_motor_type(p == Protocol::ak80 ? "ak80_9" : "dm4310"), 0}; }

  void configure() {
    for (auto& b : bus) {
      std::string why;
      ASSERT_TRUE(b->hub.configure(why)) << why;
    }
  }

  /// Lets time pass; with `drive`, setpoints are written every 2 ms, as a control loop does.
  void run(Duration duration, bool drive = true) {
    const Time end = os.now() + duration;
    while (os.now() < end) {
      if (drive && ++steps % 4 == 0) write(100ms);
      step();
    }
  }
  void step() {
    os.clock.set(os.now() + 500us);
    for (auto& b : bus) {
      b->sims.poll(os.now());
      b->step(os.now());
      b->sims.poll(os.now());  // answers while it is still now
      b->step(os.now());
    }
    for (auto& group : groups) {
      while (true) {
        const rt::trap::Scope trap("reader");
        const auto got = group->read(sample);
        if (!got || !*got) break;
        ++samples;
      }
    }
  }
  void write(Duration lease) {
    std::size_t at = 0;
    for (auto& group : groups) {
      msg::ActuatorCommand command;
      command.count = static_cast<std::uint32_t>(group->size());
      command.armed = 1;
      for (std::size_t i = 0; i < group->size(); ++i) command.value[i] = setpoint[at++];
      bool written = false;
      {
        const rt::trap::Scope trap("guardian");
        written = group->write(command, lease).has_value();
      }
      ASSERT_TRUE(written);
    }
  }
  /// Until joint i is in this mode, at most ten seconds of virtual time. False: never.
  bool until(std::size_t i, msg::JointMode mode, bool drive = true) {
    const Time end = os.now() + 10s;
    while (os.now() < end) {
      run(2ms, drive);
      if (sample.count > i && sample.mode[i] == mode) return true;
    }
    return false;
  }

  StillOs os;
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  std::vector<std::unique_ptr<ServoGroup>> groups;
  std::vector<std::unique_ptr<RigBus>> bus;
  std::array<double, 64> setpoint{};
  msg::JointState sample;  // the last one
  std::uint64_t samples = 0;
  int steps = 0;
  ServoGroup& group() { return *groups.front(); }
};

}  // namespace sinew::drivers
