// The guardian in a graph, in virtual time: what goes out, when, and why not.
#include <gtest/gtest.h>

#include <limits>

#include "graph_fixture.hpp"

namespace sinew::rt {
namespace {

using msg::GuardianMode;
using Safe = ActuatorSpec::Safe;
using Entry = LoggedActuators::Entry;

constexpr Time us(std::int64_t n) { return {n * 1000}; }

/// A controller at 100 Hz whose commands the test makes; execution time 100 us, guardian 5 us, lease 20 ms.
class GuardianInGraph : public ::testing::Test {
 protected:
  GuardianInGraph() { states.reserve(10'000); }
  GraphRig g;
  std::function<Status(msg::ActuatorCommand&, std::uint32_t)> command = [](msg::ActuatorCommand&, std::uint32_t) {
    return Status::ok;
  };
  struct State {
    std::int64_t now_us;
    GuardianMode mode;
    std::uint32_t faults, events;
    double value;
  };
  std::vector<State> states;

  void run(Duration duration, Safe safe = Safe::stop) {
    g.module(
        "ctl", [](Declaration& d, Probe& p) { d.out("command", p.command); }, {},
        [this](Probe& p, const Step& step) {
          msg::ActuatorCommand& c = p.command.loan();
          c.stamp = step.now;
          c.count = 2;
          c.armed = 1;
          c.value = {1.0, 2.0};
          return command(c, step.number);
        },
        100us);
    g.periodic("control", 80, 10ms, {"ctl"});
    ActuatorSpec& a = g.motors("ctl.command");
    a.safe = safe;
    a.rate_per_s = rate;
    observer_.test = this;
    g.options.observer = &observer_;
    ASSERT_EQ(g.build(), "");
    g.run(duration);
  }
  double rate = 0;
  const std::vector<Entry>& log() const { return g.board.motors.log; }
  /// The state of the guardian's step that started at this instant.
  State at(std::int64_t now_us) const {
    for (const State& s : states)
      if (s.now_us == now_us) return s;
    ADD_FAILURE() << "no guardian step at " << now_us << " us";
    return {};
  }

 private:
  struct Observer final : RunObserver {
    GuardianInGraph* test = nullptr;
    void completed(const StepRecord& record) noexcept override {
      if (record.module != 0) return;
      test->note(record.now);
    }
  } observer_;
  void note(Time now) {
    if (!latch_) {
      latch_ = std::make_unique<Latch>(g.graph->segment());
      latch_->bind(state_, g.graph->taps()[0]);
    }
    latch_->latch();
    const msg::GuardianState* s = state_.get();
    states.push_back({now.ns / 1000, s->mode, s->faults, s->fault_events, s->value[0]});
    latch_->release();
  }
  void SetUp() override { g.configure_options.taps = {"guardian.motors"}; }
  In<msg::GuardianState> state_;
  std::unique_ptr<Latch> latch_;
};

TEST_F(GuardianInGraph, AGoodCommandPassesWithWhatIsLeftOfItsLease) {
  run(105us);
  ASSERT_EQ(log().size(), 1u);
  // commit at 100 us, guardian's step 100..105 us
  EXPECT_EQ(log()[0], (Entry{us(105), false, 1.0, 20ms - 5us}));
  EXPECT_EQ(at(100).mode, GuardianMode::active);
}

TEST_F(GuardianInGraph, AllZeroIsArmedAndDisarmedIsStandby) {
  command = [](msg::ActuatorCommand& c, std::uint32_t n) {
    if (n == 0) c.armed = 0;
    if (n == 1) c.value = {};
    return Status::ok;
  };
  run(25ms);
  EXPECT_EQ(at(100).mode, GuardianMode::standby);
  EXPECT_EQ(at(10100).mode, GuardianMode::armed);
  EXPECT_EQ(at(20100).mode, GuardianMode::active);
  EXPECT_TRUE(log()[0].stop);
  EXPECT_FALSE(log()[1].stop);
}

TEST_F(GuardianInGraph, BeforeTheFirstCommandItStandsByWithoutAFault) {
  command = [](msg::ActuatorCommand&, std::uint32_t) { return Status::stale; };
  run(50ms);
  EXPECT_EQ(at(10000).mode, GuardianMode::standby);  // woken by its time-out, half a lease
  EXPECT_EQ(at(40000).events, 0u);
  for (const Entry& e : log()) EXPECT_TRUE(e.stop);
}

TEST_F(GuardianInGraph, TheLeaseEndsToTheInstant) {
  command = [](msg::ActuatorCommand&, std::uint32_t n) { return n == 0 ? Status::ok : Status::stale; };
  run(40ms);
  // The command of 100 us was good until 20.1 ms; the guardian looks at 10.1 and 20.1 ms and needs 5 us.
  EXPECT_EQ(at(10100).mode, GuardianMode::active);
  EXPECT_EQ(at(20100).mode, GuardianMode::safe);
  EXPECT_EQ(at(20100).faults, msg::kFaultLease);
  EXPECT_EQ(at(20100).value, 0.0);
  EXPECT_EQ(at(30100).events, 1u) << "one event, however long it lasts";
  ASSERT_GE(log().size(), 3u);
  EXPECT_EQ(log()[1], (Entry{us(10105), false, 1.0, 10ms - 5us})) << "never more than what is left";
  EXPECT_EQ(log()[2], (Entry{us(20105), true, 0.0, 0ns}));
}

TEST_F(GuardianInGraph, HoldRepeatsTheLastGoodValues) {
  command = [](msg::ActuatorCommand&, std::uint32_t n) { return n == 0 ? Status::ok : Status::stale; };
  run(40ms, Safe::hold);
  EXPECT_EQ(at(20100).mode, GuardianMode::safe);
  EXPECT_EQ(at(20100).value, 1.0);
  EXPECT_EQ(log()[2], (Entry{us(20105), false, 1.0, 20ms}));
  EXPECT_EQ(log()[3], (Entry{us(30105), false, 1.0, 20ms}));
}

struct BadCommand {
  const char* what;
  void (*spoil)(msg::ActuatorCommand&);
  std::uint32_t fault;
};

class GuardianRefuses : public GuardianInGraph, public ::testing::WithParamInterface<BadCommand> {};

TEST_P(GuardianRefuses, AndRecoversWithTheNextGoodCommand) {
  rate = 1000;
  command = [](msg::ActuatorCommand& c, std::uint32_t n) {
    if (n == 2) GetParam().spoil(c);
    return Status::ok;
  };
  run(45ms);
  EXPECT_EQ(at(10100).mode, GuardianMode::active);
  EXPECT_EQ(at(20100).mode, GuardianMode::safe);
  EXPECT_EQ(at(20100).faults, GetParam().fault);
  EXPECT_EQ(at(20100).value, 0.0) << "nothing of a bad command goes out";
  EXPECT_EQ(at(30100).mode, GuardianMode::active);
  EXPECT_EQ(at(30100).faults, 0u);
  EXPECT_EQ(at(40100).events, 1u);
  for (const Entry& e : log()) {
    if (e.at == us(20105)) {
      EXPECT_TRUE(e.stop);
    }
    if (e.at == us(30105)) {
      EXPECT_FALSE(e.stop);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , GuardianRefuses,
    ::testing::Values(BadCommand{"NotANumber", [](auto& c) { c.value[1] = std::numeric_limits<double>::quiet_NaN(); },
                                 msg::kFaultNotFinite},
                      BadCommand{"Infinity", [](auto& c) { c.value[0] = -std::numeric_limits<double>::infinity(); },
                                 msg::kFaultNotFinite},
                      BadCommand{"AboveTheLimit", [](auto& c) { c.value[1] = 10.01; }, msg::kFaultLimit},
                      BadCommand{"BelowTheLimit", [](auto& c) { c.value[0] = -0.01; }, msg::kFaultLimit},
                      BadCommand{"TooManyChannels", [](auto& c) { c.count = 3; }, msg::kFaultCount},
                      BadCommand{"NoChannels", [](auto& c) { c.count = 0; }, msg::kFaultCount},
                      BadCommand{"AbsurdCount", [](auto& c) { c.count = 0xFFFFFFFF; }, msg::kFaultCount}),
    [](const auto& bad) { return std::string(bad.param.what); });

TEST_F(GuardianInGraph, AJumpFasterThanAllowedIsAFaultUntilEnoughTimeHasPassed) {
  rate = 100;  // 1.0 in the 10 ms between two commands
  command = [](msg::ActuatorCommand& c, std::uint32_t n) {
    c.value[0] = n < 2 ? 1.0 + n : 4.5;  // 1, 2, then a jump of 2.5
    return Status::ok;
  };
  run(55ms, Safe::hold);
  EXPECT_EQ(at(10100).mode, GuardianMode::active);
  EXPECT_EQ(at(20100).faults, msg::kFaultRate);
  EXPECT_EQ(at(20100).value, 2.0) << "held";
  EXPECT_EQ(at(30100).faults, msg::kFaultRate) << "2.5 in 20 ms";
  EXPECT_EQ(at(40100).mode, GuardianMode::active) << "2.5 in 30 ms";
  EXPECT_EQ(at(40100).value, 4.5);
}

TEST_F(GuardianInGraph, ADeviceThatRefusesIsAFaultUntilItTakesASafeAction) {
  command = [this](msg::ActuatorCommand&, std::uint32_t n) {
    g.board.motors.refuse = n == 2;  // the write at 20.105 ms
    return Status::ok;
  };
  run(55ms);
  EXPECT_EQ(at(20100).mode, GuardianMode::active);
  EXPECT_EQ(at(30100).faults, msg::kFaultDevice);
  EXPECT_EQ(at(30100).mode, GuardianMode::safe);
  EXPECT_EQ(at(40100).mode, GuardianMode::active);
  EXPECT_EQ(at(50100).events, 1u);
}

TEST_F(GuardianInGraph, DisarmingClearsAFault) {
  command = [](msg::ActuatorCommand& c, std::uint32_t n) {
    if (n == 1) c.count = 1;
    if (n == 2) c.armed = 0, c.count = 7;
    return Status::ok;
  };
  run(25ms, Safe::hold);
  EXPECT_EQ(at(10100).mode, GuardianMode::safe);
  EXPECT_EQ(at(20100).mode, GuardianMode::standby);
  EXPECT_TRUE(log().back().stop);
}

TEST_F(GuardianInGraph, AMissingDeviceIsNamedBeforeTheStart) {
  g.module("ctl", [](Declaration& d, Probe& p) { d.out("command", p.command); });
  g.periodic("control", 80, 10ms, {"ctl"});
  g.motors("ctl.command").name = "legs";
  g.configure_options.taps.clear();
  EXPECT_EQ(g.build(), "r:0: module.guardian: not ready: actuators 'legs' of the board: no such device");
}

TEST_F(GuardianInGraph, TheBusyControllerBelowCannotHoldItUp) {
  command = [](msg::ActuatorCommand&, std::uint32_t n) { return n == 0 ? Status::ok : Status::stale; };
  g.module("hog", {}, {}, {}, 500ms);
  g.periodic("hog", 98, 1s, {"hog"}).phase = 1ms;
  run(40ms);
  EXPECT_EQ(at(20100).faults, msg::kFaultLease);
  EXPECT_EQ(log()[2], (Entry{us(20105), true, 0.0, 0ns}));
}

}  // namespace
}  // namespace sinew::rt
