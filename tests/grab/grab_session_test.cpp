// A session, readers, and this process as the program: grab/preload/program_side.hpp without any graphics.
#include "hal/linux/grab/grab_session.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

#include "grab/preload/program_side.hpp"
#include "hal/linux/grab/grab_camera.hpp"
#include "hal/linux/grab/grab_view.hpp"
#include "hal/platform.hpp"
#include "msg/image_buffer.hpp"

namespace sinew::hal::grab_session_test {
namespace {

using namespace std::chrono_literals;

/// One for all tests: a process connects once.
class World : public ::testing::Environment {
 public:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "grab-XXXXXX").string();
    ASSERT_NE(::mkdtemp(folder_.data()), nullptr) << folder_;
    ::setenv("SINEW_RUN_DIR", folder_.c_str(), 1);
    std::string why;
    auto opened = GrabSession::open("test", why);
    ASSERT_TRUE(opened) << why;
    session_ = std::move(*opened);
    ::setenv(grab::kSocketVariable, session_->path().c_str(), 1);
    thread_ = std::thread([this] {
      while (!stop_.load()) {
        static_cast<void>(session_->serve(5ms));
        readers_.store(session_->readers());
      }
    });
  }
  void TearDown() override {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
    session_.reset();
    std::filesystem::remove_all(folder_);
  }
  std::size_t readers() const { return readers_.load(); }

 private:
  std::string folder_;
  std::unique_ptr<GrabSession> session_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<std::size_t> readers_{0};
};

World* const world = static_cast<World*>(::testing::AddGlobalTestEnvironment(new World));

bool eventually(const std::function<bool()>& holds) {
  const Time end = system_os().now() + 10s;
  while (!holds()) {
    if (system_os().now() > end) return false;
    system_os().sleep_until(system_os().now() + 1ms);
  }
  return true;
}

/// The program shows a picture of a window whose pixels all have this value. How many were asked for.
int show(std::uint64_t window, std::uint8_t value, grab::Size size = {64, 48}) {
  grab::Head* head = grab::memory();
  if (!head) return -1;
  grab::Shown shown;
  if (!grab::count_picture(*head, grab::Api::glx, nullptr, window, shown)) return -1;
  if (grab::wants_size(*head, shown)) grab::tell_size(*head, shown, size);
  const std::int64_t now = grab::now_ns();
  if (!grab::is_asked(*head, shown, now)) return 0;
  grab::tell_size(*head, shown, size);
  int jobs = 0;
  grab::Job job;
  while (grab::take_job(*head, shown, now, size, job)) {
    std::memset(job.pixels, value, std::size_t{job.answer.stride} * job.answer.height);
    grab::finish(*head, job, grab::PixelOrder::bgrx, false);
    ++jobs;
  }
  return jobs;
}

std::unique_ptr<GrabView> reader() {
  std::string why;
  auto view = GrabView::open("test", why);
  EXPECT_TRUE(view) << why;
  return view ? std::move(*view) : nullptr;
}

class GrabSessionTest : public ::testing::Test {
 protected:
  void TearDown() override {
    for (std::uint64_t w = 1; w <= 20; ++w) grab::forget_window(grab::Api::glx, nullptr, w);
    EXPECT_TRUE(eventually([] { return world->readers() == 0; }));
  }
};

TEST_F(GrabSessionTest, NothingIsReadWhileNobodyAsks) {
  EXPECT_EQ(show(1, 1), 0);
  auto view = reader();
  EXPECT_EQ(show(1, 2), 0);
  view->ask(GrabView::kAnyWindow, {}, {});
  EXPECT_EQ(show(1, 3), 1);
  EXPECT_EQ(show(1, 4), 0);
  const auto picture = view->oldest();
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->pixels[0], 3);
  EXPECT_EQ(picture->swap, 3u);
}

TEST_F(GrabSessionTest, AtMostTwoAreAskedForAndAPictureIsAnsweredOnce) {
  auto view = reader();
  EXPECT_TRUE(view->ask(GrabView::kAnyWindow, {}, {}));
  EXPECT_TRUE(view->ask(GrabView::kAnyWindow, {}, {}));
  EXPECT_FALSE(view->ask(GrabView::kAnyWindow, {}, {}));
  EXPECT_EQ(show(1, 1), 1);  // one picture is no answer to both
  EXPECT_EQ(show(1, 2), 1);
  EXPECT_EQ(show(1, 3), 0);
  EXPECT_EQ(view->oldest()->pixels[0], 1);
  view->take();
  EXPECT_EQ(view->oldest()->pixels[0], 2);
}

TEST_F(GrabSessionTest, ARequestWaitsForItsTime) {
  auto view = reader();
  view->ask(GrabView::kAnyWindow, {}, system_os().now() + 1h);
  EXPECT_EQ(show(1, 1), 0);
}

TEST_F(GrabSessionTest, APartIsThePartThatIsInsideOfTheWindow) {
  auto view = reader();
  view->ask(GrabView::kAnyWindow, {-10, 40, 30, 30}, {});
  EXPECT_EQ(show(1, 1, {64, 48}), 1);
  const auto picture = view->oldest();
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->x, 0);
  EXPECT_EQ(picture->y, 40);
  EXPECT_EQ(picture->width, 20u);
  EXPECT_EQ(picture->height, 8u);
  EXPECT_EQ(picture->window_width, 64u);
}

TEST_F(GrabSessionTest, ARegionOutsideOfTheWindowIsAnsweredWithTheReason) {
  auto view = reader();
  view->ask(GrabView::kAnyWindow, {100, 0, 10, 10}, {});
  EXPECT_EQ(show(1, 1, {64, 48}), 0);
  ASSERT_TRUE(view->oldest());
  EXPECT_EQ(view->oldest()->status, grab::AnswerStatus::outside);
}

TEST_F(GrabSessionTest, APictureThatIsTooLargeIsAnsweredWithTheReason) {
  auto view = reader();
  view->ask(GrabView::kAnyWindow, {}, {});
  EXPECT_EQ(show(1, 1, {8192, 8192}), 0);
  EXPECT_EQ(view->oldest()->status, grab::AnswerStatus::too_large);
}

TEST_F(GrabSessionTest, EachViewGetsItsOwnWindowAndAnyWindowStaysTheSame) {
  show(1, 0), show(2, 0);
  auto first = reader(), second = reader(), any = reader();
  first->ask(0, {}, {}), second->ask(1, {}, {}), any->ask(GrabView::kAnyWindow, {}, {});
  EXPECT_EQ(show(2, 22), 2);
  EXPECT_EQ(show(1, 11), 1);
  EXPECT_EQ(first->oldest()->pixels[0], 11);
  EXPECT_EQ(second->oldest()->pixels[0], 22);
  EXPECT_EQ(any->oldest()->window, 1u);
  any->take();
  any->ask(GrabView::kAnyWindow, {}, {});
  EXPECT_EQ(show(1, 12), 0);
  EXPECT_EQ(show(2, 23), 1);
  any->take();
  any->ask(GrabView::kAnyWindow, {}, {});
  grab::forget_window(grab::Api::glx, nullptr, 2);
  EXPECT_EQ(show(1, 13), 1);
}

TEST_F(GrabSessionTest, AReaderThatEndsGivesItsViewBackAndTheNextSeesNothingOfIt) {
  for (int i = 0; i < 40; ++i) {  // more than there are views
    auto view = reader();
    ASSERT_TRUE(view);
    EXPECT_FALSE(view->oldest());
    view->ask(GrabView::kAnyWindow, {}, {});
    EXPECT_EQ(show(1, 5), 1);
    view.reset();
    ASSERT_TRUE(eventually([] { return world->readers() == 0; }));
  }
}

TEST_F(GrabSessionTest, OneReaderTooManyIsTold) {
  std::vector<std::unique_ptr<GrabView>> all;
  for (std::uint32_t i = 0; i < grab::kMaxViews; ++i) all.push_back(reader());
  std::string why;
  const auto more = GrabView::open("test", why);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, Errc::busy);
  EXPECT_NE(why.find("16 readers"), std::string::npos) << why;
}

TEST_F(GrabSessionTest, WindowsAreListedWithProgramAndSize) {
  show(7, 1, {320, 200});
  std::string why;
  const auto windows = grab_windows("test", why);
  ASSERT_TRUE(windows) << why;
  ASSERT_EQ(windows->size(), 1u);
  EXPECT_EQ(windows->front().width, 320u);
  EXPECT_EQ(windows->front().id, 7u);
  EXPECT_EQ(windows->front().pid, static_cast<std::uint32_t>(process_id()));
  EXPECT_EQ(grab_sessions(), std::vector<std::string>{"test"});
}

TEST_F(GrabSessionTest, AnotherSessionOfTheSameNameIsRefused) {
  std::string why;
  const auto second = GrabSession::open("test", why);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Errc::busy);
  EXPECT_NE(why.find("--name"), std::string::npos) << why;
  EXPECT_FALSE(GrabSession::open("../x", why));
}

TEST_F(GrabSessionTest, ACameraHasThePicturesOfTheProgramInItsOwnSize) {
  std::string why;
  GrabSpec spec;
  spec.name = "test", spec.width = 32, spec.height = 24, spec.format = msg::PixelFormat::mono8, spec.rate_hz = 0;
  auto camera = GrabCamera::open(spec, system_os(), why);
  ASSERT_TRUE(camera) << why;
  msg::ImageBuffer image(msg::PixelFormat::mono8, 32, 24);
  std::uint8_t value = 0;
  Time before{}, after{};
  std::uint32_t got = 0;
  ASSERT_TRUE(eventually([&] {
    before = system_os().now();
    if (show(1, ++value) <= 0) return false;
    after = system_os().now();
    if (!eventually([&] {
          const auto read = (*camera)->read(*image);
          return read && *read;
        }))
      return false;
    EXPECT_EQ(image->pixels()[100], value);
    EXPECT_GE(image->stamp, before);
    EXPECT_LE(image->stamp, after);
    EXPECT_EQ(image->frame_number, got);
    return ++got == 5;
  }));
}

TEST_F(GrabSessionTest, ACameraOfNoProgramOpensAndSaysWhatIsMissing) {
  std::string why;
  GrabSpec spec;
  spec.name = "absent";
  auto camera = GrabCamera::open(spec, system_os(), why);
  ASSERT_TRUE(camera);
  const auto* report = dynamic_cast<const SelfReport*>(camera->get());
  EXPECT_TRUE(eventually([&] { return report->trouble().find("sinew grab --name absent") != std::string::npos; }));
  msg::ImageBuffer image(msg::PixelFormat::yuyv, 640, 480);
  EXPECT_FALSE((*camera)->read(*image));
}

}  // namespace
}  // namespace sinew::hal::grab_session_test
