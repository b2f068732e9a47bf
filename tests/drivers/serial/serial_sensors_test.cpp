// Range finder, satellite receiver and radio control on simulated serial lines (the kernel's pseudo terminals).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/serial/gnss_receiver.hpp"
#include "drivers/serial/rc_receiver.hpp"
#include "drivers/serial/tf_mini.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/platform.hpp"
#include "qemu_user.hpp"

namespace sinew::drivers::serial_sensors_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

/// A line that hands out the bytes of the test, so that the test controls the time.
class FakeSerial final : public hal::Serial {
 public:
  struct State {
    Bytes in, out;
    bool gone = false;
    int opened = 0;
  };
  explicit FakeSerial(State& s) : s_(s) {}
  hal::Result<std::size_t> read_now(std::span<std::uint8_t> into) noexcept override {
    if (s_.gone) return hal::Error{hal::Errc::closed, "fake"};
    const std::size_t n = std::min(into.size(), s_.in.size());
    std::copy_n(s_.in.begin(), n, into.begin());
    s_.in.erase(s_.in.begin(), s_.in.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }
  hal::Result<std::size_t> write_now(std::span<const std::uint8_t> bytes) noexcept override {
    s_.out.insert(s_.out.end(), bytes.begin(), bytes.end());
    return bytes.size();
  }
  hal::Status set_bit_rate(std::uint32_t) noexcept override { return {}; }
  hal::Result<bool> wait_readable(hal::Time) noexcept override { return !s_.in.empty(); }

 private:
  State& s_;
};

class SerialSensorTest : public ::testing::Test {
 protected:
  SerialOpener opener() {
    return [this](std::string& text) -> hal::Result<std::unique_ptr<hal::Serial>> {
      if (line.gone) {
        text = "/dev/ttyUSB0: there is no such device";
        return hal::Error{hal::Errc::not_found, "fake"};
      }
      ++line.opened;
      return std::unique_ptr<hal::Serial>(new FakeSerial(line));
    };
  }
  template <class Range>
  void come_in(const Range& bytes) {
    line.in.insert(line.in.end(), bytes.begin(), bytes.end());
  }
  template <class M>
  std::vector<M> poll(PolledDevice<M>& device, hal::Duration later = 1ms) {
    now = now + later;
    std::vector<M> out;
    const auto done = device.poll(now, out, why);
    error = done ? std::optional<hal::Errc>{} : done.error().code;
    return out;
  }
  FakeSerial::State line;
  hal::Time now{1'000'000'000};
  std::string why;
  std::optional<hal::Errc> error;
};

// ---- range finder

TEST_F(SerialSensorTest, TfMiniMeasuresAndSaysWhenNothingIsInRange) {
  TfMini device(opener());
  ASSERT_TRUE(device.set_up(why));
  come_in(wire::encode_tfmini(250, 1000));
  come_in(wire::encode_tfmini(0, 50));
  const auto out = poll(device);
  ASSERT_EQ(out.size(), 2u);
  EXPECT_DOUBLE_EQ(out[0].range_m, 2.5);
  EXPECT_EQ(out[0].stamp, now);
  EXPECT_TRUE(std::isnan(out[1].range_m));
}

TEST_F(SerialSensorTest, TfMiniTellsGarbageAndUnplugging) {
  TfMini device(opener());
  ASSERT_TRUE(device.set_up(why));
  come_in(Bytes(250, 0x37));
  EXPECT_TRUE(poll(device).empty());
  EXPECT_EQ(error, hal::Errc::bad_data);
  EXPECT_EQ(why, "only garbage comes in; a TFmini sends at 115200 bit/s");
  line.gone = true;
  poll(device);
  EXPECT_EQ(error, hal::Errc::closed);
  EXPECT_EQ(why, "the serial line is gone (unplugged?)");
  EXPECT_FALSE(device.set_up(why));
  EXPECT_EQ(why, "/dev/ttyUSB0: there is no such device");
}

// ---- satellites

std::string closed(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + body + end;
}

TEST_F(SerialSensorTest, GgaAndRmcOfOneInstantAreOneSample) {
  GnssReceiver device(opener(), {.delay = 50ms});
  ASSERT_TRUE(device.set_up(why));
  come_in(closed("GNGSA,A,3,01,02,03,,,,,,,,,,1.8,1.0,1.5"));
  come_in(closed("GNGGA,120000.00,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  EXPECT_TRUE(poll(device).empty()) << "the velocity is still to come";
  come_in(closed("GNRMC,120000.00,A,4730.0000,N,00830.0000,E,10.0,090.0,010126,,,A"));
  const auto out = poll(device);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].stamp, now - 1ms - 50ms) << "when its first sentence came, less the delay";
  EXPECT_DOUBLE_EQ(out[0].latitude_deg, 47.5);
  EXPECT_DOUBLE_EQ(out[0].longitude_deg, 8.5);
  EXPECT_DOUBLE_EQ(out[0].altitude_m, 450);
  EXPECT_NEAR(out[0].velocity_mps.x, 5.14444, 1e-4) << "east";
  EXPECT_NEAR(out[0].velocity_mps.y, 0, 1e-9);
  EXPECT_TRUE(std::isnan(out[0].velocity_mps.z)) << "NMEA does not say";
  EXPECT_DOUBLE_EQ(out[0].horizontal_accuracy_m, 2.5);
  EXPECT_DOUBLE_EQ(out[0].vertical_accuracy_m, 3.75);
  EXPECT_EQ(out[0].fix, msg::GnssFix::full);
  EXPECT_EQ(out[0].satellites, 12u);
}

TEST_F(SerialSensorTest, WithoutRmcAPositionComesWithTheNextOne) {
  GnssReceiver device(opener(), {});
  ASSERT_TRUE(device.set_up(why));
  come_in(closed("GPGGA,120000.00,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  come_in(closed("GPGGA,120000.20,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  const auto out = poll(device);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_TRUE(std::isnan(out[0].velocity_mps.x));
}

TEST_F(SerialSensorTest, WithoutFixThePositionIsNoNumber) {
  GnssReceiver device(opener(), {});
  ASSERT_TRUE(device.set_up(why));
  come_in(closed("GNGGA,120000.00,,,,,0,00,99.99,,,,,,"));
  come_in(closed("GNRMC,120000.00,V,,,,,,,010126,,,N"));
  const auto out = poll(device);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].fix, msg::GnssFix::none);
  EXPECT_TRUE(std::isnan(out[0].latitude_deg));
}

TEST_F(SerialSensorTest, UbxGoesBeforeNmea) {
  GnssReceiver device(opener(), {.configure_ubx = true, .period_ms = 100});
  ASSERT_TRUE(device.set_up(why));
  EXPECT_EQ(line.out.size(), 14u + 11u);
  EXPECT_EQ(Bytes(line.out.begin(), line.out.begin() + 8), (Bytes{0xB5, 0x62, 6, 8, 6, 0, 100, 0}));
  wire::UbxPvt pvt;
  pvt.sample.latitude_deg = 47.25;
  pvt.sample.velocity_mps = {1, 2, 3};
  pvt.sample.fix = msg::GnssFix::rtk_fixed;
  std::array<std::uint8_t, 128> frame{};
  const std::size_t n = wire::encode_nav_pvt(pvt, frame);
  come_in(std::span(frame).first(n));
  come_in(closed("GPGGA,120000.00,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  come_in(closed("GPRMC,120000.00,A,4730.0000,N,00830.0000,E,10.0,090.0,010126,,,A"));
  auto out = poll(device);
  ASSERT_EQ(out.size(), 1u) << "one instant, one sample";
  EXPECT_NEAR(out[0].latitude_deg, 47.25, 1e-7);
  EXPECT_EQ(out[0].velocity_mps, (msg::Vec3{1, 2, 3}));
  EXPECT_EQ(out[0].fix, msg::GnssFix::rtk_fixed);
  come_in(closed("GPGGA,120003.00,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  come_in(closed("GPRMC,120003.00,A,4730.0000,N,00830.0000,E,10.0,090.0,010126,,,A"));
  out = poll(device, 3s);
  EXPECT_EQ(out.size(), 1u) << "UBX is silent: NMEA counts again";
}

TEST_F(SerialSensorTest, ASolutionThatIsRepeatedIsOneSampleAndAClockThatStandsIsTold) {
  GnssReceiver device(opener(), {});
  ASSERT_TRUE(device.set_up(why));
  const auto solution = [&](std::uint32_t week_ms, msg::GnssFix fix) {
    wire::UbxPvt pvt;
    pvt.time_of_week_ms = week_ms;
    pvt.sample.latitude_deg = 47.25;
    pvt.sample.fix = fix;
    std::array<std::uint8_t, 128> frame{};
    come_in(std::span(frame).first(wire::encode_nav_pvt(pvt, frame)));
  };
  for (const std::uint32_t week_ms : {1000u, 1000u, 1200u, 1200u, 1200u}) solution(week_ms, msg::GnssFix::full);
  EXPECT_EQ(poll(device).size(), 2u);
  EXPECT_FALSE(error);
  solution(1200, msg::GnssFix::full);
  EXPECT_TRUE(poll(device, 2s).empty());
  EXPECT_EQ(error, hal::Errc::bad_data);
  EXPECT_EQ(why, "sends the same instant again and again (its clock stands; power it off and on)");
  solution(3400, msg::GnssFix::full);
  EXPECT_EQ(poll(device).size(), 1u);
  EXPECT_FALSE(error);
  solution(3400, msg::GnssFix::none);
  solution(3400, msg::GnssFix::none);
  EXPECT_EQ(poll(device, 3s).size(), 2u) << "without a position its clock may stand: it says so each time";
  EXPECT_FALSE(error);
}

TEST_F(SerialSensorTest, AWrongBitRateOfAReceiverIsTold) {
  GnssReceiver device(opener(), {});
  ASSERT_TRUE(device.set_up(why));
  come_in(Bytes(2048, 0xF8));
  poll(device);
  EXPECT_EQ(error, hal::Errc::bad_data);
  EXPECT_THAT(why, HasSubstr("wrong bit rate?"));
}

TEST_F(SerialSensorTest, SentencesThatAreRepeatedAreOneSampleAndAClockThatStandsIsTold) {
  GnssReceiver device(opener(), {});
  ASSERT_TRUE(device.set_up(why));
  const std::string gga = closed("GNGGA,120000.00,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,");
  const std::string rmc = closed("GNRMC,120000.00,A,4730.0000,N,00830.0000,E,10.0,090.0,010126,,,A");
  for (const std::string& sentence : {gga, gga, rmc, rmc, gga, rmc}) come_in(sentence);
  EXPECT_EQ(poll(device).size(), 1u);
  EXPECT_FALSE(error);
  come_in(gga);
  EXPECT_TRUE(poll(device, 2s).empty());
  EXPECT_EQ(error, hal::Errc::bad_data);
  EXPECT_EQ(why, "sends the same instant again and again (its clock stands; power it off and on)");
  come_in(closed("GNGGA,120002.20,4730.0000,N,00830.0000,E,1,12,1.0,450.0,M,47.0,M,,"));
  come_in(closed("GNRMC,120002.20,A,4730.0000,N,00830.0000,E,10.0,090.0,010126,,,A"));
  EXPECT_EQ(poll(device).size(), 1u);
  EXPECT_FALSE(error);
}

// ---- radio control

Bytes sbus(double first, bool missed = false, bool failsafe = false) {
  wire::SbusFrame f;
  f.channel.fill(wire::kRcMiddle);
  f.channel[0] = wire::rc_count(first);
  f.frame_lost = missed;
  f.failsafe = failsafe;
  const auto bytes = wire::encode_sbus(f);
  return {bytes.begin(), bytes.end()};
}

class RcTest : public SerialSensorTest {
 protected:
  std::vector<msg::RcSample> frame(RcReceiver& rc, const Bytes& bytes) {
    come_in(bytes);
    return poll(rc, 14ms);
  }
};

TEST_F(RcTest, SbusFramesAreSticks) {
  RcReceiver rc(opener(), {.protocol = RcProtocol::sbus});
  ASSERT_TRUE(rc.set_up(why));
  frame(rc, {});
  const auto out = frame(rc, sbus(0.5));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NEAR(out[0].channel[0], 0.5, 1e-3);
  EXPECT_EQ(out[0].channel[1], 0);
  EXPECT_EQ(out[0].count, 16u);
  EXPECT_EQ(out[0].lost, 0u);
  EXPECT_DOUBLE_EQ(out[0].link_quality, 1);
}

TEST_F(RcTest, MissedFramesLowerTheQualityAndFailsafeIsLost) {
  RcReceiver rc(opener(), {.protocol = RcProtocol::sbus});
  ASSERT_TRUE(rc.set_up(why));
  frame(rc, {});
  frame(rc, sbus(0.5));
  EXPECT_TRUE(frame(rc, sbus(0.5, true)).empty()) << "the sticks of before say nothing new";
  auto out = frame(rc, sbus(0.5));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_LT(out[0].link_quality, 1);
  EXPECT_GT(out[0].link_quality, 0.9);
  out = frame(rc, sbus(0.5, true, true));
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].lost, 1u);
  EXPECT_EQ(out[0].channel[0], 0) << "what the receiver makes up is no stick";
}

TEST_F(RcTest, SilenceIsALostLinkAgainAndAgain) {
  RcReceiver rc(opener(), {.protocol = RcProtocol::crsf, .lost_after = 100ms});
  ASSERT_TRUE(rc.set_up(why));
  EXPECT_TRUE(poll(rc).empty());
  EXPECT_TRUE(poll(rc, 99ms).empty());
  int lost = 0;
  for (int i = 0; i < 30; ++i)
    for (const msg::RcSample& s : poll(rc, 10ms)) lost += static_cast<int>(s.lost);
  EXPECT_EQ(lost, 3);
}

TEST_F(RcTest, CrsfTellsQualityAndStrength) {
  RcReceiver rc(opener(), {});
  ASSERT_TRUE(rc.set_up(why));
  wire::RcCounts counts{};
  counts.fill(wire::kRcMiddle);
  counts[2] = wire::kRcHigh;
  come_in(wire::encode_crsf_channels(counts));
  auto out = poll(rc);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].channel[2], 1);
  EXPECT_TRUE(std::isnan(out[0].link_quality)) << "not told yet";
  come_in(wire::encode_crsf_link({.rssi_dbm = -70, .link_quality = 0.8, .snr_db = 5}));
  come_in(wire::encode_crsf_channels(counts));
  out = poll(rc);
  ASSERT_EQ(out.size(), 1u);
  EXPECT_DOUBLE_EQ(out[0].link_quality, 0.8);
  EXPECT_DOUBLE_EQ(out[0].rssi_dbm, -70);
}

TEST_F(RcTest, AQualityOfZeroIsLostWhateverTheChannelsSay) {
  RcReceiver rc(opener(), {});
  ASSERT_TRUE(rc.set_up(why));
  wire::RcCounts counts{};
  counts.fill(wire::kRcHigh);
  come_in(wire::encode_crsf_link({.rssi_dbm = -130, .link_quality = 0, .snr_db = -20}));
  come_in(wire::encode_crsf_channels(counts));
  const auto out = poll(rc);
  ASSERT_EQ(out.size(), 2u);
  for (const msg::RcSample& s : out) {
    EXPECT_EQ(s.lost, 1u);
    EXPECT_EQ(s.channel[0], 0);
  }
}

TEST_F(RcTest, GarbageMovesNoStickAndIsALostLink) {
  for (const RcProtocol protocol : {RcProtocol::sbus, RcProtocol::crsf}) {
    RcReceiver rc(opener(), {.protocol = protocol});
    ASSERT_TRUE(rc.set_up(why));
    std::uint32_t random = 1;
    int lost = 0;
    for (int i = 0; i < 100; ++i) {
      Bytes noise(30);
      for (auto& b : noise) random = random * 1664525 + 1013904223, b = static_cast<std::uint8_t>(random >> 24);
      for (const msg::RcSample& s : frame(rc, noise)) {
        EXPECT_EQ(s.lost, 1u);
        lost += 1;
      }
    }
    EXPECT_GE(lost, 5) << "1.4 s";
    EXPECT_GT(rc.garbage(), 2000u);
  }
}

// ---- on its own thread, on a line of the kernel

TEST(SerialSensorThread, APilotIsUnpluggedAndPluggedInAgain) {
  SINEW_SKIP_UNDER_QEMU_USER("it knows no struct termios2, which free bit rates need");
  auto& os = hal::system_os();
  auto far = hal::make_pseudo_serial();
  ASSERT_TRUE(far);
  std::string path = far->path, why;
  std::mutex mutex;  // the opener runs on the sensor's thread
  const auto opener = [&](std::string& text) {
    const std::lock_guard lock(mutex);
    return hal::open_serial({.path = path, .bit_rate = 420000}, text);
  };
  PollOptions options;
  options.name = "rc";
  options.retry_first = 2ms;
  options.retry_most = 10ms;
  auto rc = PolledSensor<msg::RcSample>::start(os, std::make_unique<RcReceiver>(opener, RcConfig{}), options, why);
  ASSERT_TRUE(rc) << why;
  wire::RcCounts counts{};
  counts.fill(wire::kRcHigh);
  const auto frame = wire::encode_crsf_channels(counts);
  const auto moves = [&] {
    const hal::Time deadline = os.now() + 10s;
    while (os.now() < deadline) {
      if (far->end) (void)far->end->write_now(frame);
      msg::RcSample s;
      const auto got = (*rc)->read(s);
      if (got && *got && s.lost == 0 && s.channel[0] == 1) return true;
      os.sleep_until(os.now() + 2ms);
    }
    return false;
  };
  EXPECT_TRUE(moves());
  far->end.reset();
  const hal::Time deadline = os.now() + 10s;
  while (!(*rc)->gone() && os.now() < deadline) os.sleep_until(os.now() + 1ms);
  EXPECT_TRUE((*rc)->gone());
  {
    const std::lock_guard lock(mutex);
    far = hal::make_pseudo_serial();
    ASSERT_TRUE(far);
    path = far->path;
  }
  while ((*rc)->stats().restarts == 0 && os.now() < deadline) os.sleep_until(os.now() + 1ms);
  EXPECT_EQ((*rc)->stats().restarts, 1u);
  msg::RcSample old;  // what came before it was unplugged
  for (auto got = (*rc)->read(old); got && *got;) got = (*rc)->read(old);
  EXPECT_TRUE(moves()) << (*rc)->trouble();
}

}  // namespace
}  // namespace sinew::drivers::serial_sensors_test
