#include "dataset/dataset_board.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <thread>

#include "dataset_fixture.hpp"
#include "hal/platform.hpp"
#include "hal/wake_counter.hpp"

namespace sinew::dataset::dataset_board_test {
namespace {

using namespace std::chrono_literals;
using hal::Errc;
using hal::Time;
using test::Folder;
using test::grey_png;
using test::image_name;
using test::imu_csv;
using test::kFirst;

constexpr std::int64_t kMs = 1'000'000;

/// An image message with room behind it.
class Slot {
 public:
  explicit Slot(std::uint32_t capacity = 4096) : memory_(sizeof(msg::Image) + capacity) {
    image_ = new (memory_.data()) msg::Image;
    image_->set_bulk_capacity(capacity);
  }
  msg::Image& operator*() { return *image_; }
  msg::Image* operator->() { return image_; }

 private:
  std::vector<std::uint8_t> memory_;  // operator new aligns for every ordinary type
  msg::Image* image_;
};

void write_flat(const Folder& f) {
  f.write("imu0.csv", imu_csv(9));  // 0, 5, ... 40 ms
  f.write("cam0/" + image_name(2 * kMs), grey_png(10));
  f.write("cam0/" + image_name(22 * kMs), grey_png(20));
  f.write("cam0/" + image_name(42 * kMs), grey_png(30));
  f.write("cam0/readme.txt", "not an image");
}

void write_asl(const Folder& f) {
  f.write("mav0/imu0/data.csv", imu_csv(9));
  f.write("mav0/cam0/data.csv", "#timestamp [ns],filename\n" + std::to_string(kFirst + 2 * kMs) + ",a.png\n" +
                                    std::to_string(kFirst + 22 * kMs) + ",b.png\n" + std::to_string(kFirst + 42 * kMs) +
                                    ",c.png\n");
  f.write("mav0/cam0/data/a.png", grey_png(10));
  f.write("mav0/cam0/data/b.png", grey_png(20));
  f.write("mav0/cam0/data/c.png", grey_png(30));
}

std::unique_ptr<DatasetBoard> open(const DatasetOptions& options) {
  std::string why;
  auto board = DatasetBoard::open(options, why);
  EXPECT_TRUE(board) << why;
  return board ? std::move(*board) : nullptr;
}

struct Failure {
  Errc code{};
  std::string why;
};
Failure refused(const Folder& f, DatasetOptions options = {}) {
  static hal::ManualClock clock;
  options.folder = f.path(), options.clock = &clock;
  std::string why;
  const auto board = DatasetBoard::open(options, why);
  EXPECT_FALSE(board);
  if (why.starts_with(f.path())) why.erase(0, f.path().size());
  return {board ? Errc{} : board.error().code, why};
}

/// Grants until the end; every sample as "time in us:value".
std::vector<std::string> play(DatasetBoard& board, hal::ManualClock& clock) {
  std::vector<std::string> seen;
  auto imu = board.sensor<msg::ImuSample>("imu");
  auto camera = board.camera("camera");
  Slot slot;
  Time done = clock.now();
  for (auto grant = board.next_grant(done); grant; grant = board.next_grant(done)) {
    EXPECT_GT(grant->ns, done.ns);
    clock.set(done = *grant);
    msg::ImuSample s;
    for (auto got = imu ? (*imu)->read(s) : hal::Result<bool>(false); got && *got; got = (*imu)->read(s)) {
      EXPECT_LE(s.stamp.ns, clock.now().ns);
      seen.push_back(std::to_string(s.stamp.ns / 1000) + ":" + std::to_string(int(s.gyro_radps.x)));
    }
    for (auto got = camera ? (*camera)->read(*slot) : hal::Result<bool>(false); got && *got;
         got = (*camera)->read(*slot))
      seen.push_back(std::to_string(slot->stamp.ns / 1000) + ":image " + std::to_string(slot->pixels()[700]));
  }
  EXPECT_EQ(done, board.end());
  return seen;
}

const std::vector<std::string> kAll{"0:0",     "2000:image 10", "5000:1",         "10000:2",
                                    "15000:3", "20000:4",       "22000:image 20", "25000:5",
                                    "30000:6", "35000:7",       "40000:8",        "42000:image 30"};

TEST(DatasetBoard, BothFormsPlayTheSameSamplesAtTheirStamps) {
  for (const auto write : {write_flat, write_asl}) {
    Folder f;
    write(f);
    hal::ManualClock clock;
    const auto board = open({.folder = f.path(), .clock = &clock});
    ASSERT_TRUE(board);
    EXPECT_EQ(board->imu_samples(), 9u);
    EXPECT_EQ(board->images(), 3u);
    auto seen = play(*board, clock);
    EXPECT_EQ(seen, kAll);
    EXPECT_EQ(board->end(), Time{52 * kMs});
  }
}

TEST(DatasetBoard, NothingIsReadyBeforeItsStamp) {
  Folder f;
  write_flat(f);
  hal::ManualClock clock;
  clock.set({7'000});
  const auto board = open({.folder = f.path(), .clock = &clock});
  hal::Imu& imu = **board->sensor<msg::ImuSample>("imu0");
  hal::Camera& camera = **board->camera("cam0");
  msg::ImuSample s;
  Slot slot;
  EXPECT_EQ(imu.ready_at(), Time{7'000});
  ASSERT_TRUE(*imu.read(s));
  EXPECT_EQ(imu.ready_at(), Time{7'000 + 5 * kMs});
  EXPECT_EQ(camera.ready_at(), Time{7'000 + 2 * kMs});
  EXPECT_FALSE(*imu.read(s));
  EXPECT_FALSE(*camera.read(*slot));
  clock.set({7'000 + 5 * kMs - 1});
  EXPECT_FALSE(*imu.read(s));
  ASSERT_TRUE(*camera.read(*slot));
  EXPECT_EQ(slot->format, msg::PixelFormat::mono8);
  EXPECT_EQ(slot->width, 32u);
  EXPECT_EQ(slot->frame_number, 0u);
  clock.set({1000 * kMs});
  while (imu.read(s) && *imu.read(s)) {
  }
  EXPECT_EQ(imu.ready_at(), hal::kNever);
  EXPECT_EQ(imu.read(s).error().code, Errc::closed);
}

TEST(DatasetBoard, BeginsInMidFlightWhenAskedTo) {
  Folder f;
  write_flat(f);
  hal::ManualClock clock;
  const auto board = open({.folder = f.path(), .from = 20ms, .clock = &clock});
  const std::vector<std::string> expected{"0:4",     "2000:image 20", "5000:5",        "10000:6",
                                          "15000:7", "20000:8",       "22000:image 30"};
  EXPECT_EQ(play(*board, clock), expected);
  EXPECT_EQ(board->dataset_stamp({5 * kMs}), kFirst + 25 * kMs);
  EXPECT_EQ(refused(f, {.folder = {}, .from = 43ms}).code, Errc::bad_argument);
  EXPECT_EQ(refused(f, {.folder = {}, .from = -1ms}).code, Errc::bad_argument);
}

TEST(DatasetBoard, EitherPartMayBeMissingButNotBoth) {
  Folder no_images, no_imu, nothing;
  no_images.write("imu0.csv", imu_csv(3));
  no_imu.write("cam0/" + image_name(0), grey_png(1));
  hal::ManualClock clock;
  const auto a = open({.folder = no_images.path(), .clock = &clock});
  EXPECT_TRUE(a->sensor<msg::ImuSample>("imu"));
  EXPECT_EQ(a->camera("camera").error().code, Errc::not_found);
  EXPECT_EQ(a->radio("radio").error().code, Errc::not_found);
  EXPECT_EQ(play(*a, clock).size(), 3u);
  const auto b = open({.folder = no_imu.path(), .clock = &clock});
  EXPECT_EQ(b->sensor<msg::ImuSample>("imu").error().code, Errc::not_found);
  EXPECT_TRUE(b->camera("camera"));
  EXPECT_EQ(b->sensor<msg::RangeSample>("range").error().code, Errc::not_found);
  EXPECT_EQ(b->sensor<msg::BaroSample>("baro").error().code, Errc::not_found);
  EXPECT_EQ(b->actuators("motors").error().code, Errc::not_found);
  const Failure none = refused(nothing);
  EXPECT_EQ(none.code, Errc::not_found);
  EXPECT_EQ(none.why,
            ": neither IMU samples (" + nothing.path() + "/imu0.csv) nor images (" + nothing.path() + "/cam0/)");
  std::string why;
  EXPECT_EQ(DatasetBoard::open({.folder = "/nowhere", .clock = &clock}, why).error().code, Errc::not_found);
  EXPECT_EQ(why, "/nowhere: no such folder");
}

TEST(DatasetBoard, BadFilesAreNamedWithTheirLine) {
  Folder text, stamps, name, cut, missing, twice;
  text.write("imu0.csv", imu_csv(3) + "oops,0,0,0,0,0,0\n");
  EXPECT_EQ(refused(text).why, "/imu0.csv:5: column 1: 'oops' is not a time stamp in nanoseconds");
  EXPECT_EQ(refused(text).code, Errc::bad_data);
  stamps.write("mav0/imu0/data.csv", imu_csv(3) + imu_csv(1));
  EXPECT_EQ(refused(stamps).why.substr(0, 48), "/mav0/imu0/data.csv:6: column 1: stamp 140000000");
  name.write("cam0/first.png", grey_png(1));
  EXPECT_EQ(refused(name).why, "/cam0/first.png: the name of an image must be its stamp in nanoseconds");
  auto png = grey_png(1);
  png.erase(png.end() - 20, png.end());
  cut.write("cam0/" + image_name(0), png);
  EXPECT_EQ(refused(cut).why, "/cam0/" + image_name(0) + ": the file is cut off");
  missing.write("mav0/cam0/data.csv", "5,five.png\n");
  EXPECT_EQ(refused(missing).why, "/mav0/cam0/data/five.png: no such file");
  twice.write("cam0/7.png", grey_png(1));
  twice.write("cam0/07.png", grey_png(1));
  EXPECT_NE(refused(twice).why.find("the stamp of"), std::string::npos);
}

TEST(DatasetBoard, ImagesBeyondTheMemoryAreDecodedWhenReadInVirtualTimeAndRefusedInRealTime) {
  Folder f;
  write_flat(f);
  hal::ManualClock clock;
  const auto board = open({.folder = f.path(), .clock = &clock, .max_decoded_bytes = 1000});
  EXPECT_EQ(play(*board, clock), kAll);
  hal::Os& os = hal::system_os();
  const Failure real = refused(f, {.folder = {}, .os = &os, .max_decoded_bytes = 1000});
  EXPECT_EQ(real.code, Errc::not_supported);
  EXPECT_NE(real.why.find("3 images need more than 0 MiB decoded"), std::string::npos) << real.why;
}

TEST(DatasetBoard, AnImageThatCannotBeHandedOverIsCountedAndTheNextOneComes) {
  Folder f;
  f.write("cam0/" + image_name(0), grey_png(1));
  f.write("cam0/" + image_name(10 * kMs), std::string("no image at all"));
  f.write("cam0/" + image_name(20 * kMs), grey_png(3, 200, 100));
  f.write("cam0/" + image_name(30 * kMs), grey_png(4));
  hal::ManualClock clock;
  const auto board = open({.folder = f.path(), .clock = &clock, .max_decoded_bytes = 100});
  clock.set({100 * kMs});
  hal::Camera& camera = **board->camera("camera");
  Slot slot(32 * 24);
  EXPECT_TRUE(*camera.read(*slot));
  EXPECT_EQ(camera.read(*slot).error().code, Errc::bad_data);
  EXPECT_NE(board->image_problem().find("not a PNG file"), std::string::npos);
  EXPECT_EQ(camera.read(*slot).error().code, Errc::bad_argument);
  ASSERT_TRUE(*camera.read(*slot));
  EXPECT_EQ(slot->frame_number, 3u);
  EXPECT_EQ(slot->pixels()[0], 4);
  EXPECT_EQ(board->images_lost(), 2u);
}

TEST(DatasetBoard, InRealTimeSleepersAreWokenForEverySample) {
  Folder f;
  write_flat(f);
  hal::Os& os = hal::system_os();
  const auto board = open({.folder = f.path(), .clock = &os, .os = &os});
  hal::WakeCounter imu, camera;
  (*board->sensor<msg::ImuSample>("imu"))->set_wake(&imu);
  (*board->camera("camera"))->set_wake(&camera);
  EXPECT_EQ((*board->sensor<msg::ImuSample>("imu"))->ready_at(), hal::kNever);  // the record has not begun
  msg::ImuSample s;
  EXPECT_FALSE(*(*board->sensor<msg::ImuSample>("imu"))->read(s));
  ASSERT_TRUE(board->start());
  EXPECT_TRUE(imu.wait_for(9));
  EXPECT_TRUE(camera.wait_for(3));
  EXPECT_EQ(imu.count(), 9u);
  EXPECT_EQ(camera.count(), 3u);
  int samples = 0;
  for (auto got = (*board->sensor<msg::ImuSample>("imu"))->read(s); got && *got;
       got = (*board->sensor<msg::ImuSample>("imu"))->read(s))
    ++samples;
  EXPECT_EQ(samples, 9);
}

TEST(DatasetBoard, WhoIsTakenAwayWhileItIsWokenIsLetGoOfFirst) {
  class Slow final : public hal::Wake {
   public:
    void wake() noexcept override {
      entered = true;
      while (!go) std::this_thread::yield();
      left = true;
    }
    std::atomic<bool> entered{false}, go{false}, left{false};
  };
  Folder f;
  write_flat(f);
  hal::Os& os = hal::system_os();
  Slow slow;
  const auto board = open({.folder = f.path(), .clock = &os, .os = &os});
  hal::Imu& imu = **board->sensor<msg::ImuSample>("imu");
  imu.set_wake(&slow);
  ASSERT_TRUE(board->start());
  while (!slow.entered) std::this_thread::yield();
  std::jthread later([&] {
    std::this_thread::sleep_for(20ms);
    slow.go = true;
  });
  imu.set_wake(nullptr);
  EXPECT_TRUE(slow.left) << "its owner may be freed now";
}

/// The recording of a real vehicle, when SINEW_DATA names its folder.
TEST(DatasetBoard, PlaysTheRealRecording) {
  const char* folder = std::getenv("SINEW_DATA");
  if (folder == nullptr || !std::filesystem::is_directory(folder))
    GTEST_SKIP() << "SINEW_DATA does not name a folder in the EuRoC form";
  hal::ManualClock clock;
  const auto board = open({.folder = folder, .clock = &clock});
  ASSERT_TRUE(board);
  EXPECT_GT(board->imu_samples(), 200u);
  Time done{-1};
  std::size_t samples = 0;
  hal::Imu& imu = **board->sensor<msg::ImuSample>("imu");
  for (auto grant = board->next_grant(done); grant; grant = board->next_grant(done)) {
    clock.set(done = *grant);
    msg::ImuSample s;
    for (auto got = imu.read(s); got && *got; got = imu.read(s)) ++samples;
  }
  EXPECT_EQ(samples, board->imu_samples());
}

}  // namespace
}  // namespace sinew::dataset::dataset_board_test
