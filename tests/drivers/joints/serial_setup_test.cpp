// Ids and bit rates of servos changed on simulated lines, in virtual time.
#include "drivers/joints/serial_setup.hpp"

#include <gmock/gmock.h>

#include "servo_rig.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::drivers::serial_setup_test {
namespace {

using ::testing::HasSubstr;

/// A line that carries bytes between a host and servos at one rate alone: each servo is asked for its own. Time goes on
/// while somebody waits.
class Bench final : public hal::Os, public hal::Serial {
 public:
  explicit Bench(std::uint32_t bit_rate = 57'600) : wire({.bit_rate = bit_rate}, clock), rate_(bit_rate) {
    clock.set({1'000'000'000});
  }
  sim_hil::SimSerialServo& add(std::string_view model, std::uint8_t id) {
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    sim_hil::SimSerialServo::Parameters p;
    p.id = id, p.model = wire::servo_model(model);
    sims.push_back(std::make_unique<sim_hil::SimSerialServo>(wire, *joints.back(), sim_hil::SimMount{}, p));
    pass(1ms);
    return *sims.back();
  }
  /// "id 7 at 1000000" of the servo as it is then, or why not.
  std::string change(const SerialChange& change) {
    std::string why;
    const auto servo = change_servo(*this, *this, change, why);
    if (!servo) return std::string(to_string(servo.error().code)) + ": " + why;
    return "id " + std::to_string(servo->id) + " at " + std::to_string(servo->bit_rate) + ": " +
           std::string(servo->model ? servo->model->name : "");
  }
  void pass(Duration d) {
    for (const Time end = clock.now() + d; clock.now() < end;) {
      clock.set(clock.now() + 100us);
      wire.advance(clock.now());
    }
  }

  // hal::Serial
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override {
    return wire.host().read_now(into);
  }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    // As the servo's register says: after it was written, the old rate reaches it no more.
    std::uint32_t its = rate_;
    if (written_rate)
      if (const auto code = sims[0]->number(written_rate->bit_rate); true)
        for (const wire::ServoRate& r : written_rate->rates)
          if (r.code == code) its = r.bit_rate;
    return its == now_ ? wire.host().write_now(bytes) : hal::Result<std::size_t>(bytes.size());
  }
  hal::Status set_bit_rate(std::uint32_t rate) noexcept override {
    now_ = rate;
    return {};
  }
  hal::Result<bool> wait_readable(Time t) noexcept override {
    for (const Time end = std::min(t, now() + 50ms); now() < end;) {
      pass(100us);
      if (const auto ready = wire.host().wait_readable(now()); ready && *ready) return true;
    }
    return false;
  }
  // hal::Os
  Time now() const noexcept override { return clock.now(); }
  void sleep_until(Time t) noexcept override { pass(t - now()); }
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
  sim_hil::SimSerialLine wire;
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  std::vector<std::unique_ptr<sim_hil::SimSerialServo>> sims;
  const wire::ServoModel* written_rate = nullptr;  // the first servo listens at what its register says

 private:
  std::uint32_t rate_, now_ = 0;
};

TEST(SerialSetup, AServoOfEveryMakerGetsAnotherId) {
  for (const char* model : {"xm430_w350", "mx28", "sts3215", "scs0009"}) {
    Bench bench;
    sim_hil::SimSerialServo& servo = bench.add(model, 1);
    EXPECT_EQ(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 7}), std::string("id 7 at 57600: ") + model);
    EXPECT_EQ(servo.number(wire::servo_model(model)->id), 7) << model;
    EXPECT_FALSE(servo.live());
  }
}

TEST(SerialSetup, BothAreChangedAtOnceAndTheServoIsThereUnderThem) {
  for (const char* model : {"xm430_w350", "sts3215", "ax12"}) {
    Bench bench;
    const wire::ServoModel& m = *wire::servo_model(model);
    sim_hil::SimSerialServo& servo = bench.add(model, 1);
    servo.set_number(m.bit_rate, *wire::servo_rate_code(m, 57'600));
    bench.written_rate = &m;
    EXPECT_EQ(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 7, .new_bit_rate = 1'000'000}),
              std::string("id 7 at 1000000: ") + model);
    if (m.maker == wire::ServoMaker::feetech) {
      EXPECT_EQ(servo.number(m.lock), 1) << "closed again";
    }
  }
}

TEST(SerialSetup, OneThatIsLiveLosesItsTorqueFirst) {
  Bench bench;
  const wire::ServoModel& m = *wire::servo_model("xm430_w350");
  bench.add("xm430_w350", 1);
  static_cast<void>(bench.set_bit_rate(57'600));
  wire::DxlBuilder on = wire::dxl_write(m.version, 1, m.torque_enable.address, std::array<std::uint8_t, 1>{1});
  static_cast<void>(bench.write_now(on.finish()));
  bench.pass(20ms);
  ASSERT_TRUE(bench.sims[0]->live());
  EXPECT_EQ(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 2}), "id 2 at 57600: xm430_w350");
  EXPECT_FALSE(bench.sims[0]->live());
}

TEST(SerialSetup, AnIdThatIsTakenIsNotGiven) {
  Bench bench;
  bench.add("xm430_w350", 1);
  bench.add("xl430_w250", 2);
  EXPECT_EQ(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 2}),
            std::string(to_string(hal::Errc::busy)) + ": id 2 at 57600 bit/s is taken");
  EXPECT_EQ(bench.sims[0]->number(wire::servo_model("xm430_w350")->id), 1);
}

TEST(SerialSetup, WhatCannotBeIsSaidAndNothingIsWritten) {
  Bench bench;
  bench.add("sts3215", 1);
  EXPECT_THAT(bench.change({.id = 3, .bit_rate = 57'600, .new_id = 2}),
              HasSubstr("id 3 at 57600 bit/s: nobody answers"));
  EXPECT_THAT(
      bench.change({.id = 1, .bit_rate = 57'600, .new_bit_rate = 2'000'000}),
      HasSubstr("STS3215 cannot do 2000000 bit/s; it can do 38400, 57600, 76800, 115200, 128000, 250000, 500000, "
                "1000000"));
  EXPECT_THAT(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 254}), HasSubstr("an id is from 0 to 253"));
  EXPECT_EQ(bench.change({.id = 1, .bit_rate = 57'600}), "id 1 at 57600: sts3215");
  EXPECT_EQ(bench.sims[0]->number(wire::servo_model("sts3215")->id), 1);
}

TEST(SerialSetup, TwoWithTheIdAreNotChanged) {
  Bench bench;
  bench.add("xm430_w350", 1);
  bench.add("xl430_w250", 1);
  EXPECT_THAT(bench.change({.id = 1, .bit_rate = 57'600, .new_id = 2}), HasSubstr("two servos with this id?"));
}

}  // namespace
}  // namespace sinew::drivers::serial_setup_test
