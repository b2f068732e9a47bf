// Complaints of a board's devices, in the words that a user reads.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "../no_connectors.hpp"
#include "drivers/board/driver_list.hpp"
#include "drivers/joints/joint_words.hpp"
#include "hal/platform.hpp"
#include "hal/sensor_queue.hpp"
#include "sim_hil/wire/memory_can.hpp"
#include "sim_hil/wire/sim_cia402.hpp"

namespace sinew::drivers::complaints_test {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ServoFeedback joint(msg::JointMode mode, std::uint32_t faults = 0, std::uint32_t code = 0) {
  ServoFeedback f;
  f.mode = mode, f.faults = faults, f.fault_code = code, f.measured = {1};
  return f;
}

TEST(JointWords, NameEveryFaultAndNothingOfAJointThatIsWell) {
  EXPECT_EQ(joint_words({}), "absent");
  EXPECT_EQ(joint_words(joint(msg::JointMode::absent, msg::kJointLost)), "absent; silent for longer than its time-out");
  EXPECT_EQ(joint_words(joint(msg::JointMode::absent)), "absent, it was there before");
  EXPECT_EQ(joint_words(joint(msg::JointMode::disabled)), "");
  EXPECT_EQ(joint_words(joint(msg::JointMode::enabled)), "");
  EXPECT_EQ(joint_words(joint(msg::JointMode::enabled, msg::kJointLimit)), "outside its limits");
  EXPECT_EQ(joint_words(joint(msg::JointMode::fault, msg::kJointOverTemperature | msg::kJointOverVoltage, 0x4310)),
            "fault: over-voltage, over-temperature (code 0x4310)");
  EXPECT_EQ(joint_words(joint(msg::JointMode::fault)), "fault");
}

TEST(JointWords, OneThatIsToldToMoveAndNeverGetsReadyRefuses) {
  ServoFeedback f = joint(msg::JointMode::enabling);
  f.refusing = 3s;
  EXPECT_EQ(refusal_words(f), "") << "a pause between two attempts is no refusal";
  f.refusing = 4s;
  EXPECT_EQ(
      refusal_words(f),
      "told to move for more than 3 s, and not ready (its enable input is open, or it has to be disarmed first?)");
  f.fault_code = 0x8130;
  EXPECT_EQ(refusal_words(f), "told to move for more than 3 s, and not ready (the last fault code is 0x8130)");
  for (const auto mode : {msg::JointMode::absent, msg::JointMode::homing, msg::JointMode::enabled}) {
    f.mode = mode;
    EXPECT_EQ(refusal_words(f), "");
  }
}

TEST(JointWords, OneThatIsToldToGoBeyondItsLimitsSaysSoAfterAWhile) {
  ServoFeedback f = joint(msg::JointMode::enabled);
  f.beyond = 3s;
  EXPECT_EQ(beyond_words(f), "") << "a controller may touch a limit";
  f.beyond = 3001ms;
  EXPECT_EQ(beyond_words(f), "told for more than 3 s to go beyond its own limits, and stays within them");
  f.mode = msg::JointMode::fault;
  EXPECT_EQ(beyond_words(f), "");
}

/// A bus in memory that says what the test set.
class TalkingConnectors final : public test::NoConnectors {
 public:
  hal::Result<std::unique_ptr<hal::CanBus>> can(const hal::CanSpec&, std::string& why) override {
    why = warning;
    return std::unique_ptr<hal::CanBus>(std::make_unique<Port>(wire.attach(), *this));
  }
  sim_hil::MemoryCan wire{1'000'000, &hal::system_os()};
  std::string warning;
  hal::TroubleText trouble;
  std::atomic<hal::CanState> state{hal::CanState::active};

 private:
  class Port final : public hal::CanBus, public hal::SelfReport {
   public:
    Port(hal::CanBus& port, TalkingConnectors& says) : port_(port), says_(says) {}
    hal::Result<bool> read(msg::CanFrame& out) noexcept override { return port_.read(out); }
    hal::Status send(const msg::CanFrame& f, hal::Time deadline) noexcept override { return port_.send(f, deadline); }
    hal::Status set_filters(std::span<const hal::CanFilter> f) override { return port_.set_filters(f); }
    void set_wake(hal::Wake* wake) noexcept override { port_.set_wake(wake); }
    hal::CanStats stats() const noexcept override {
      hal::CanStats stats = port_.stats();
      stats.state = says_.state;
      return stats;
    }
    std::uint32_t bit_rate() const noexcept override { return port_.bit_rate(); }
    std::string trouble() const override { return says_.trouble.get(); }

   private:
    hal::CanBus& port_;
    TalkingConnectors& says_;
  };
};

/// Threads of it run without SCHED_FIFO where it is asked for, as for a user without the privilege.
class PoorOs final : public hal::Os {
 public:
  hal::Time now() const noexcept override { return os_.now(); }
  void sleep_until(hal::Time t) noexcept override { os_.sleep_until(t); }
  void wait(hal::WakeWord& word, std::uint32_t expected, hal::Time deadline) noexcept override {
    os_.wait(word, expected, deadline);
  }
  void wake(hal::WakeWord& word) noexcept override { os_.wake(word); }
  hal::Duration thread_cpu_time() noexcept override { return os_.thread_cpu_time(); }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions& options,
                                                         std::function<void()> body) override {
    hal::ThreadOptions ordinary = options;
    ordinary.fifo_priority = 0;
    auto thread = os_.start_thread(ordinary, std::move(body));
    if (!thread) return thread.error();
    return std::unique_ptr<hal::Thread>(std::make_unique<Poor>(
        std::move(*thread), options.fifo_priority > 0 ? "SCHED_FIFO refused: not permitted" : ""));
  }
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return os_.shared_memory(name, bytes);
  }
  hal::Status lock_memory() override { return {}; }

 private:
  class Poor final : public hal::Thread {
   public:
    Poor(std::unique_ptr<hal::Thread> thread, std::string shortfall)
        : thread_(std::move(thread)), shortfall_(std::move(shortfall)) {}
    void join() override { thread_->join(); }
    const std::string& shortfall() const override { return shortfall_; }

   private:
    std::unique_ptr<hal::Thread> thread_;
    const std::string shortfall_;
  };
  hal::Os& os_ = hal::system_os();
};

using Keys = std::map<std::string, rt::ParamValue>;

DeviceSpec table(const std::string& name, const std::string& driver, const Keys& keys) {
  DeviceSpec spec;
  spec.name = name, spec.driver = driver;
  for (const auto& [key, value] : keys) spec.keys[key] = {value, 0};
  return spec;
}

// Pan answers, tilt has no drive.
DeviceSpecs head() {
  DeviceSpecs specs;
  specs.buses = {table("can0", "udp", {{"address", "7"}, {"tick_hz", std::int64_t{200}}})};
  DeviceSpec group = table("head", "can_servos", {});
  for (const auto& [name, id] : {std::pair{"pan", 1}, {"tilt", 2}})
    group.joints.push_back(table(name, "cia402",
                                 {{"bus", "can0"},
                                  {"id", std::int64_t{id}},
                                  {"counts_per_turn", 65536.0},
                                  {"rated_effort_nm", 2.0},
                                  {"max_effort_nm", 2.0}}));
  specs.devices = {group};
  return specs;
}

bool eventually(const std::function<bool()>& holds) {
  const hal::Time deadline = hal::system_os().now() + 20s;
  while (!holds()) {
    if (hal::system_os().now() > deadline) return false;
    hal::system_os().sleep_until(hal::system_os().now() + 5ms);
  }
  return true;
}

TEST(Complaints, AJointThatIsMissingIsNamedWithItsProtocolNumberAndBus) {
  TalkingConnectors connectors;
  sim_hil::SimServos sims(connectors.wire.attach());
  sim_hil::JointModel pan;
  sims.add<sim_hil::SimCia402>(pan, {}, sim_hil::SimCia402::Parameters());
  std::atomic<bool> stop{false};
  std::thread world([&] {
    while (!stop) {
      sims.poll(hal::system_os().now());
      hal::system_os().sleep_until(hal::system_os().now() + 1ms);
    }
  });
  {
    DeviceBoard board(head(), all_drivers(), connectors, hal::system_os());
    auto joints = board.sensor<msg::JointState>("head");
    ASSERT_TRUE(joints) << board.problem();
    EXPECT_THAT(board.complaints(), IsEmpty()) << "nobody is missed before the bus runs";
    ASSERT_TRUE(board.start()) << board.problem();
    msg::JointState state;
    EXPECT_TRUE(eventually([&] {
      while (*(*joints)->read(state)) {
      }
      const auto all = board.complaints();
      return state.mode[0] == msg::JointMode::disabled && all.size() == 1 &&
             all[0] == "head.tilt (cia402 2 on can0): absent";
    })) << ::testing::PrintToString(board.complaints());
  }
  stop = true;
  world.join();
}

TEST(Complaints, ADriveThatIsInFaultAgainEachTimeItIsEnabledIsToldToRefuse) {
  TalkingConnectors connectors;
  sim_hil::SimServos sims(connectors.wire.attach());
  sim_hil::JointModel pan, tilt;
  auto& good = sims.add<sim_hil::SimCia402>(pan, {}, sim_hil::SimCia402::Parameters());
  sim_hil::SimCia402::Parameters second;
  second.node_id = 2;
  auto& bad = sims.add<sim_hil::SimCia402>(tilt, {}, second);
  std::atomic<bool> stop{false}, breaks{true};
  std::thread world([&] {
    while (!stop) {
      sims.poll(hal::system_os().now());
      if (breaks && bad.live()) bad.fail(0x8130);  // it misses a heartbeat that it looks for too closely
      hal::system_os().sleep_until(hal::system_os().now() + 1ms);
    }
  });
  static_cast<void>(good);
  {
    DeviceBoard board(head(), all_drivers(), connectors, hal::system_os());
    auto actuators = board.actuators("head");
    ASSERT_TRUE(actuators) << board.problem();
    ASSERT_TRUE(board.start()) << board.problem();
    const std::string refusal =
        "head.tilt (cia402 2 on can0): told to move for more than 3 s, and not ready (the last fault code is 0x8130)";
    msg::ActuatorCommand command;
    command.count = 2, command.armed = 1;
    const auto told = [&] {
      EXPECT_TRUE((*actuators)->write(command, 5s));
      const auto all = board.complaints();
      return std::find(all.begin(), all.end(), refusal) != all.end();
    };
    EXPECT_TRUE(eventually(told)) << ::testing::PrintToString(board.complaints());
    for (const std::string& text : board.complaints()) EXPECT_FALSE(text.starts_with("head.pan")) << text;
    breaks = false;
    EXPECT_TRUE(eventually([&] { return !told() && board.complaints().empty(); }))
        << ::testing::PrintToString(board.complaints());
  }
  stop = true;
  world.join();
}

TEST(Complaints, OfABusReachTheBoardAndGoWhenItIsWell) {
  TalkingConnectors connectors;
  connectors.warning = "can0: the interface is down: 'ip link set can0 up'";
  DeviceBoard board(head(), all_drivers(), connectors, hal::system_os());
  ASSERT_TRUE(board.actuators("head")) << board.problem();
  EXPECT_THAT(board.warnings(), ElementsAre("bus 'can0': can0: the interface is down: 'ip link set can0 up'"));
  connectors.trouble.set("can0: the interface is down: 'ip link set can0 up'");
  EXPECT_THAT(board.complaints(), ElementsAre("bus 'can0': can0: the interface is down: 'ip link set can0 up'"));
  connectors.trouble.set("");
  EXPECT_THAT(board.complaints(), IsEmpty());
  connectors.state = hal::CanState::passive;
  EXPECT_THAT(board.complaints(), ElementsAre(HasSubstr("bus 'can0': error-passive: nobody acknowledges")));
}

TEST(Complaints, ThreadsThatRunWithoutTheirPriorityAreNamed) {
  TalkingConnectors connectors;
  PoorOs os;
  DeviceBoard board(head(), all_drivers(), connectors, os);
  ASSERT_TRUE(board.actuators("head")) << board.problem();
  ASSERT_TRUE(board.start()) << board.problem();
  EXPECT_THAT(board.shortfalls(), ElementsAre("thread of bus 'can0': SCHED_FIFO refused: not permitted"));
}

}  // namespace
}  // namespace sinew::drivers::complaints_test
