// The kernel's IIO read by the real driver, from a simulated tree; and from the real kernel where SINEW_IIO names a
// device (with SINEW_IIO_TRIGGER, SINEW_IIO_RATE, SINEW_IIO_POLL=1; SINEW_IIO_NO_TRIGGER=1: it has none and is polled).
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "hal/linux/devices/iio_imu.hpp"
#include "hal/linux/devices/serial.hpp"
#include "hal/platform.hpp"
#include "sim_hil/wire/iio_tree.hpp"
#include "temp_folder.hpp"

namespace sinew::hal::iio_test {
namespace {

using namespace std::chrono_literals;
using sim_hil::IioTree, sim_hil::IioTreeSpec;
using ::testing::HasSubstr;

msg::ImuSample sample(Time stamp, double k = 1) { return {stamp, {0.1 * k, -0.2 * k, 0.3 * k}, {1 * k, -2 * k, 9.81}}; }

class IioTest : public ::testing::Test {
 protected:
  IioTreeSpec tree_spec() const {
    IioTreeSpec s;
    s.root = folder.path();
    return s;
  }
  std::unique_ptr<IioTree> plug(const IioTreeSpec& s) {
    auto tree = IioTree::make(s);
    EXPECT_TRUE(tree);
    auto pipe = make_pipe((*tree)->buffer_path());
    EXPECT_TRUE(pipe) << (*tree)->buffer_path();
    (*tree)->attach(std::move(*pipe));
    return std::move(*tree);
  }
  IioSpec spec(const std::string& name = "mpu6050") const {
    IioSpec s;
    s.name = name;
    s.root = folder.path();
    return s;
  }
  std::unique_ptr<IioImu> open(const IioSpec& s) {
    IioOptions fast;
    fast.retry_first = 5ms;
    fast.retry_most = 20ms;
    fast.silent_after = 50ms;
    auto imu = IioImu::open(os, s, why, fast);
    if (!imu) {
      error = imu.error().code;
      return nullptr;
    }
    return std::move(*imu);
  }
  template <class F>
  bool wait_until(F&& holds) {
    const Time deadline = os.now() + 10s;
    while (os.now() < deadline) {
      if (holds()) return true;
      os.sleep_until(os.now() + 1ms);
    }
    return false;
  }
  std::optional<msg::ImuSample> next(Imu& imu) {
    msg::ImuSample out;
    Result<bool> got = false;
    if (!wait_until([&] { return (got = imu.read(out)) && *got; })) return {};
    return out;
  }
  void expect_near(const msg::Vec3& a, const msg::Vec3& b, double step) {
    EXPECT_NEAR(a.x, b.x, step);
    EXPECT_NEAR(a.y, b.y, step);
    EXPECT_NEAR(a.z, b.z, step);
  }

  Os& os = system_os();
  test::TempFolder folder;
  std::string why;
  Errc error{};
};

TEST_F(IioTest, AScanBecomesASampleInSiUnitsWithTheKernelsStamp) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  EXPECT_TRUE(tree->enabled());
  EXPECT_EQ(tree->file("current_timestamp_clock"), "monotonic");
  const msg::ImuSample in = sample(os.now());
  ASSERT_TRUE(tree->feed(in));
  const auto out = next(*imu);
  ASSERT_TRUE(out) << imu->trouble();
  EXPECT_EQ(out->stamp, in.stamp);
  expect_near(out->accel_mps2, in.accel_mps2, 0.0004);
  expect_near(out->gyro_radps, in.gyro_radps, 0.0006);
  imu.reset();
  EXPECT_FALSE(tree->enabled()) << "switched off with the device";
}

TEST_F(IioTest, AnyLayoutIsRead) {
  for (const char* form :
       {"le:s16/16>>0", "be:s16/16>>0", "le:s24/32>>8", "be:s32/32>>0", "le:s20/32>>4", "le:s64/64>>0"}) {
    IioTreeSpec s = tree_spec();
    s.form = form;
    auto tree = plug(s);
    auto imu = open(spec());
    ASSERT_TRUE(imu) << form << ": " << why;
    const msg::ImuSample in = sample(os.now());
    ASSERT_TRUE(tree->feed(in));
    const auto out = next(*imu);
    ASSERT_TRUE(out) << form;
    EXPECT_EQ(out->stamp, in.stamp) << form;
    expect_near(out->accel_mps2, in.accel_mps2, 0.0004);
    expect_near(out->gyro_radps, in.gyro_radps, 0.0006);
  }
}

TEST_F(IioTest, MountMatrixAndOffsetAreApplied) {
  IioTreeSpec s = tree_spec();
  s.mount_matrix = "0, 1, 0; -1, 0, 0; 0, 0, 1";
  s.offset = 100;
  auto tree = plug(s);
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  // A scan by hand: the chip feels x only, 1000 counts with the offset.
  std::vector<std::uint8_t> scan(tree->scan_bytes());
  const auto put = [&](std::size_t at, int v) {
    scan[at] = static_cast<std::uint8_t>(v >> 8), scan[at + 1] = static_cast<std::uint8_t>(v);
  };
  put(0, 900), put(2, -100), put(4, -100);
  const std::int64_t now = os.now().ns;
  for (std::size_t i = 0; i < 8; ++i) scan[16 + i] = static_cast<std::uint8_t>(now >> (8 * i));
  ASSERT_TRUE(tree->feed_raw(scan));
  const auto out = next(*imu);
  ASSERT_TRUE(out);
  expect_near(out->accel_mps2, {0, -0.598550, 0}, 1e-9);
}

TEST_F(IioTest, TwoDevicesAreJoinedByTheirStamps) {
  IioTreeSpec a = tree_spec(), g = tree_spec();
  a.name = "accel_3d", a.gyro = false;
  g.name = "gyro_3d", g.accel = false, g.number = 1;
  auto accel = plug(a), gyro = plug(g);
  auto imu = open(spec("accel_3d,gyro_3d"));
  ASSERT_TRUE(imu) << why;
  const Time t0 = os.now();
  msg::ImuSample in;
  in.gyro_radps = {1, 2, 3};
  in.stamp = t0 + 5ms;
  ASSERT_TRUE(gyro->feed(in));
  in.stamp = t0, in.accel_mps2 = {0, 0, 10};
  ASSERT_TRUE(accel->feed(in));
  in.stamp = t0 + 10ms, in.accel_mps2 = {4, 0, 10};
  ASSERT_TRUE(accel->feed(in));
  const auto out = next(*imu);
  ASSERT_TRUE(out) << imu->trouble();
  EXPECT_EQ(out->stamp, t0 + 5ms);
  expect_near(out->gyro_radps, {1, 2, 3}, 0.001);
  expect_near(out->accel_mps2, {2, 0, 10}, 0.001);
}

TEST_F(IioTest, RateAndTriggerAreWritten) {
  auto tree = plug(tree_spec());
  IioTree::make_trigger(folder.path(), 3, "hr0");
  IioSpec s = spec();
  s.rate_hz = 500;
  s.trigger = "hr0";
  s.buffer_length = 128;
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  EXPECT_EQ(tree->file("sampling_frequency"), "500");
  EXPECT_EQ(tree->file("trigger/current_trigger"), "hr0");
  EXPECT_EQ(tree->file("buffer/length"), "128");
}

TEST_F(IioTest, PolledByChoiceNeedsARateAndIsNoShortfall) {
  auto tree = plug(tree_spec());
  IioSpec s = spec();
  s.buffered = false;
  EXPECT_FALSE(open(s));
  EXPECT_EQ(why, "iio device 'mpu6050': polled (buffered = false) needs rate_hz");
  s.rate_hz = 500;
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  EXPECT_TRUE(next(*imu));
  EXPECT_EQ(imu->shortfall(), "");
  EXPECT_FALSE(tree->enabled()) << "although it has a buffer";
}

TEST_F(IioTest, WithoutABufferItIsPolledAndSaysWhy) {
  IioTreeSpec t = tree_spec();
  t.buffer = false;
  auto tree = plug(t);
  ASSERT_TRUE(tree->feed(sample(os.now())));
  const std::string reason = "iio:device0 (mpu6050): its driver has no buffer (no interrupt or trigger?)";
  EXPECT_FALSE(open(spec()));
  EXPECT_EQ(error, Errc::not_supported);
  EXPECT_EQ(why, reason + "; with rate_hz it would be polled instead");
  IioSpec s = spec();
  s.rate_hz = 500;
  s.buffered = true;
  EXPECT_FALSE(open(s));
  EXPECT_EQ(error, Errc::not_supported) << "who asks for the buffer gets nothing else";
  EXPECT_EQ(why, reason);
  s.buffered.reset();
  const Time before = os.now();
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  const auto first = next(*imu), second = next(*imu);
  ASSERT_TRUE(first && second);
  expect_near(first->accel_mps2, {1, -2, 9.81}, 0.0004);
  EXPECT_GE(first->stamp, before);
  EXPECT_GT(second->stamp, first->stamp);
  EXPECT_EQ(imu->shortfall(), "polled 500 times a second, with the stamps of reading: " + reason);
  EXPECT_EQ(imu->trouble(), "") << "it is well";
}

TEST_F(IioTest, BufferThatDoesNotStartForWantOfATriggerGivesWayToPolling) {
  auto tree = plug(tree_spec());
  // A file of the kernel's that refuses a number as the kernel does a buffer without a trigger (EINVAL).
  const std::string refuses = "/proc/self/timens_offsets", enable = tree->folder() + "/buffer/enable";
  const int fd = ::open(refuses.c_str(), O_WRONLY | O_CLOEXEC);
  const bool invalid = fd >= 0 && ::write(fd, "1", 1) < 0 && errno == EINVAL;
  if (fd >= 0) ::close(fd);
  if (!invalid) GTEST_SKIP() << refuses << " does not answer EINVAL here";
  std::filesystem::remove(enable);
  std::filesystem::create_symlink(refuses, enable);
  EXPECT_FALSE(open(spec()));
  EXPECT_EQ(error, Errc::not_supported);
  EXPECT_THAT(why, HasSubstr("the buffer needs a trigger: name one"));
  EXPECT_THAT(why, HasSubstr("; with rate_hz it would be polled instead"));
  IioSpec s = spec();
  s.rate_hz = 250;
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  EXPECT_TRUE(next(*imu));
  EXPECT_THAT(imu->shortfall(), HasSubstr("polled 250 times a second, with the stamps of reading: "));
  EXPECT_THAT(imu->shortfall(), HasSubstr("the buffer needs a trigger"));
  s.trigger = "hr0";
  IioTree::make_trigger(folder.path(), 3, "hr0");
  EXPECT_FALSE(open(s)) << "who names a trigger is not polled";
}

TEST_F(IioTest, RateThatTheDeviceCannotHaveIsAnErrorAndNoReasonToPoll) {
  auto tree = plug(tree_spec());
  tree->set_file("sampling_frequency", "");
  IioSpec s = spec();
  s.rate_hz = 250;
  EXPECT_FALSE(open(s));
  EXPECT_EQ(error, Errc::bad_argument);
  EXPECT_THAT(why, HasSubstr("has no sampling_frequency; leave rate_hz out"));
}

TEST_F(IioTest, WhoseBufferIsNotPolledSaysBothReasons) {
  IioTreeSpec t = tree_spec();
  t.buffer = false;
  auto tree = plug(t);
  std::filesystem::remove(tree->folder() + "/in_accel_y_raw");
  IioSpec s = spec();
  s.rate_hz = 250;
  EXPECT_FALSE(open(s));
  EXPECT_THAT(why, HasSubstr("its driver has no buffer (no interrupt or trigger?); nor can it be polled: "));
  EXPECT_THAT(why, HasSubstr("in_accel_y_raw"));
}

TEST_F(IioTest, PollingLeavesTheBufferToWhoHasIt) {
  auto tree = plug(tree_spec());
  tree->set_file("buffer/enable", "1");
  std::filesystem::remove(tree->buffer_path());  // as good as "busy": the node cannot be had
  IioSpec s = spec();
  s.rate_hz = 500;
  s.buffered = false;
  EXPECT_FALSE(open(s));
  EXPECT_EQ(error, Errc::not_found);
  EXPECT_TRUE(tree->enabled()) << "it was not ours to end";
}

TEST_F(IioTest, BufferThatStartsIsNeverPolled) {
  auto tree = plug(tree_spec());
  IioSpec s = spec();
  s.rate_hz = 500;
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  EXPECT_TRUE(tree->enabled());
  EXPECT_EQ(imu->shortfall(), "");
}

TEST_F(IioTest, WhoNamesATriggerIsNotPolled) {
  auto tree = plug(tree_spec());
  IioTree::make_trigger(folder.path(), 3, "hr0");
  IioSpec s = spec();
  s.rate_hz = 500;
  s.trigger = "hr1";
  EXPECT_FALSE(open(s));
  EXPECT_EQ(error, Errc::bad_argument);
  EXPECT_EQ(why, "iio trigger 'hr1': there is: hr0");
}

TEST_F(IioTest, DeviceThatMayNotBeOpenedIsNotPolledInstead) {
  auto tree = plug(tree_spec());
  std::filesystem::remove(tree->buffer_path());
  IioSpec s = spec();
  s.rate_hz = 500;
  EXPECT_FALSE(open(s));
  EXPECT_EQ(error, Errc::not_found) << "the node is missing: udev, or a container; polling would hide that";
}

TEST_F(IioTest, DeviceThatComesBackWithoutItsBufferIsWaitedFor) {
  auto tree = plug(tree_spec());
  IioSpec s = spec();
  s.rate_hz = 500;
  auto imu = open(s);
  ASSERT_TRUE(imu) << why;
  tree->unplug();
  tree.reset();
  IioTreeSpec t = tree_spec();
  t.buffer = false;
  tree = plug(t);
  EXPECT_TRUE(wait_until([&] { return imu->trouble().find("has no buffer") != std::string::npos; })) << imu->trouble();
  EXPECT_EQ(imu->shortfall(), "") << "stamps do not change their meaning in a run";
  tree.reset();
  tree = plug(tree_spec());
  ASSERT_TRUE(wait_until([&] { return imu->stats().restarts == 1 && tree->enabled(); }));
}

TEST_F(IioTest, WhoWaitsIsWoken) {
  struct Counter : Wake {
    void wake() noexcept override { ++count; }
    std::atomic<int> count{0};
  } counter;
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  imu->set_wake(&counter);
  EXPECT_EQ(imu->ready_at(), kNever);
  ASSERT_TRUE(tree->feed(sample(os.now())));
  EXPECT_TRUE(wait_until([&] { return counter.count > 0; }));
  EXPECT_LE(imu->ready_at(), os.now());
  imu->set_wake(nullptr);
}

// ---- faults, and the texts for the user

TEST_F(IioTest, AnAbsentDeviceNamesWhatIsThere) {
  EXPECT_FALSE(open(spec("bmi160")));
  EXPECT_EQ(error, Errc::not_found);
  EXPECT_EQ(why, "iio device 'bmi160': not in " + folder.path() +
                     "/sys/bus/iio/devices; there is: none (is its driver loaded, and on its bus?)");
  auto tree = plug(tree_spec());
  EXPECT_FALSE(open(spec("bmi160")));
  EXPECT_THAT(why, HasSubstr("there is: iio:device0 (mpu6050)"));
}

TEST_F(IioTest, TwoOfOneNameAreNotGuessed) {
  IioTreeSpec second = tree_spec();
  second.number = 1;
  second.label = "imu-top";
  auto a = plug(tree_spec()), b = plug(second);
  EXPECT_FALSE(open(spec()));
  EXPECT_EQ(error, Errc::bad_argument);
  EXPECT_EQ(why, "iio device 'mpu6050': iio:device0, iio:device1 have this name; write which one");
  EXPECT_TRUE(open(spec("imu-top"))) << why;
  EXPECT_TRUE(open(spec("iio:device1"))) << why;
}

TEST_F(IioTest, ADeviceThatIsNoImuSaysWhatItHas) {
  IioTreeSpec s = tree_spec();
  s.gyro = false;
  auto tree = plug(s);
  EXPECT_FALSE(open(spec()));
  EXPECT_EQ(error, Errc::bad_argument);
  EXPECT_THAT(why, HasSubstr("iio:device0 (mpu6050): has no in_anglvel_x_raw; it has: in_accel_scale, in_accel_x_raw"));
}

TEST_F(IioTest, GarbageInAFileNamesTheFile) {
  struct Case {
    const char *file, *text, *says;
  };
  for (const Case& c :
       {Case{"scan_elements/in_accel_y_type", "float", "_type: 'float' is not like \"le:s16/16>>0\""},
        Case{"scan_elements/in_accel_y_index", "0", "in_accel_y_index: missing, out of range, or twice"},
        Case{"in_anglvel_scale", "much", "in_anglvel_scale: 'much' is not a number"},
        Case{"in_anglvel_scale", "", "in_anglvel_scale is missing or 0"},
        Case{"in_accel_x_offset", "x", "in_accel_x_offset: 'x' is not a number"},
        Case{"in_mount_matrix", "1, 0", "in_mount_matrix: '1, 0' is not \"x1, y1, z1;"}}) {
    auto tree = plug(tree_spec());
    tree->set_file(c.file, c.text);
    EXPECT_FALSE(open(spec())) << c.file;
    EXPECT_EQ(error, Errc::bad_data) << c.file;
    EXPECT_THAT(why, HasSubstr(c.says));
  }
}

TEST_F(IioTest, AMissingTriggerOrRateSaysWhatThereIs) {
  auto tree = plug(tree_spec());
  IioTree::make_trigger(folder.path(), 0, "hr0");
  IioSpec s = spec();
  s.trigger = "hr7";
  EXPECT_FALSE(open(s));
  EXPECT_EQ(why, "iio trigger 'hr7': there is: hr0");
  s = spec();
  s.rate_hz = 100;
  tree->set_file("sampling_frequency", "");
  EXPECT_FALSE(open(s));
  EXPECT_THAT(why, HasSubstr("has no sampling_frequency; leave rate_hz out, or name a trigger"));
}

TEST_F(IioTest, AValueThatTheDriverRefusesComesWithWhatItTakes) {
  auto tree = plug(tree_spec());
  std::filesystem::remove(tree->folder() + "/sampling_frequency");
  std::filesystem::create_symlink("/dev/full", tree->folder() + "/sampling_frequency");  // refuses every write
  tree->set_file("sampling_frequency_available", "10 50 200");
  IioSpec s = spec();
  s.rate_hz = 123;
  EXPECT_FALSE(open(s));
  EXPECT_THAT(why, HasSubstr("sampling_frequency: cannot be set to '123': "));
  EXPECT_THAT(why, HasSubstr("; it takes: 10 50 200"));
}

TEST_F(IioTest, PermissionDeniedSaysWhoMay) {
  auto tree = plug(tree_spec());
  ::chmod(folder.path().c_str(), 0755);
  ::chmod(tree->buffer_path().c_str(), 0666);
  ::chmod((tree->folder() + "/buffer/enable").c_str(), 0400);
  const test::Unprivileged user;
  EXPECT_FALSE(open(spec()));
  EXPECT_EQ(error, Errc::denied);
  EXPECT_THAT(why, HasSubstr("/current_timestamp_clock: permission denied; "));
  EXPECT_THAT(why, HasSubstr("udev rule"));
}

TEST_F(IioTest, AnUnpluggedDeviceIsClosedAndComesBack) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  ASSERT_TRUE(tree->feed(sample(os.now())));
  ASSERT_TRUE(next(*imu));
  tree->unplug();
  msg::ImuSample out;
  ASSERT_TRUE(wait_until([&] {
    const auto got = imu->read(out);
    return !got && got.error().code == Errc::closed;
  }));
  EXPECT_TRUE(wait_until([&] { return imu->trouble().find("not in ") != std::string::npos; })) << imu->trouble();
  tree.reset();
  tree = plug(tree_spec());
  ASSERT_TRUE(wait_until([&] { return imu->stats().restarts == 1 && tree->enabled(); }));
  ASSERT_TRUE(tree->feed(sample(os.now())));
  EXPECT_TRUE(next(*imu)) << imu->trouble();
  EXPECT_EQ(imu->trouble(), "");
}

TEST_F(IioTest, ASilentDeviceIsToldAndHealsByItself) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  EXPECT_TRUE(wait_until([&] { return !imu->trouble().empty(); }));
  EXPECT_EQ(imu->trouble(), "iio device 'mpu6050': is there, but sends nothing (trigger, interrupt?)");
  msg::ImuSample out;
  const auto got = imu->read(out);
  ASSERT_TRUE(got) << "silence is not an error of read(): the guardian's silent_ms sees it";
  EXPECT_FALSE(*got);
  ASSERT_TRUE(tree->feed(sample(os.now())));
  ASSERT_TRUE(next(*imu));
  EXPECT_EQ(imu->trouble(), "");
}

TEST_F(IioTest, RepeatedAndOldStampsAreCountedNotDelivered) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  const Time t = os.now();
  for (const Duration d : {0ns, 0ns, Duration(-1ms), Duration(1ms)}) ASSERT_TRUE(tree->feed(sample(t + d)));
  ASSERT_TRUE(wait_until([&] { return imu->stats().samples == 2; }));
  EXPECT_EQ(imu->stats().bad, 2u);
}

TEST_F(IioTest, StampsOfAnotherClockAreReplacedAndTold) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  const Time before = os.now();
  ASSERT_TRUE(tree->feed(sample({1'700'000'000'000'000'000})));  // of a calendar
  const auto out = next(*imu);
  ASSERT_TRUE(out);
  EXPECT_GE(out->stamp, before);
  EXPECT_LE(out->stamp, os.now());
  EXPECT_THAT(imu->trouble(), HasSubstr("its stamps are not of the monotonic clock"));
}

TEST_F(IioTest, AScanThatComesInPiecesIsPutTogether) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  std::vector<std::uint8_t> scan(tree->scan_bytes());
  const std::int64_t now = os.now().ns;
  for (std::size_t i = 0; i < 8; ++i) scan[16 + i] = static_cast<std::uint8_t>(now >> (8 * i));
  ASSERT_TRUE(tree->feed_raw(std::span(scan).first(7)));
  os.sleep_until(os.now() + 20ms);
  ASSERT_TRUE(tree->feed_raw(std::span(scan).subspan(7)));
  const auto out = next(*imu);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->stamp.ns, now);
}

TEST_F(IioTest, WhenNobodyReadsSamplesAreLostAndCounted) {
  auto tree = plug(tree_spec());
  auto imu = open(spec());
  ASSERT_TRUE(imu) << why;
  const Time t = os.now();
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(tree->feed(sample(t + std::chrono::microseconds(i))));
  EXPECT_TRUE(wait_until([&] { return imu->stats().samples + imu->stats().lost == 200; }));
  EXPECT_EQ(imu->stats().lost, 136u) << "64 find room";
}

TEST(IioJoin, GyroSamplesWithoutAccelerometerAreDroppedAndCounted) {
  IioJoin join;
  int out = 0;
  const auto count = [&](const msg::ImuSample&) { ++out; };
  for (int i = 0; i < 40; ++i) join.add_gyro({i}, {}, count);
  EXPECT_EQ(join.dropped(), 8u);
  join.add_accel({20}, {}, count);
  join.add_accel({30}, {}, count);
  EXPECT_EQ(out, 11) << "20 to 30";
  EXPECT_EQ(join.dropped(), 20u) << "those before the first";
}

/// On a real kernel (tests/vm): SINEW_IIO=bmi160 SINEW_IIO_TRIGGER=hr0 SINEW_IIO_RATE=200.
TEST(IioKernel, TheRealDeviceDelivers) {
  const char* name = std::getenv("SINEW_IIO");
  if (!name) GTEST_SKIP() << "SINEW_IIO names no device: no real kernel to try";
  IioSpec s;
  s.name = name;
  if (const char* trigger = std::getenv("SINEW_IIO_TRIGGER")) s.trigger = trigger;
  if (const char* rate = std::getenv("SINEW_IIO_RATE")) s.rate_hz = std::atof(rate);
  if (std::getenv("SINEW_IIO_POLL")) s.buffered = false;
  std::string why;
  auto imu = IioImu::open(system_os(), s, why);
  ASSERT_TRUE(imu) << why;
  if (std::getenv("SINEW_IIO_NO_TRIGGER")) {
    EXPECT_THAT((*imu)->shortfall(), HasSubstr("the buffer needs a trigger"));
  }
  Time last{INT64_MIN};
  int count = 0;
  const Time deadline = system_os().now() + 20s;
  while (count < 50 && system_os().now() < deadline) {
    msg::ImuSample out;
    const auto got = (*imu)->read(out);
    ASSERT_TRUE(got) << (*imu)->trouble();
    if (!*got) {
      system_os().sleep_until(system_os().now() + 1ms);
      continue;
    }
    EXPECT_GT(out.stamp, last);
    EXPECT_LE(out.stamp, system_os().now());
    last = out.stamp;
    ++count;
  }
  EXPECT_EQ(count, 50) << (*imu)->trouble();
}

}  // namespace
}  // namespace sinew::hal::iio_test
