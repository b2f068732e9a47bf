// The texts for a bus or port that cannot be opened; and serial lines as far as the kernel's pseudo terminals go.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>
#include <fstream>

#include "hal/linux/devices/gpio.hpp"
#include "hal/linux/devices/i2c.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/linux/devices/spi.hpp"
#include "hal/linux/open_error.hpp"
#include "hal/platform.hpp"
#include "qemu_user.hpp"
#include "temp_folder.hpp"

namespace sinew::hal::buses_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

TEST(OpenError, SaysWhatToDo) {
  std::string why;
  EXPECT_EQ(open_error("/dev/x", ENOENT, {"plug it in"}, "t", why).code, Errc::not_found);
  EXPECT_EQ(why, "/dev/x: there is no such device; plug it in");
  EXPECT_EQ(open_error("/dev/x", EBUSY, {}, "t", why).code, Errc::busy);
  EXPECT_EQ(why, "/dev/x: somebody else holds it; find out who with: fuser -v /dev/x");
  EXPECT_EQ(open_error("/dev/x", EMFILE, {}, "t", why).code, Errc::io);
  EXPECT_EQ(why, "/dev/x: Too many open files");
}

TEST(OpenError, PermissionDeniedNamesTheGroupThatMay) {
  test::TempFolder folder;
  const std::string path = folder.path() + "/i2c-1";
  std::ofstream(path) << "x";
  ASSERT_EQ(::chmod(path.c_str(), 0600), 0);
  std::string why;
  EXPECT_EQ(open_error(path, EACCES, {}, "t", why).code, Errc::denied);
  EXPECT_THAT(why, HasSubstr("i2c-1: permission denied; only its owner may: give it to a group with a udev rule"));
  if (::geteuid() == 0) {  // needs a group that is not root's
    ASSERT_EQ(::chown(path.c_str(), 0, 20), 0);
    ASSERT_EQ(::chmod(path.c_str(), 0660), 0);
    open_error(path, EACCES, {}, "t", why);
    EXPECT_THAT(why, HasSubstr("group 'dialout' may: sudo usermod -aG dialout USER"));
  }
}

template <class Open>
void expect_refused(Open open, Errc code, const std::string& text) {
  std::string why;
  const auto got = open(why);
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, code) << why;
  EXPECT_THAT(why, HasSubstr(text));
}

TEST(I2c, AnAbsentOrOtherFileIsToldInWords) {
  expect_refused([](std::string& w) { return open_i2c("/dev/i2c-250", w); }, Errc::not_found,
                 "/dev/i2c-250: there is no such device; load the module (sudo modprobe i2c-dev)");
  SINEW_SKIP_UNDER_QEMU_USER("it knows no ioctls of I2C buses");
  expect_refused([](std::string& w) { return open_i2c("/dev/null", w); }, Errc::not_supported,
                 "/dev/null: is no I2C bus; one is called /dev/i2c-N");
}

TEST(Spi, AnAbsentOrOtherFileOrModeIsToldInWords) {
  expect_refused([](std::string& w) { return open_spi({.path = "/dev/spidev9.9"}, w); }, Errc::not_found,
                 "/dev/spidev9.9: there is no such device; the chip select needs a 'spidev' node");
  expect_refused([](std::string& w) { return open_spi({.path = "/dev/null", .mode = 4}, w); }, Errc::bad_argument,
                 "mode is 0 to 3");
  SINEW_SKIP_UNDER_QEMU_USER("it knows no ioctls of SPI devices");
  expect_refused([](std::string& w) { return open_spi({.path = "/dev/null"}, w); }, Errc::not_supported,
                 "/dev/null: is no SPI device");
}

TEST(Gpio, AnAbsentOrOtherChipIsToldInWords) {
  GpioSpec s;
  s.chip = "/dev/gpiochip250";
  s.line = "3";
  expect_refused([&](std::string& w) { return open_gpio(s, w); }, Errc::not_found, "gpiochip250: there is no such");
  s.chip = "no-such-label";
  expect_refused([&](std::string& w) { return open_gpio(s, w); }, Errc::not_found,
                 "gpio chip 'no-such-label': no chip has this label; there are: ");
  s.output = s.rising = true;
  expect_refused([&](std::string& w) { return open_gpio(s, w); }, Errc::bad_argument, "an output has no edges");
  SINEW_SKIP_UNDER_QEMU_USER("it knows no ioctls of GPIO chips");
  s.output = s.rising = false;
  s.chip = "/dev/null";
  expect_refused([&](std::string& w) { return open_gpio(s, w); }, Errc::not_supported, "/dev/null: is no GPIO chip");
}

class SerialTest : public ::testing::Test {
 protected:
  SerialTest() {
    auto made = make_pseudo_serial();
    if (made) far = std::move(made->end), path = made->path;
  }
  void SetUp() override { SINEW_SKIP_UNDER_QEMU_USER("it knows no struct termios2, which free bit rates need"); }
  std::unique_ptr<Serial> open(SerialSpec spec) {
    spec.path = path;
    auto line = open_serial(spec, why);
    if (!line) return nullptr;
    return std::move(*line);
  }
  std::unique_ptr<Serial> far;
  std::string path, why;
};

TEST_F(SerialTest, BytesGoBothWaysUntouched) {
  auto line = open({});
  ASSERT_TRUE(line) << why;
  std::vector<std::uint8_t> all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);  // control characters, too
  for (Serial* to : {line.get(), far.get()}) {
    Serial& from = to == line.get() ? *far : *line;
    ASSERT_EQ(*from.write_now(all), all.size());
    std::vector<std::uint8_t> got;
    const Time deadline = system_os().now() + 10s;
    while (got.size() < all.size() && system_os().now() < deadline) {
      ASSERT_TRUE(to->wait_readable(deadline));
      std::array<std::uint8_t, 64> part{};
      const auto n = to->read_now(part);
      ASSERT_TRUE(n);
      got.insert(got.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(*n));
    }
    EXPECT_EQ(got, all);
  }
}

TEST_F(SerialTest, NothingThereIsZeroAndNotAnError) {
  auto line = open({});
  ASSERT_TRUE(line) << why;
  std::array<std::uint8_t, 8> into{};
  const auto n = line->read_now(into);
  ASSERT_TRUE(n);
  EXPECT_EQ(*n, 0u);
  const auto waited = line->wait_readable(system_os().now() + 1ms);
  ASSERT_TRUE(waited);
  EXPECT_FALSE(*waited);
}

TEST_F(SerialTest, OddBitRatesOfReceiversAreSet) {
  auto sbus = open({.path = {}, .bit_rate = 100000, .even_parity = true, .two_stop_bits = true});
  ASSERT_TRUE(sbus) << why;
  EXPECT_TRUE(sbus->set_bit_rate(420000));
  EXPECT_FALSE(sbus->set_bit_rate(0));
}

TEST_F(SerialTest, OnlyOneMayHoldIt) {
  auto line = open({});
  ASSERT_TRUE(line) << why;
  EXPECT_FALSE(open({}));
  EXPECT_THAT(why, HasSubstr("somebody else holds it; find out who with: fuser -v " + path));
  line.reset();
  EXPECT_TRUE(open({})) << why;
}

TEST_F(SerialTest, AnUnpluggedLineIsClosed) {
  auto line = open({});
  ASSERT_TRUE(line) << why;
  far.reset();
  std::array<std::uint8_t, 8> into{};
  const auto n = line->read_now(into);
  ASSERT_FALSE(n);
  EXPECT_EQ(n.error().code, Errc::closed);
  const auto waited = line->wait_readable(system_os().now() + 10s);
  EXPECT_TRUE(!waited || *waited) << "who sleeps is woken";
}

TEST_F(SerialTest, WhatCannotBeIsToldInWords) {
  EXPECT_FALSE(open({.path = {}, .inverted = true}));
  EXPECT_THAT(why, HasSubstr("put an inverter before RX"));
  EXPECT_FALSE(open({.path = {}, .bit_rate = 0}));
  EXPECT_THAT(why, HasSubstr("bit rate is more than 0"));
  path = "/dev/ttyNONE";
  EXPECT_FALSE(open({}));
  EXPECT_THAT(why, HasSubstr("/dev/ttyNONE: there is no such device; see what is there with: ls -l /dev/serial/by-id"));
  path = "/dev/null";
  EXPECT_FALSE(open({}));
  EXPECT_THAT(why, HasSubstr("/dev/null: is no serial line"));
}

}  // namespace
}  // namespace sinew::hal::buses_test
