// The scan of a serial line: simulated servos of all makers, byte times, in virtual time.
#include "drivers/joints/serial_scan.hpp"

#include <gmock/gmock.h>

#include "servo_rig.hpp"
#include "sim_hil/wire/sim_serial_servo.hpp"

namespace sinew::drivers::serial_scan_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using wire::DxlVersion;

/// A line whose servos are set to its one bit rate; at another the host's bytes reach nobody.
class OneRate final : public hal::Serial {
 public:
  OneRate(hal::Serial& line, std::uint32_t rate) : line_(line), rate_(rate), now_(rate) {}
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override { return line_.read_now(into); }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    if (gone) return hal::Error{hal::Errc::closed, "serial: the line is gone"};
    return now_ == rate_ ? line_.write_now(bytes) : hal::Result<std::size_t>(bytes.size());
  }
  hal::Status set_bit_rate(std::uint32_t rate) noexcept override {
    if (rate == cannot) return hal::Error{hal::Errc::not_supported, "serial", rate_};
    now_ = rate;
    return {};
  }
  hal::Result<bool> wait_readable(Time) noexcept override { return false; }
  std::uint32_t cannot = 0;
  bool gone = false;

 private:
  hal::Serial& line_;
  std::uint32_t rate_, now_;
};

class Bench {
 public:
  explicit Bench(const sim_hil::SimLineOptions& options = {})
      : wire(options, os.clock), line(wire.host(), options.bit_rate) {
    os.clock.set({1'000'000'000});
  }
  sim_hil::SimSerialServo& add(std::string_view model, std::uint8_t id) {
    joints.push_back(std::make_unique<sim_hil::JointModel>());
    sim_hil::SimSerialServo::Parameters p;
    p.id = id, p.model = wire::servo_model(model);
    sims.push_back(std::make_unique<sim_hil::SimSerialServo>(wire, *joints.back(), sim_hil::SimMount{}, p));
    os.clock.set(os.now() + 1ms);
    wire.advance(os.now());  // it has come up
    return *sims.back();
  }
  /// "2.0 7 XM430-W350 ..." of each that is found.
  std::vector<std::string> scan(const SerialScan::Options& options) {
    SerialScan scan(line, options);
    const Time begin = os.now();
    while (!scan.done()) {
      const auto next = scan.step(os.now());
      if (!next) return {to_string(next.error().code)};
      os.clock.set(std::max(os.now() + 1us, std::min(*next, wire.next())));
      wire.advance(os.now());
    }
    took = os.now() - begin;
    longest = scan.longest();
    skipped = scan.skipped();
    std::vector<std::string> all;
    for (const SerialFound& f : scan.found())
      all.push_back((f.version == DxlVersion::two ? "2.0 " : "1.0 ") + std::to_string(f.id) + " at " +
                    std::to_string(f.bit_rate) + ": " + (f.broken ? "" : std::string(to_string(f.maker)) + " ") +
                    describe(f));
    return all;
  }

  StillOs os;
  sim_hil::SimSerialLine wire;
  OneRate line;
  std::vector<std::unique_ptr<sim_hil::JointModel>> joints;
  std::vector<std::unique_ptr<sim_hil::SimSerialServo>> sims;
  Duration took{}, longest{};
  std::vector<std::uint32_t> skipped;
};

TEST(SerialScan, ServosOfEveryMakerAreFoundWithWhatTheySayOfThemselves) {
  for (const bool echo : {false, true}) {
    Bench bench({.echo = echo});
    bench.add("xm430_w350", 1);
    bench.add("xl430_w250", 252);
    bench.add("ax12", 0).fail(1u << 5);
    bench.add("mx28", 4);
    bench.add("sts3215", 7);
    bench.add("scs0009", 253);
    bench.sims[4]->temperature_c = 61;
    bench.sims[0]->fail(1u << 2);
    EXPECT_THAT(bench.scan({}),
                ElementsAre("2.0 1 at 1000000: dynamixel XM430-W350 (xm430_w350), firmware 0, 12.0 V, 25 C, fault: "
                            "over-temperature (code 0x04)",
                            "2.0 252 at 1000000: dynamixel XL430-W250 (xl430_w250), firmware 0, 12.0 V, 25 C",
                            "1.0 0 at 1000000: dynamixel AX-12A (ax12), firmware 0, 12.0 V, 25 C, fault: overload "
                            "(stuck, or too far behind its setpoint) (code 0x20)",
                            "1.0 4 at 1000000: dynamixel MX-28 (protocol 1.0) (mx28), firmware 0, 12.0 V, 25 C",
                            "1.0 7 at 1000000: feetech STS3215 (sts3215), firmware 0.0, 12.0 V, 61 C",
                            "1.0 253 at 1000000: feetech SCS0009 (scs0009), firmware 0.0, 12.0 V, 25 C"))
        << echo;
    EXPECT_LE(bench.took, bench.longest);
  }
}

TEST(SerialScan, NothingIsWrittenAndNoTorqueIsEnabled) {
  Bench bench;
  bench.add("xm430_w350", 1);
  bench.add("sts3215", 2);
  EXPECT_EQ(bench.scan({}).size(), 2u);
  for (const auto& sim : bench.sims) EXPECT_FALSE(sim->live());
  EXPECT_EQ(bench.sims[0]->number(wire::servo_model("xm430_w350")->return_delay), 250) << "as the factory set it";
}

TEST(SerialScan, AServoIsFoundAtItsBitRateAndAnotherOneIsSaidThatTheLineCannotDo) {
  Bench bench({.bit_rate = 57'600});
  bench.add("xm430_w350", 3);
  bench.line.cannot = 4'000'000;
  EXPECT_THAT(bench.scan({.bit_rates = {1'000'000, 4'000'000, 57'600}}),
              ElementsAre("2.0 3 at 57600: dynamixel XM430-W350 (xm430_w350), firmware 0, 12.0 V, 25 C"));
  EXPECT_THAT(bench.skipped, ElementsAre(4'000'000u));
}

TEST(SerialScan, AnEmptyLineTakesWhatWasSaidBefore) {
  Bench bench;
  const SerialScan::Options options{.versions = {DxlVersion::two}};
  EXPECT_THAT(bench.scan(options), IsEmpty());
  // 253 ids: 10 bytes of a ping and 14 of its answer, 0.7 ms of a servo, 5 ms of the adapter.
  EXPECT_EQ(bench.longest, 253 * (240us + 700us + 5ms));
  EXPECT_LE(bench.took, bench.longest + 253 * 1us);
}

TEST(SerialScan, TwoServosWithOneIdAreSaid) {
  Bench bench;
  bench.add("xm430_w350", 1);
  bench.add("xl430_w250", 1);
  EXPECT_THAT(bench.scan({.versions = {DxlVersion::two}, .most_id = 5}),
              ElementsAre("2.0 1 at 1000000: answers that are not whole: two servos with this id? Connect them one by "
                          "one, and change the id of one"));
}

TEST(SerialScan, AModelThatIsNotKnownHasItsNumber) {
  Bench bench;
  bench.add("xm430_w350", 9).set_number(wire::servo_model("xm430_w350")->model_number, 1234);
  EXPECT_THAT(bench.scan({.versions = {DxlVersion::two}, .most_id = 10}),
              ElementsAre("2.0 9 at 1000000: dynamixel model number 1234, which is not known here, firmware 0"));
}

TEST(SerialScan, ALostByteIsAskedForAgain) {
  Bench bench;
  bench.add("sts3215", 2);
  int bytes = 0;
  bench.wire.set_tamper([&](std::uint8_t b) { return ++bytes == 30 ? std::nullopt : std::optional(b); });
  EXPECT_EQ(bench.scan({.versions = {DxlVersion::one}, .most_id = 3}).size(), 1u);
  EXPECT_GT(bytes, 40);
}

TEST(SerialScan, ALineThatIsGoneEndsIt) {
  Bench bench;
  bench.line.gone = true;
  EXPECT_THAT(bench.scan({}), ElementsAre(to_string(hal::Errc::closed)));
}

}  // namespace
}  // namespace sinew::drivers::serial_scan_test
