// Serial servos behind their real driver, on simulated lines with byte times, in virtual time.
#include <gmock/gmock.h>

#include "drivers/joints/serial_hub.hpp"
#include "servo_rig.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::drivers::serial_servo_test {
namespace {

using msg::JointMode;
using ::testing::HasSubstr;

/// The line's end, which the hub owns. The simulated line locks and allocates: the trap is off in there.
class LineEnd final : public hal::Serial {
 public:
  explicit LineEnd(sim_hil::SimSerialLine& line) : line_(line) {}
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override {
    const rt::trap::Scope off(nullptr);
    return line_.host().read_now(into);
  }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    const rt::trap::Scope off(nullptr);
    return line_.host().write_now(bytes);
  }
  hal::Status set_bit_rate(std::uint32_t rate) noexcept override { return line_.host().set_bit_rate(rate); }
  hal::Result<bool> wait_readable(Time deadline) noexcept override { return line_.host().wait_readable(deadline); }

 private:
  sim_hil::SimSerialLine& line_;
};

struct Line {
  Line(StillOs& os, const sim_hil::SimLineOptions& options, const SerialHubConfig& config)
      : wire(options, os.clock),
        hub(
            os, std::make_unique<LineEnd>(wire),
            [this](std::string& why) -> hal::Result<std::unique_ptr<hal::Serial>> {
              if (!plugged) return why = "unplugged", hal::Error{hal::Errc::not_found, "line"};
              return std::unique_ptr<hal::Serial>(std::make_unique<LineEnd>(wire));
            },
            config) {}
  sim_hil::SimSerialLine wire;
  SerialHub hub;
  bool plugged = true;
  Time next{};
};

class SerialRig {
 public:
  explicit SerialRig(std::size_t lines = 1, const SerialHubConfig& config = plain_hub(),
                     const sim_hil::SimLineOptions& options = {}) {
    os.clock.set({1'000'000'000});
    for (std::size_t i = 0; i < lines; ++i) line.push_back(std::make_unique<Line>(os, options, config));
  }
  static SerialHubConfig plain_hub() {
    SerialHubConfig c;
    c.rate.latency = 500us;
    return c;
  }
  static ServoConfig plain(std::uint32_t id) {
    ServoConfig c;
    c.name = "joint" + std::to_string(id);
    c.node_id = id;
    c.limits.position_min_rad = -2.4, c.limits.position_max_rad = 2.4;
    c.limits.velocity_radps = 4;
    return c;
  }
  sim_hil::SimSerialServo& add(std::string_view model, ServoConfig c, std::size_t l = 0, std::uint8_t delay = 250) {
    const wire::ServoModel* m = wire::servo_model(model);
    EXPECT_EQ(to_string(check_serial_servo(c, {m})), "");
    if (groups.empty() || groups.back()->size() == msg::kMaxChannels)
      groups.push_back(std::make_unique<ServoGroup>(os, "body"));
    auto servo = std::make_unique<SerialServo>(c, SerialServoOptions{m});
    servos.push_back(servo.get());
    EXPECT_TRUE(groups.back()->add(line[l]->hub, std::move(servo)));
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    sim_hil::SimSerialServo::Parameters p;
    p.id = static_cast<std::uint8_t>(c.node_id), p.model = m, p.return_delay = delay;
    sims.push_back(std::make_unique<sim_hil::SimSerialServo>(line[l]->wire, *joints.back(),
                                                             sim_hil::SimMount{c.sign, c.gear_ratio, c.zero_rad}, p));
    return *sims.back();
  }
  void configure() {
    for (auto& l : line) {
      std::string why;
      ASSERT_TRUE(l->hub.configure(why)) << why;
    }
  }
  /// Lets time pass from event to event; with `drive`, setpoints are written every 10 ms.
  void run(Duration duration, bool drive = true) {
    const Time end = os.now() + duration;
    while (os.now() < end) {
      Time next = std::min(end, drive ? written + 10ms : end);
      for (auto& l : line) next = std::min({next, l->wire.next(), l->next});
      os.clock.set(std::max(next, os.now() + 1us));
      if (drive && os.now() >= written + 10ms) write(100ms);
      for (auto& l : line) {
        l->wire.advance(os.now());
        l->hub.recover(os.now());
        const rt::trap::Scope trap("hub");
        l->next = l->hub.step(os.now());
      }
      for (std::size_t g = 0; g < groups.size(); ++g) read(g);
    }
  }
  void read(std::size_t g) {
    msg::JointState said;
    for (auto got = groups[g]->read(said); got && *got; got = groups[g]->read(said)) {
      for (std::size_t i = 0; i < said.count; ++i) {
        const std::size_t at = g * msg::kMaxChannels + i;
        sample.position_rad[at] = said.position_rad[i], sample.mode[at] = said.mode[i];
        sample.voltage_v[at] = said.voltage_v[i], sample.temperature_c[at] = said.temperature_c[i];
        sample.faults[at] = said.faults[i], sample.fault_code[at] = said.fault_code[i];
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
      ASSERT_TRUE(group->write(command, lease));
    }
    written = os.now();
  }
  bool until(std::size_t i, JointMode mode, bool drive = true) {
    for (const Time end = os.now() + 10s; os.now() < end;) {
      run(5ms, drive);
      if (sample.mode[i] == mode) return true;
    }
    return false;
  }
  bool all_enabled() {
    for (std::size_t i = 0; i < servos.size(); ++i)
      if (!until(i, JointMode::enabled)) return false;
    return true;
  }

  StillOs os;
  std::vector<std::unique_ptr<ServoGroup>> groups;  // each as full as it can be
  std::vector<std::unique_ptr<Line>> line;
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  std::vector<std::unique_ptr<sim_hil::SimSerialServo>> sims;
  std::array<double, 64> setpoint{};
  std::vector<const SerialServo*> servos;
  struct {  // of all groups, one behind the other
    std::array<double, 64> position_rad{}, voltage_v{}, temperature_c{};
    std::array<JointMode, 64> mode{};
    std::array<std::uint32_t, 64> faults{}, fault_code{};
  } sample;
  Time written{};
};

class EachModel : public testing::TestWithParam<const char*> {};

TEST_P(EachModel, IsFoundSetUpAndFollowsItsSetpoints) {
  SerialRig rig;
  ServoConfig c = SerialRig::plain(7);
  c.sign = -1, c.zero_rad = 0.1;
  sim_hil::SimSerialServo& servo = rig.add(GetParam(), c);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  EXPECT_EQ(servo.number(wire::servo_model(GetParam())->return_delay), 0) << "the driver sets it";
  rig.setpoint[0] = 0.5;
  rig.run(2s);
  EXPECT_EQ(rig.sample.mode[0], JointMode::enabled);
  EXPECT_NEAR(rig.sample.position_rad[0], 0.5, 0.01);
  EXPECT_NEAR(rig.joints[0]->position_rad(), 0.5, 0.01);
  EXPECT_NEAR(rig.sample.voltage_v[0], 12, 0.1);
  EXPECT_NEAR(rig.sample.temperature_c[0], 25, 1);
  EXPECT_EQ(rig.sample.faults[0], 0u);
  EXPECT_EQ(rig.line[0]->hub.stats().missed, 0u);
}

TEST_P(EachModel, WithoutSetpointsItLosesItsTorque) {
  SerialRig rig;
  rig.add(GetParam(), SerialRig::plain(7));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  EXPECT_TRUE(rig.sims[0]->live());
  rig.run(130ms, false);
  EXPECT_FALSE(rig.sims[0]->live());
  EXPECT_EQ(rig.sample.mode[0], JointMode::disabled);
  EXPECT_TRUE(rig.until(0, JointMode::enabled)) << "a newer command";
}

TEST_P(EachModel, LostBytesCostSingleAnswers) {
  SerialRig rig;
  for (std::uint32_t id = 1; id <= 6; ++id) rig.add(GetParam(), SerialRig::plain(id));
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  std::uint32_t at = 0;
  rig.line[0]->wire.set_tamper([&](std::uint8_t b) { return ++at % 997 == 0 ? std::nullopt : std::optional(b); });
  std::uint64_t ready = 0, looks = 0;
  for (int i = 0; i < 300; ++i) {
    rig.run(10ms);
    for (std::size_t k = 0; k < 6; ++k) ready += rig.sample.mode[k] == JointMode::enabled, ++looks;
  }
  EXPECT_GT(rig.line[0]->hub.stats().missed, 0u);
  EXPECT_EQ(ready, looks);
}

INSTANTIATE_TEST_SUITE_P(SerialServo, EachModel,
                         testing::Values("xm430_w350", "xl430_w250", "mx28", "ax12", "sts3215", "scs0009"),
                         [](const auto& model) { return model.param; });

TEST(SerialServo, TwentyServosAtAHundredHertzHaveACycleOfLessThanEightMilliseconds) {
  // Behind a USB adapter whose latency timer is 1 ms.
  SerialHubConfig config = SerialRig::plain_hub();
  config.rate.latency = 1ms;
  SerialRig rig(1, config, {.latency = 1ms});
  for (std::uint32_t id = 1; id <= 20; ++id) rig.add("xm430_w350", SerialRig::plain(id));
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  const SerialHubStats before = rig.line[0]->hub.stats();
  rig.run(1s);
  const SerialHubStats after = rig.line[0]->hub.stats();
  EXPECT_EQ(after.ticks - before.ticks, 100u);
  EXPECT_EQ(after.missed, before.missed);
  EXPECT_GE(after.answered - before.answered, 100u * 21u) << "all of them, and a slow register";
  const SerialPlan plan = plan_serial(rig.servos, config.rate);
  EXPECT_EQ(plan.goals + plan.answers, (114 + 34 + 420) * 10us) << "as the bytes are on the line";
  EXPECT_EQ(plan.sum(), 8ms) << "with a slow register and the adapter's latency, twice";
  EXPECT_GT(after.longest_cycle_s, 5.68e-3);
  EXPECT_LT(after.longest_cycle_s, 6.7e-3) << "goals and answers of all; until now, bringing them up included";
}

/// The longest cycle, ms: goals and answers of all that are on the line.
std::vector<double> cycles_ms(std::size_t servos, std::size_t lines, bool fast, double tick_hz) {
  SerialHubConfig config = SerialRig::plain_hub();
  config.rate.latency = 1ms;
  config.rate.fast_read = fast;
  config.rate.tick_hz = tick_hz;
  SerialRig rig(lines, config, {.latency = 1ms});
  for (std::size_t i = 0; i < servos; ++i)
    rig.add("xm430_w350", SerialRig::plain(static_cast<std::uint32_t>(i / lines + 1)), i % lines);
  rig.configure();
  EXPECT_TRUE(rig.all_enabled());
  const std::uint64_t missed = rig.line[0]->hub.stats().missed;
  rig.run(200ms);
  EXPECT_EQ(rig.line[0]->hub.stats().missed, missed);
  std::vector<double> all;
  for (const auto& line : rig.line) all.push_back(line->hub.stats().longest_cycle_s * 1e3);
  return all;
}

TEST(SerialServo, AFastReadOrASecondLineMakeTheCycleShorter) {
  // docs/servos.md has these figures.
  EXPECT_NEAR(cycles_ms(20, 1, true, 125)[0], 5.0, 0.1);
  const auto halves = cycles_ms(20, 2, false, 188);
  for (const double one : halves) EXPECT_NEAR(one, 3.7, 0.2);
  const auto fast_halves = cycles_ms(20, 2, true, 200);
  for (const double one : fast_halves) EXPECT_NEAR(one, 3.0, 0.2);
}

TEST(SerialServo, AFastReadTakesLessOfTheLine) {
  SerialHubConfig config = SerialRig::plain_hub();
  config.rate.fast_read = true;
  SerialRig rig(1, config);
  for (std::uint32_t id = 1; id <= 20; ++id) rig.add("xm430_w350", SerialRig::plain(id));
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  const SerialHubStats before = rig.line[0]->hub.stats();
  const std::uint64_t bytes = rig.line[0]->wire.bytes();
  rig.run(1s);
  EXPECT_EQ(rig.line[0]->hub.stats().missed, before.missed);
  EXPECT_LT(rig.line[0]->wire.bytes() - bytes, 100u * (114 + 34 + 288 + 40));
  rig.sims[10]->power(false);  // none of the one answer is whole any more
  ASSERT_TRUE(rig.until(10, JointMode::absent));
  rig.run(100ms);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(rig.sample.mode[i] == JointMode::enabled, i != 10) << i;
}

TEST(SerialServo, SeveralLinesGoOnBesideEachOther) {
  SerialRig rig(3);
  for (std::uint32_t id = 1; id <= 4; ++id) rig.add("xm430_w350", SerialRig::plain(id), 0);
  for (std::uint32_t id = 1; id <= 4; ++id) rig.add("mx28", SerialRig::plain(id), 1);
  for (std::uint32_t id = 1; id <= 4; ++id) rig.add("sts3215", SerialRig::plain(id), 2);
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  rig.line[1]->wire.connect(false);
  rig.line[1]->plugged = false;
  rig.run(500ms);
  EXPECT_EQ(rig.line[1]->hub.trouble(), "the serial line is gone (unplugged?)");
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_EQ(rig.sample.mode[i], i / 4 == 1 ? JointMode::absent : JointMode::enabled) << i;
  rig.line[1]->wire.connect(true);
  rig.line[1]->plugged = true;
  EXPECT_TRUE(rig.all_enabled());
  EXPECT_EQ(rig.line[1]->hub.trouble(), "");
}

TEST(SerialServo, AnEchoOfOurOwnBytesIsDropped) {
  for (const char* model : {"xm430_w350", "mx28", "ax12"}) {
    SerialRig rig(1, SerialRig::plain_hub(), {.echo = true});
    for (std::uint32_t id = 1; id <= 3; ++id) rig.add(model, SerialRig::plain(id));
    rig.configure();
    ASSERT_TRUE(rig.all_enabled()) << model;
    rig.run(1s);
    EXPECT_GT(rig.line[0]->hub.stats().echoed, 1000u) << model;
    EXPECT_EQ(rig.line[0]->hub.stats().missed, 0u) << model;
  }
}

TEST(SerialServo, OneThatIsGoneDoesNotTakeThoseBehindItWithIt) {
  SerialRig rig;
  for (std::uint32_t id = 1; id <= 8; ++id) rig.add("xm430_w350", SerialRig::plain(id));
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  rig.sims[2]->power(false);
  std::uint64_t lost = 0;
  for (int i = 0; i < 200; ++i) {
    rig.run(10ms);
    for (std::size_t k = 0; k < 8; ++k) lost += k != 2 && rig.sample.mode[k] != JointMode::enabled;
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_EQ(rig.sample.mode[2], JointMode::absent);
  EXPECT_TRUE((rig.sample.faults[2] & msg::kJointLost) != 0);
  rig.sims[2]->power(true);
  EXPECT_TRUE(rig.until(2, JointMode::enabled));
}

TEST_P(EachModel, AnswersThatComeTooLateAreNotTakenForThoseToLaterQuestions) {
  SerialRig rig;
  for (std::uint32_t id = 1; id <= 2; ++id) rig.add(GetParam(), SerialRig::plain(id));
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  rig.line[0]->wire.set_latency(16ms);
  rig.run(300ms);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(rig.sample.mode[i], JointMode::absent) << i;
  EXPECT_GE(rig.line[0]->hub.stats().late, 3u);
  EXPECT_THAT(rig.line[0]->hub.trouble(), HasSubstr("answers come after their time"));
  rig.line[0]->wire.set_latency(0ms);
  EXPECT_TRUE(rig.all_enabled());
  rig.run(1200ms);
  EXPECT_EQ(rig.line[0]->hub.trouble(), "");
}

TEST(SerialServo, ASecondOneOfItsNumberIsAFault) {
  SerialRig rig;
  rig.add("xm430_w350", SerialRig::plain(1));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  sim_hil::JointModel joint;
  // New from the factory: it answers 500 us after the other one.
  const sim_hil::SimSerialServo::Parameters p{.id = 1, .model = wire::servo_model("xm430_w350")};
  sim_hil::SimSerialServo twin(rig.line[0]->wire, joint, {}, p);
  ASSERT_TRUE(rig.until(0, JointMode::fault));
  EXPECT_TRUE((rig.sample.faults[0] & msg::kJointDuplicate) != 0);
  EXPECT_FALSE(rig.sims[0]->live());
  twin.power(false);
  EXPECT_TRUE(rig.until(0, JointMode::enabled));
}

TEST(SerialServo, OneThatRebootedStartsAgainWhereItIsAndNeverAtAStaleGoal) {
  // A reboot so short that no answer is late enough to notice it, and one that is longer than the time-out.
  for (const Duration boot : {1ms, 350ms}) {
    SerialRig rig;
    rig.add("xm430_w350", SerialRig::plain(1));
    rig.configure();
    rig.setpoint[0] = 1;
    ASSERT_TRUE(rig.until(0, JointMode::enabled));
    rig.run(3s);
    ASSERT_NEAR(rig.joints[0]->position_rad(), 1, 0.01);
    // It loses its power for a moment; without torque the joint falls to 0 meanwhile.
    rig.sims[0]->power(false);
    rig.run(boot);
    rig.joints[0]->place(0);
    rig.sims[0]->power(true);
    EXPECT_FALSE(rig.sims[0]->live());
    double fastest = 0;
    bool off = false, again = false;
    for (int i = 0; i < 4000; ++i) {
      rig.run(1ms);
      fastest = std::max(fastest, std::abs(rig.joints[0]->velocity_radps()));
      off = off || rig.sample.mode[0] != JointMode::enabled;
      again = again || (off && rig.sample.mode[0] == JointMode::enabled);
    }
    EXPECT_TRUE(off) << boot.count();
    EXPECT_TRUE(again) << boot.count();
    EXPECT_NEAR(rig.joints[0]->position_rad(), 1, 0.01) << "it goes there again";
    EXPECT_LT(fastest, 4 * 1.3) << "at its speed limit of 4 rad/s, from where it was";
  }
}

TEST(SerialServo, AnOverloadIsAFaultAndEndsInAReboot) {
  SerialRig rig;
  rig.add("xm430_w350", SerialRig::plain(1));
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  rig.sims[0]->fail(1u << 5);
  ASSERT_TRUE(rig.until(0, JointMode::fault));
  EXPECT_TRUE((rig.sample.faults[0] & msg::kJointOverload) != 0);
  EXPECT_EQ(rig.sample.fault_code[0], 0x20u);
  EXPECT_TRUE(rig.until(0, JointMode::enabled));
  EXPECT_EQ(rig.sims[0]->reboots(), 1u);
}

TEST(SerialServo, TheBusWatchdogStopsItWhenTheRobotIsSilent) {
  SerialRig rig;
  ServoConfig c = SerialRig::plain(1);
  c.device_timeout = 100ms;
  rig.add("xm430_w350", c);
  rig.configure();
  rig.setpoint[0] = 2;
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  const auto& m = *wire::servo_model("xm430_w350");
  EXPECT_EQ(rig.sims[0]->number(m.bus_watchdog), 5);
  // Nobody steps the hub: the robot's computer is dead.
  const Time end = rig.os.now() + 200ms;
  while (rig.os.now() < end) {
    rig.os.clock.set(rig.os.now() + 1ms);
    rig.line[0]->wire.advance(rig.os.now());
  }
  EXPECT_EQ(rig.sims[0]->number(m.bus_watchdog), 0xFF);
  rig.run(1s);
  EXPECT_TRUE(rig.until(0, JointMode::enabled)) << "its error is cleared";
}

TEST_P(EachModel, WhenTheComputerDiesDoesWhatSafetySays) {
  // docs/safety.md, "When the whole computer dies".
  SerialRig rig;
  ServoConfig c = SerialRig::plain(1);
  const wire::ServoModel& m = *wire::servo_model(GetParam());
  if (m.bus_watchdog) c.device_timeout = 200ms;
  sim_hil::SimSerialServo& servo = rig.add(GetParam(), c);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  rig.setpoint[0] = 2;
  rig.run(250ms);
  const double at_death = rig.joints[0]->position_rad();
  ASSERT_GT(rig.joints[0]->velocity_radps(), 1) << "it is under way";
  const auto pass = [&](Duration d) {
    for (const Time end = rig.os.now() + d; rig.os.now() < end;) {
      rig.os.clock.set(rig.os.now() + 1ms);
      rig.line[0]->wire.advance(rig.os.now());
    }
  };
  pass(2s);
  const double rests = rig.joints[0]->position_rad();
  EXPECT_TRUE(servo.live()) << "it keeps its torque";
  EXPECT_NEAR(rig.joints[0]->velocity_radps(), 0, 1e-3);
  const double goal = (servo.number(m.goal_position) - m.centre) * m.rad_per_count();
  EXPECT_NEAR(rests, goal, 0.02) << "of a watchdog: where it was stopped";
  EXPECT_LT(goal - at_death, FollowingError::kUsual_rad + 0.1) << "than it may lag behind, and where it was last heard";
  pass(10s);
  EXPECT_TRUE(servo.live()) << "for ever";
  EXPECT_NEAR(rig.joints[0]->position_rad(), rests, 1e-3);
  if (m.bus_watchdog) {
    EXPECT_EQ(servo.number(m.bus_watchdog), 0xFF);
  }
  // The computer comes back: from where it stands.
  double fastest = 0;
  for (int i = 0; i < 300; ++i) {
    rig.run(10ms);
    fastest = std::max(fastest, std::abs(rig.joints[0]->velocity_radps()));
  }
  EXPECT_EQ(rig.sample.mode[0], JointMode::enabled);
  EXPECT_NEAR(rig.sample.position_rad[0], 2, 0.02);
  EXPECT_LT(fastest, 4 * 1.3);
}

TEST(SerialServo, OneThatItsBusWatchdogStoppedUnnoticedFollowsAgain) {
  SerialRig rig;
  ServoConfig c = SerialRig::plain(1);
  c.device_timeout = 100ms;
  c.feedback_timeout = 500ms;  // longer: nothing is missed
  rig.add("xm430_w350", c);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::enabled));
  const auto& m = *wire::servo_model("xm430_w350");
  rig.write(1s);
  for (int i = 0; i < 150; ++i) {  // the robot's computer does something else
    rig.os.clock.set(rig.os.now() + 1ms);
    rig.line[0]->wire.advance(rig.os.now());
  }
  ASSERT_EQ(rig.sims[0]->number(m.bus_watchdog), 0xFF);
  rig.setpoint[0] = 0.5;
  rig.run(2s);
  EXPECT_EQ(rig.sims[0]->number(m.bus_watchdog), 5);
  EXPECT_EQ(rig.sample.mode[0], JointMode::enabled);
  EXPECT_NEAR(rig.sample.position_rad[0], 0.5, 0.02);
  EXPECT_EQ(rig.sims[0]->number(m.torque_enable), 1);
}

TEST(SerialServo, AnotherModelThanTheRobotFilesIsAFaultWithItsNumber) {
  SerialRig rig;
  rig.add("xm430_w350", SerialRig::plain(1));
  rig.sims[0]->set_number(wire::servo_model("xm430_w350")->model_number, 1060);
  rig.configure();
  ASSERT_TRUE(rig.until(0, JointMode::fault));
  EXPECT_EQ(rig.sample.fault_code[0], 1060u);
  rig.run(2s);
  EXPECT_FALSE(rig.sims[0]->live());
}

TEST(SerialServo, OtherModesAreVelocityAndEffort) {
  SerialRig rig;
  ServoConfig c = SerialRig::plain(1);
  c.mode = ServoMode::velocity;
  c.limits = {-100, 100, 4};
  rig.add("xl430_w250", c);
  c = SerialRig::plain(2);
  c.mode = ServoMode::effort;
  c.limits = {-100, 100, 20, 1};
  rig.add("xm430_w350", c);
  rig.setpoint[0] = 1.5, rig.setpoint[1] = 0.1;
  rig.configure();
  ASSERT_TRUE(rig.all_enabled());
  rig.run(2s);
  EXPECT_NEAR(rig.joints[0]->velocity_radps(), 1.5, 0.1);
  EXPECT_NEAR(rig.sims[1]->effort_nm(), 0.1, 0.01);
}

TEST(SerialServo, ACycleThatTheLineCannotHoldIsRefusedWithItsSum) {
  SerialHubConfig config = SerialRig::plain_hub();
  config.rate.tick_hz = 200;
  SerialRig rig(1, config);
  for (std::uint32_t id = 1; id <= 20; ++id) rig.add("xm430_w350", SerialRig::plain(id));
  std::string why;
  EXPECT_FALSE(rig.line[0]->hub.configure(why));
  EXPECT_EQ(
      why,
      "tick_hz: 20 servos at 200 Hz need 7 of 5 ms: goals 1.14, answers 4.54, one slow register 0.32, the adapter "
      "1: fewer servos on the line, a lower tick_hz, or a higher bit_rate, or fast_read");
}

TEST(SerialServo, TwoOfOneNumberAndBothProtocolsOnOneLineAreRefused) {
  SerialRig twice;
  twice.add("xm430_w350", SerialRig::plain(3));
  twice.add("xm430_w350", SerialRig::plain(3));
  std::string why;
  EXPECT_FALSE(twice.line[0]->hub.configure(why));
  EXPECT_THAT(why, HasSubstr("id: a number that no other servo on its line has: 'joint3' has it"));
  SerialRig both;
  both.add("xm430_w350", SerialRig::plain(1));
  both.add("mx28", SerialRig::plain(2));
  why.clear();
  EXPECT_FALSE(both.line[0]->hub.configure(why));
  EXPECT_THAT(why, HasSubstr("model: one with the packets of 'joint1' on the same line, protocol 2.0"));
}

TEST(SerialServo, WhatAModelCannotDoIsRefused) {
  const auto says = [](const char* model, const auto& change) {
    ServoConfig c = SerialRig::plain(1);
    change(c);
    return to_string(check_serial_servo(c, {wire::servo_model(model)}));
  };
  EXPECT_EQ(says("xm430_w350", [](auto& c) { c.node_id = 253; }), "id: an integer from 0 to 252");
  EXPECT_THAT(says("mx28", [](auto& c) { c.mode = ServoMode::velocity; }), HasSubstr("mode: \"position\""));
  EXPECT_THAT(says("xl430_w250", [](auto& c) { c.mode = ServoMode::effort; }), HasSubstr("measures no current"));
  EXPECT_THAT(says("mx28", [](auto& c) { c.device_timeout = 100ms; }), HasSubstr("has no bus watchdog"));
  EXPECT_EQ(says("xm430_w350", [](auto& c) { c.device_timeout = 3s; }), "device_timeout_ms: at most 2540");
  EXPECT_THAT(says("xm430_w350", [](auto& c) { c.stop = StopAction::damp; }), HasSubstr("on_stop"));
  EXPECT_THAT(says("xm430_w350", [](auto& c) { c.limits.effort_nm = 1; }), HasSubstr("max_effort_nm"));
}

}  // namespace
}  // namespace sinew::drivers::serial_servo_test
