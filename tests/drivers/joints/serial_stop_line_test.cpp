// The stop line to serial servos when their runtime is dead, in virtual time: simulated servos hear it.
#include "drivers/joints/serial_stop_line.hpp"

#include <gmock/gmock.h>

#include "../no_connectors.hpp"
#include "servo_rig.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::drivers::serial_stop_line_test {
namespace {

using ::testing::HasSubstr;

/// The far end of a line; the runtime may hold it.
class FarEnd final : public hal::Serial {
 public:
  explicit FarEnd(hal::Serial& line) : line_(line) {}
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override { return line_.read_now(into); }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> b) noexcept override { return line_.write_now(b); }
  hal::Status set_bit_rate(std::uint32_t rate) noexcept override { return line_.set_bit_rate(rate); }
  hal::Result<bool> wait_readable(Time t) noexcept override { return line_.wait_readable(t); }

 private:
  hal::Serial& line_;
};

/// Two lines with servos that a runtime, now dead, has left moving.
class SerialStopLineTest : public testing::Test, public hal::Os, public test::NoConnectors {
 protected:
  struct Wire {
    Wire(const hal::Clock& clock, bool echo) : line({.echo = echo, .latency = 1ms}, clock) {}
    sim_hil::SimSerialLine line;
    bool held = false;  // by the runtime, which is not gone yet
    int opened = 0;
  };
  SerialStopLineTest() {
    clock.set({1'000'000'000});
    for (const char* name : {"legs", "arms"}) {
      wires.push_back(std::make_unique<Wire>(clock, name[0] == 'a'));
      DeviceSpec bus = table(name, "serial");
      bus.keys["path"] = {"/dev/" + std::string(name), 1};
      specs.buses.push_back(bus);
    }
    specs.devices.push_back(table("body", "serial_servos"));
  }
  static DeviceSpec table(const std::string& name, const std::string& driver) {
    DeviceSpec spec;
    spec.name = name, spec.driver = driver;
    return spec;
  }
  /// A joint of the robot file and its servo, with torque and a goal that it has not reached.
  sim_hil::SimSerialServo& add(const std::string& name, const char* model, int id, std::size_t wire,
                               const char* on_stop = "torque_off", const char* mode = "position") {
    const wire::ServoModel& m = *wire::servo_model(model);
    DeviceSpec joint = table(name, m.maker == wire::ServoMaker::robotis ? "dynamixel" : "feetech");
    joint.keys["bus"] = {specs.buses[wire].name, 1};
    joint.keys["id"] = {std::int64_t{id}, 1};
    joint.keys["model"] = {std::string(model), 1};
    joint.keys["on_stop"] = {std::string(on_stop), 1};
    joint.keys["mode"] = {std::string(mode), 1};
    specs.devices[0].joints.push_back(joint);
    rotors.push_back(std::make_unique<sim_hil::JointModel>());
    sim_hil::SimSerialServo::Parameters p;
    p.id = static_cast<std::uint8_t>(id), p.model = &m;
    sims.push_back(
        std::make_unique<sim_hil::SimSerialServo>(wires[wire]->line, *rotors.back(), sim_hil::SimMount{}, p));
    sim_hil::SimSerialServo& servo = *sims.back();
    pass(1ms);
    if (std::string_view(mode) == "velocity") {
      servo.set_number(m.operating_mode, m.velocity_mode);
      servo.set_number(m.goal_velocity, 100);
    }
    servo.set_number(m.goal_position, m.centre + 200);
    wire::DxlBuilder on = wire::dxl_write(m.version, p.id, m.torque_enable.address, std::array<std::uint8_t, 1>{1});
    static_cast<void>(wires[wire]->line.host().write_now(on.finish()));
    pass(5ms);
    std::array<std::uint8_t, 256> answers;
    static_cast<void>(wires[wire]->line.host().read_now(answers));
    EXPECT_TRUE(servo.live());
    return servo;
  }
  void pass(Duration d) {
    for (const Time end = clock.now() + d; clock.now() < end;) {
      clock.set(clock.now() + 100us);
      for (auto& w : wires) w->line.advance(clock.now());
    }
  }
  std::unique_ptr<SerialStopLine> make(bool limp = false) {
    const SerialStopLine::Group group{"body", limp};
    return SerialStopLine::make(specs, {&group, 1}, *this, *this);
  }

  // hal::Os: the parent sleeps, and the servos' time goes on.
  Time now() const noexcept override { return clock.now(); }
  void sleep_until(Time t) noexcept override {
    if (t > now()) pass(t - now());
    if (now() >= dies_at)
      for (auto& w : wires) w->held = false;
  }
  void wait(hal::WakeWord&, std::uint32_t, Time deadline) noexcept override { sleep_until(deadline); }
  void wake(hal::WakeWord&) noexcept override {}
  Duration thread_cpu_time() noexcept override { return {}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions&, std::function<void()>) override {
    return hal::Error{hal::Errc::not_supported, "no threads here"};
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return hal::Error{hal::Errc::not_supported, "no memory here"};
  }
  hal::Status lock_memory() override { return {}; }

  hal::Result<std::unique_ptr<hal::Serial>> serial(const hal::SerialSpec& spec, std::string& why) override {
    Wire& w = *wires[spec.path == "/dev/legs" ? 0 : 1];
    if (w.held || spec.path == missing) {
      why = spec.path + (w.held ? ": another process holds it" : ": no such file");
      return hal::Error{w.held ? hal::Errc::busy : hal::Errc::not_found, "serial"};
    }
    ++w.opened;
    return std::unique_ptr<hal::Serial>(std::make_unique<FarEnd>(w.line.host()));
  }

  hal::ManualClock clock;
  std::vector<std::unique_ptr<Wire>> wires;
  std::vector<std::unique_ptr<sim_hil::JointModel>> rotors;
  std::vector<std::unique_ptr<sim_hil::SimSerialServo>> sims;
  DeviceSpecs specs;
  Time dies_at = hal::kNever;
  std::string missing;
};

TEST_F(SerialStopLineTest, JointsOfEveryMakerLoseTheirTorqueAndSaySo) {
  const std::vector<sim_hil::SimSerialServo*> all{&add("hip", "xm430_w350", 1, 0), &add("knee", "xl430_w250", 2, 0),
                                                  &add("elbow", "sts3215", 1, 1), &add("hand", "ax12", 2, 1),
                                                  &add("neck", "mx28", 3, 1)};
  const auto line = make();
  ASSERT_TRUE(line);
  EXPECT_EQ(wires[0]->opened, 0) << "the runtime has it";
  const Time begin = now();
  const hal::Status stopped = line->stop();
  EXPECT_TRUE(stopped) << stopped.error().where << line->last_report();
  EXPECT_EQ(line->last_report(), "5 of 5 joints are without torque");
  EXPECT_LT(now() - begin, 30ms);
  for (const auto* servo : all) EXPECT_FALSE(servo->live());
}

TEST_F(SerialStopLineTest, OneThatIsDeclaredToHoldKeepsItsTorque) {
  sim_hil::SimSerialServo& holds = add("hip", "xm430_w350", 1, 0, "hold");
  sim_hil::SimSerialServo& limp = add("knee", "xm430_w350", 2, 0);
  sim_hil::SimSerialServo& wheel = add("wheel", "xl430_w250", 3, 0, "hold", "velocity");
  const auto line = make();
  EXPECT_TRUE(line->stop()) << line->last_report();
  EXPECT_EQ(line->last_report(), "1 of 3 joints are without torque, 2 hold");
  pass(500ms);
  EXPECT_TRUE(holds.live());
  EXPECT_FALSE(limp.live());
  EXPECT_TRUE(wheel.live());
  EXPECT_NEAR(rotors[2]->velocity_radps(), 0, 0.01);
}

TEST_F(SerialStopLineTest, AGroupThatIsSafeWithoutTorqueIsLimpWhateverItsJointsSay) {
  add("hip", "xm430_w350", 1, 0, "hold");
  EXPECT_TRUE(make(true)->stop());
  EXPECT_FALSE(sims[0]->live());
}

TEST_F(SerialStopLineTest, AServoThatItsWatchdogHasStoppedHolds) {
  sim_hil::SimSerialServo& wheel = add("wheel", "xl430_w250", 3, 0, "hold", "velocity");
  wheel.set_number(wire::servo_model("xl430_w250")->bus_watchdog, 0xFF);
  const auto line = make();
  EXPECT_TRUE(line->stop()) << line->last_report();
  EXPECT_EQ(line->last_report(), "0 of 1 joints are without torque, 1 holds");
}

TEST_F(SerialStopLineTest, OneThatDoesNotAnswerIsNamedAndTheOthersAreStoppedInTime) {
  for (int id = 1; id <= 10; ++id) add("joint" + std::to_string(id), "xm430_w350", id, 0);
  sims[3]->power(false);
  const auto line = make();
  const Time begin = now();
  const hal::Status stopped = line->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, hal::Errc::timeout);
  EXPECT_LE(now() - begin, SerialStopLine::kPatience);
  EXPECT_EQ(line->last_report(), "9 of 10 joints are without torque; joint 'joint4' (legs) did not answer");
  for (const auto& servo : sims) EXPECT_FALSE(servo->live() && servo->powered());
}

TEST_F(SerialStopLineTest, ALineThatTheDyingRuntimeHoldsIsOpenedWhenItIsGone) {
  add("hip", "xm430_w350", 1, 0);
  wires[0]->held = true;
  dies_at = now() + 30ms;
  const auto line = make();
  EXPECT_TRUE(line->stop()) << line->last_report();
  EXPECT_FALSE(sims[0]->live());
}

TEST_F(SerialStopLineTest, ALineThatStaysHeldOrIsMissingIsNamedAndTheOtherIsStopped) {
  add("hip", "xm430_w350", 1, 0);
  add("elbow", "sts3215", 1, 1);
  wires[0]->held = true;
  auto line = make();
  ASSERT_FALSE(line->stop());
  EXPECT_EQ(line->last_report(), "1 of 2 joints are without torque; bus 'legs': /dev/legs: another process holds it");
  wires[0]->held = false;
  EXPECT_TRUE(line->stop()) << "said again";
  line.reset();
  missing = "/dev/legs";
  wires[1]->held = true;
  line = make();
  const hal::Status stopped = line->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, hal::Errc::closed);
}

TEST_F(SerialStopLineTest, LostBytesDelayItAndNoMore) {
  for (int id = 1; id <= 5; ++id) add("joint" + std::to_string(id), "sts3215", id, 1);
  int bytes = 0;
  wires[1]->line.set_tamper([&](std::uint8_t b) { return ++bytes % 41 == 0 ? std::nullopt : std::optional(b); });
  const auto line = make();
  EXPECT_TRUE(line->stop()) << line->last_report();
  for (const auto& servo : sims) EXPECT_FALSE(servo->live());
}

TEST_F(SerialStopLineTest, GroupsThatAreNotNamedHaveNone) {
  add("hip", "xm430_w350", 1, 0);
  const SerialStopLine::Group other{"head", false};
  EXPECT_FALSE(SerialStopLine::make(specs, {&other, 1}, *this, *this));
}

}  // namespace
}  // namespace sinew::drivers::serial_stop_line_test
