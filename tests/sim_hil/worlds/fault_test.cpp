// Faults as people write them, and their effects on samples, frames and commands.
#include "sim_hil/worlds/fault.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "sim_hil/plant/actuator_faults.hpp"
#include "sim_hil/plant/frame_faults.hpp"
#include "sim_hil/plant/radio_faults.hpp"
#include "sim_hil/worlds/sensor_faults.hpp"

namespace sinew::plant::fault_test {
namespace {

using namespace std::chrono_literals;

constexpr WorldDevice kMotors{Part::actuators, "motors", 0, 0, 4, FaultDevice::motors, 0, 1};

constexpr hal::Time at(hal::Duration since_start) { return hal::Time{} + since_start; }

Fault fault(const char* text) {
  std::string why;
  const auto f = parse_fault(text, why);
  EXPECT_TRUE(f) << why;
  return f.value_or(Fault{});
}

std::string refusal(const char* text) {
  std::string why;
  EXPECT_FALSE(parse_fault(text, why)) << text;
  return why;
}

// ---- texts

TEST(FaultText, TimesAndAmountsHaveUnits) {
  const Fault f = fault("camera:delayed(80ms)@3..6.5");
  EXPECT_EQ(f.device, FaultDevice::camera);
  EXPECT_EQ(f.kind, FaultKind::delayed);
  EXPECT_EQ(f.amount, 0.08);
  EXPECT_EQ(f.from_ns, 3'000'000'000);
  EXPECT_EQ(f.until_ns, 6'500'000'000);
  EXPECT_EQ(fault("imu:stuck@5+500ms").until_ns, 5'500'000'000);
  EXPECT_EQ(fault("imu:off@250us").from_ns, 250'000);
  EXPECT_EQ(fault("imu:off@4").until_ns, kNoEnd);
}

TEST(FaultText, EveryPairThatMakesSenseIsReadAndWrittenTheSame) {
  for (const FaultDevice device : kFaultDevices)
    for (const FaultKind kind : kFaultKinds) {
      const std::string text = std::string(to_string(device)) + ":" + std::string(to_string(kind)) + "@1..2.5";
      std::string why;
      const auto f = parse_fault(text, why);
      ASSERT_EQ(f.has_value(), why_not(device, kind) == nullptr) << text;
      if (!f) continue;
      const auto again = parse_fault(to_string(*f), why);
      ASSERT_TRUE(again) << to_string(*f) << ": " << why;
      EXPECT_EQ(to_string(*again), to_string(*f));
      EXPECT_EQ(again->amount, f->amount);
    }
}

TEST(FaultText, WhatIsWrongIsNamedWithWhatIsAllowed) {
  EXPECT_EQ(refusal("imu:stuck"),
            "fault 'imu:stuck': DEVICE:KIND[(AMOUNT)]@FROM[+LENGTH|..UNTIL], for example imu:stuck@5+0.5");
  EXPECT_EQ(refusal("gps:off@1"),
            "fault 'gps:off@1': device 'gps': one of imu, range, baro, battery, camera, joints, soles, motors, head, "
            "left_arm, right_arm, left_leg, right_leg, "
            "gripper, radio, referee, link");
  EXPECT_EQ(refusal("imu:bent@1"),
            "fault 'imu:bent@1': kind 'bent': one of off, stuck, garbage, wrong, slow, delayed, intermittent, "
            "duplicated, closed");
  EXPECT_EQ(refusal("imu:stcuk@1"),
            "fault 'imu:stcuk@1': kind 'stcuk': one of off, stuck, garbage, wrong, slow, delayed, intermittent, "
            "duplicated, closed; did you mean stuck?");
  EXPECT_EQ(refusal("imu:closed@1"), "fault 'imu:closed@1': imu cannot be closed: only a connection closes; use off");
  EXPECT_EQ(refusal("imu:off(3)@1"), "fault 'imu:off(3)@1': off takes no amount");
  EXPECT_EQ(refusal("imu:slow(2.5)@1"),
            "fault 'imu:slow(2.5)@1': amount '2.5': a whole number from 2 to 1000: one of so many comes");
  EXPECT_EQ(refusal("imu:delayed(nan)@1"), "fault 'imu:delayed(nan)@1': amount 'nan': a time from 100us to 10s");
  EXPECT_EQ(refusal("imu:off@2..1"),
            "fault 'imu:off@2..1': time '2..1': FROM, FROM+LENGTH or FROM..UNTIL, in seconds or with us, ms, s, and "
            "not empty");
  for (const char* text : {"", ":", "@", "imu:@1", ":off@1", "imu:off@", "imu:off@1+", "imu:off@-1", "imu:off@1e300",
                           "imu:slow(@1", "imu:slow()@1", "imu:off@1..x", "imu:off@1+0", "imu:wrong(1e9)@1"})
    refusal(text);
}

// ---- samples

struct Out {
  double value;
  hal::Duration stamp, ready;
  bool operator==(const Out&) const = default;
};

/// Feeds range samples of 1, 2, 3, ... m at 1, 2, 3, ... ms, ready at once, and lets everything out that is due.
class Stream {
 public:
  Stream(std::vector<Fault> faults, std::uint64_t seed = 1) : log(faults, seed), faults_(log, FaultDevice::range) {}
  std::vector<Out> run(int samples) {
    std::vector<Out> out;
    const auto send = [&](const msg::RangeSample& s, hal::Time ready) {
      out.push_back({s.range_m, s.stamp - hal::Time{}, ready - hal::Time{}});
      return hal::Status{};
    };
    for (int i = 1; i <= samples; ++i) {
      msg::RangeSample s;
      s.stamp = at(i * 1ms);
      s.range_m = i;
      EXPECT_TRUE(faults_.offer(s, s.stamp, send));
      EXPECT_TRUE(faults_.release(s.stamp, send));
    }
    return out;
  }
  FaultLog log;

 private:
  SensorFaults<msg::RangeSample> faults_;
};

TEST(SensorFaults, OutsideOfItsTimeAFaultDoesNothing) {
  Stream none({}), later({fault("range:off@1"), fault("imu:off@0"), fault("range:garbage@0+0.5ms")});
  EXPECT_EQ(later.run(20), none.run(20));
  EXPECT_EQ(later.log.entries()[0].affected, 0u);
}

TEST(SensorFaults, OffLosesEverySampleOfItsTime) {
  Stream s({fault("range:off@2ms..4ms")});
  EXPECT_EQ(s.run(5), (std::vector<Out>{{1, 1ms, 1ms}, {4, 4ms, 4ms}, {5, 5ms, 5ms}}));
  EXPECT_EQ(s.log.entries()[0].affected, 2u);
}

TEST(SensorFaults, StuckRepeatsTheLastValueWithNewStamps) {
  Stream s({fault("range:stuck@3ms..5ms")});
  EXPECT_EQ(s.run(5), (std::vector<Out>{{1, 1ms, 1ms}, {2, 2ms, 2ms}, {2, 3ms, 3ms}, {2, 4ms, 4ms}, {5, 5ms, 5ms}}));
}

TEST(SensorFaults, WrongAddsItsAmountAndTwoOfThemAddUp) {
  Stream s({fault("range:wrong(0.5)@2ms"), fault("range:wrong(1)@3ms")});
  EXPECT_EQ(s.run(3), (std::vector<Out>{{1, 1ms, 1ms}, {2.5, 2ms, 2ms}, {4.5, 3ms, 3ms}}));
}

TEST(SensorFaults, SlowLetsOneOfSoManyThrough) {
  Stream s({fault("range:slow(3)@2ms")});
  EXPECT_EQ(s.run(8), (std::vector<Out>{{1, 1ms, 1ms}, {2, 2ms, 2ms}, {5, 5ms, 5ms}, {8, 8ms, 8ms}}));
  EXPECT_EQ(s.log.entries()[0].affected, 4u);
}

TEST(SensorFaults, DelayedIsReadyLaterAndWhatFollowsKeepsTheOrder) {
  Stream s({fault("range:delayed(3ms)@2ms..4ms")});
  EXPECT_EQ(
      s.run(7),
      (std::vector<Out>{
          {1, 1ms, 1ms}, {2, 2ms, 5ms}, {3, 3ms, 6ms}, {4, 4ms, 6ms}, {5, 5ms, 6ms}, {6, 6ms, 6ms}, {7, 7ms, 7ms}}));
}

TEST(SensorFaults, DuplicatedSendsTheSameTwice) {
  Stream s({fault("range:duplicated@2ms..3ms")});
  EXPECT_EQ(s.run(3), (std::vector<Out>{{1, 1ms, 1ms}, {2, 2ms, 2ms}, {2, 2ms, 2ms}, {3, 3ms, 3ms}}));
}

TEST(SensorFaults, IntermittentIsSilentInBurstsThatTheSeedDecides) {
  const auto arrived = [](std::uint64_t seed) { return Stream({fault("range:intermittent(20ms)@0")}, seed).run(2000); };
  const auto one = arrived(1);
  EXPECT_GT(one.size(), 600u);  // half of them, about
  EXPECT_LT(one.size(), 1400u);
  EXPECT_EQ(one, arrived(1));
  EXPECT_NE(one, arrived(2));
  int gaps = 0;
  for (std::size_t i = 1; i < one.size(); ++i) gaps += one[i].stamp - one[i - 1].stamp > 1ms;
  EXPECT_GT(gaps, 20);
  EXPECT_LT(gaps, 100) << "bursts, not single samples";
}

TEST(SensorFaults, BurstsOfTheConnectionHitAllDevicesAtTheSameTimes) {
  FaultLog log({fault("link:intermittent(20ms)@0")}, 3);
  DeviceFaults imu(log, FaultDevice::imu), baro(log, FaultDevice::baro);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(imu.next(at(i * 1ms)).lost, baro.next(at(i * 1ms)).lost) << i;
}

TEST(SensorFaults, GarbageHoldsEverySpecialValue) {
  Stream s({fault("range:garbage@0")});
  int nan = 0, infinite = 0, huge = 0, harmless = 0;
  for (const Out& o : s.run(1000)) {
    nan += std::isnan(o.value);
    infinite += std::isinf(o.value);
    huge += std::isfinite(o.value) && std::fabs(o.value) > 1e100;
    harmless += std::fabs(o.value) <= 1000;
  }
  EXPECT_GT(nan, 50);
  EXPECT_GT(infinite, 50);
  EXPECT_GT(huge, 50);
  EXPECT_GT(harmless, 50);
}

// ---- frames

constexpr std::uint32_t kWidth = 8, kHeight = 2, kRow = 2 * kWidth;

class Frames {
 public:
  explicit Frames(std::vector<Fault> faults) : log(faults, 1), faults_(log, msg::PixelFormat::yuyv, kWidth, kHeight) {}
  /// Frame i is filled with 16 i + column / 4, at 10 i ms; the frames that have gone out by then.
  struct Sent {
    std::uint8_t first, last;
    std::uint32_t number;
    hal::Duration ready;
    bool operator==(const Sent&) const = default;
  };
  std::vector<Sent> run(int frames) {
    std::vector<Sent> out;
    const FrameFaults::Send send = [&](std::span<const std::uint8_t> pixels, const sim_hil::FrameMeta& meta) {
      EXPECT_EQ(pixels.size(), kRow * kHeight);
      out.push_back({pixels.front(), pixels.back(), meta.number, meta.ready - hal::Time{}});
      return hal::Status{};
    };
    for (int i = 1; i <= frames; ++i) {
      for (std::uint32_t k = 0; k < kRow * kHeight; ++k)
        faults_.canvas()[k] = static_cast<std::uint8_t>(16 * i + static_cast<int>(k % kRow / 4));
      sim_hil::FrameMeta meta;
      meta.number = static_cast<std::uint32_t>(i);
      meta.stamp = meta.ready = at(i * 10ms);
      EXPECT_TRUE(faults_.offer(meta, send));
      EXPECT_TRUE(faults_.release(meta.ready, send));
    }
    return out;
  }
  FaultLog log;

 private:
  FrameFaults faults_;
};

TEST(FrameFaults, StuckShowsTheOldPictureUnderNewNumbers) {
  EXPECT_EQ(Frames({fault("camera:stuck@20ms..30ms")}).run(3),
            (std::vector<Frames::Sent>{{16, 19, 1, 10ms}, {16, 19, 2, 20ms}, {48, 51, 3, 30ms}}));
}

TEST(FrameFaults, WrongMovesThePictureToTheRight) {
  EXPECT_EQ(Frames({fault("camera:wrong(0.5)@0")}).run(1), (std::vector<Frames::Sent>{{16, 17, 1, 10ms}}));
  EXPECT_EQ(Frames({fault("camera:wrong(-0.5)@0")}).run(1), (std::vector<Frames::Sent>{{18, 19, 1, 10ms}}));
}

TEST(FrameFaults, DelayedKeepsThePixelsOfItsFrame) {
  EXPECT_EQ(Frames({fault("camera:delayed(10ms)@0")}).run(3),
            (std::vector<Frames::Sent>{{16, 19, 1, 20ms}, {32, 35, 2, 30ms}}));
}

TEST(FrameFaults, OffDuplicatedAndGarbageDoWhatTheySay) {
  EXPECT_EQ(Frames({fault("camera:off@20ms..30ms")}).run(3).size(), 2u);
  EXPECT_EQ(Frames({fault("camera:duplicated@20ms..30ms")}).run(3).size(), 4u);
  EXPECT_NE(Frames({fault("camera:garbage@0")}).run(1), (std::vector<Frames::Sent>{{16, 19, 1, 10ms}}));
}

// ---- commands

/// A new command every millisecond, its first value i / 100, with a lease of 5 ms. Returns the value of motor 0 in the
/// last step of each millisecond (-1: none).
std::vector<double> motor(const std::vector<Fault>& faults, int ms, int commands_until_ms = 1000) {
  FaultLog log(faults, 1);
  ActuatorFaults motors(log, kMotors);
  std::vector<double> out;
  sim_hil::Setpoints newest;
  for (int step = 0; step < 4 * ms; ++step) {
    const hal::Time now = at(step * 250us);
    if (step % 4 == 0 && step / 4 <= commands_until_ms) {
      newest.valid = true, newest.count = 4, newest.lease = 5ms;
      newest.commit = newest.stamp = now;
      newest.value.fill(0.01 * (step / 4));
    }
    const sim_hil::Setpoints acting = motors.act(newest, now);
    EXPECT_TRUE(!acting.valid || now < acting.commit + acting.lease) << "an old command acts";
    if (step % 4 == 3) out.push_back(acting.valid ? acting.value[0] : -1);
  }
  return out;
}

TEST(ActuatorFaults, WithoutThemTheNewestCommandActs) {
  EXPECT_EQ(motor({}, 4), (std::vector<double>{0, 0.01, 0.02, 0.03}));
}

TEST(ActuatorFaults, LeaseRunsOutWhenNothingComesAnyMore) {
  const std::vector<double> silent{0, 0.01, 0.01, 0.01, 0.01, 0.01, -1, -1};
  EXPECT_EQ(motor({}, 8, 1), silent);
  EXPECT_EQ(motor({fault("motors:off@2ms")}, 8), silent);
  EXPECT_EQ(motor({fault("link:off@2ms")}, 8), silent);
}

TEST(ActuatorFaults, StuckKeepsValuesAndWrongWeakensOneMotor) {
  EXPECT_EQ(motor({fault("motors:stuck@2ms..4ms")}, 5), (std::vector<double>{0, 0.01, 0.01, 0.01, 0.04}));
  EXPECT_EQ(motor({fault("motors:wrong(0.5)@2ms")}, 3), (std::vector<double>{0, 0.01, 0.01}));
}

TEST(ActuatorFaults, SlowTakesOneOfSoManyCommands) {
  EXPECT_EQ(motor({fault("motors:slow(3)@1ms")}, 6), (std::vector<double>{0, 0.01, 0.01, 0.01, 0.04, 0.04}));
}

TEST(ActuatorFaults, DelayedActsLaterButNeverPastItsLease) {
  EXPECT_EQ(motor({fault("motors:delayed(2ms)@0")}, 5), (std::vector<double>{-1, -1, 0, 0.01, 0.02}));
  for (const double value : motor({fault("motors:delayed(6ms)@0")}, 20)) EXPECT_EQ(value, -1);
}

TEST(ActuatorFaults, GarbageStaysWithinWhatAMotorTakes) {
  for (const double value : motor({fault("motors:garbage@0")}, 50)) {
    EXPECT_GE(value, 0);
    EXPECT_LT(value, 1);
  }
}

// ---- a radio

msg::Datagram datagram(std::int64_t stamp_ms) {
  msg::Datagram d;
  d.stamp = hal::Time{stamp_ms * 1'000'000};
  d.sender = 1;
  d.size = 100;
  for (std::uint32_t i = 0; i < d.size; ++i) d.data[i] = static_cast<std::uint8_t>(stamp_ms + i);
  return d;
}

/// What a radio with one fault hears of 1000 datagrams, one each ms.
std::vector<msg::Datagram> heard_with(const char* text) {
  FaultLog log({fault(text)}, 7);
  RadioFaults radio(log);
  std::vector<msg::Datagram> heard;
  const auto take = [&](const msg::Datagram& d) {
    heard.push_back(d);
    return hal::Status{};
  };
  for (std::int64_t i = 0; i < 1000; ++i) {
    EXPECT_TRUE(radio.hears(datagram(i), take));
    EXPECT_TRUE(radio.release(hal::Time{i * 1'000'000}, take));
  }
  return heard;
}

std::size_t count_changed(const std::vector<msg::Datagram>& heard) {
  return static_cast<std::size_t>(std::ranges::count_if(
      heard, [](const msg::Datagram& d) { return d.data != datagram(d.stamp.ns / 1'000'000).data; }));
}

TEST(RadioFault, ThatIsOffIsDeafAndMute) {
  FaultLog log({fault("radio:off@0.1+0.2")}, 7);
  RadioFaults radio(log);
  int heard = 0, said = 0;
  for (std::int64_t i = 0; i < 1000; ++i) {
    EXPECT_TRUE(radio.hears(datagram(i), [&](const msg::Datagram&) { return ++heard, hal::Status{}; }));
    said += radio.says(hal::Time{i * 1'000'000});
  }
  EXPECT_EQ(heard, 800);
  EXPECT_EQ(said, 800);
  EXPECT_EQ(log.entries()[0].affected, 400u);
}

TEST(RadioFault, EachKindDoesToWhatIsHeardAsItsNameSays) {
  EXPECT_EQ(heard_with("radio:slow(4)@0").size(), 250u);
  EXPECT_EQ(heard_with("radio:duplicated@0").size(), 2000u);
  const auto bursts = heard_with("radio:intermittent(50ms)@0").size();
  EXPECT_GT(bursts, 200u);
  EXPECT_LT(bursts, 800u);
  const auto late = heard_with("radio:delayed(20ms)@0");
  EXPECT_EQ(late.size(), 980u);
  EXPECT_EQ(late[0].stamp, at(20ms));
  EXPECT_EQ(late[0].data, datagram(0).data);
  EXPECT_EQ(count_changed(heard_with("radio:garbage@0")), 1000u);
  EXPECT_NEAR(static_cast<double>(count_changed(heard_with("radio:wrong(0.3)@0"))), 300, 45);
  const auto stuck = heard_with("radio:stuck@0.5");
  EXPECT_EQ(stuck.size(), 1000u);
  EXPECT_EQ(stuck.back().data, datagram(499).data);
  EXPECT_EQ(stuck.back().stamp, at(999ms)) << "stamps are always true";
}

TEST(RadioFault, AWrongDatagramHasOneWrongBit) {
  for (const msg::Datagram& d : heard_with("radio:wrong(1)@0")) {
    const msg::Datagram sent = datagram(d.stamp.ns / 1'000'000);
    int bits = 0;
    for (std::size_t i = 0; i < d.data.size(); ++i)
      bits += std::popcount(static_cast<unsigned>(d.data[i] ^ sent.data[i]));
    ASSERT_EQ(bits, 1);
  }
}

}  // namespace
}  // namespace sinew::plant::fault_test
