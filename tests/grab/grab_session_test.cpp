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
    ::unsetenv("DISPLAY");  // no server has titles for what are no windows
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

/// Writes a title as `sinew grab` does.
void entitle(std::uint32_t window, std::uint32_t x11, std::string_view title) {
  grab::Head* head = grab::memory();
  ASSERT_TRUE(head);
  write_grab_title(*head, window, head->window[window].process.load(), x11, title);
}

TEST_F(GrabSessionTest, ATitleMeansTheWindowThatHasItElseTheOnlyOneThatContainsIt) {
  show(1, 0), show(2, 0), show(3, 0);
  auto view = reader();
  EXPECT_EQ(view->titled("Front").count, 0u) << "no titles yet";
  entitle(0, 1, "Front camera"), entitle(1, 2, "Rear camera"), entitle(2, 3, "Rear camera 2");
  EXPECT_EQ(view->titled("Front").window, 0u);
  EXPECT_EQ(view->titled("Rear camera").window, 1u) << "exactly";
  EXPECT_EQ(view->titled("camera 2").window, 2u);
  EXPECT_EQ(view->titled("Rear").window, grab::kNoNumber) << "two of them";
  EXPECT_EQ(view->titled("Rear").count, 2u);
  EXPECT_EQ(titles_of(view->windows()), "'Front camera', 'Rear camera', 'Rear camera 2'");
  grab::forget_window(grab::Api::glx, nullptr, 1);
  show(4, 0);
  EXPECT_EQ(view->windows()[0].id, 4u);
  EXPECT_EQ(view->windows()[0].title, "") << "the next window of this number has another title";
  EXPECT_EQ(view->titled("Front").count, 0u);
}

TEST_F(GrabSessionTest, ATitleIsTextWhateverTheProgramCallsItself) {
  EXPECT_EQ(clean_title("Sicht \xC3\xBC"
                        "ber 10 \xE2\x82\xAC"),
            "Sicht \xC3\xBC"
            "ber 10 \xE2\x82\xAC");
  EXPECT_EQ(clean_title("a\nb\x1B[2J\x7F"), "a?b?[2J?");
  EXPECT_EQ(clean_title("\xC3"), "?") << "half a character";
  EXPECT_EQ(clean_title("\xFF\xC0\xAF\xED\xA0\x80"), "??????") << "no UTF-8";
  EXPECT_EQ(clean_title("\xC2\x9B"
                        "1m"),
            "?1m")
      << "a control character of two bytes";
  show(1, 0);
  entitle(0, 1, std::string(1000, 'x'));
  std::string why;
  EXPECT_EQ(grab_windows("test", why)->front().title, std::string(4 * grab::kTitleWords - 1, 'x'));
}

TEST_F(GrabSessionTest, ACameraFollowsTheTitleFromWindowToWindow) {
  std::string why;
  GrabSpec spec;
  spec.name = "test", spec.width = 32, spec.height = 24, spec.format = msg::PixelFormat::mono8, spec.rate_hz = 0;
  spec.title = "Front";
  auto camera = GrabCamera::open(spec, system_os(), why);
  ASSERT_TRUE(camera) << why;
  const auto* report = dynamic_cast<const SelfReport*>(camera->get());
  msg::ImageBuffer image(msg::PixelFormat::mono8, 32, 24);
  show(1, 11), show(2, 22);
  entitle(0, 1, "Rear");
  EXPECT_TRUE(eventually([&] {
    return report->trouble() == "grabbed program 'test': no window has 'Front' in its title; there are: 'Rear'";
  })) << report->trouble();
  EXPECT_EQ(show(1, 11) + show(2, 22), 0) << "no other window instead";
  const auto next = [&] {
    int value = -1;
    EXPECT_TRUE(eventually([&] {
      show(1, 11), show(2, 22);
      const auto read = (*camera)->read(*image);
      if (read && *read) value = image->pixels()[100];
      return value >= 0;
    }));
    return value;
  };
  entitle(1, 2, "Front");
  EXPECT_EQ(next(), 22);
  EXPECT_EQ(report->trouble(), "");
  entitle(0, 1, "Front view"), entitle(1, 2, "Rear");
  EXPECT_TRUE(eventually([&] { return next() == 11; }));
  entitle(1, 2, "Front too");
  EXPECT_TRUE(eventually([&] {
    show(1, 11), show(2, 22);
    static_cast<void>((*camera)->read(*image));
    return report->trouble().find("several windows have 'Front' in their titles: 'Front view', 'Front too'") !=
           std::string::npos;
  })) << report->trouble();
}

TEST_F(GrabSessionTest, AWindowThatIsGoneHandsItsTitleAndTheOpenRequestsToTheNext) {
  std::string why;
  GrabSpec spec;
  spec.name = "test", spec.width = 32, spec.height = 24, spec.format = msg::PixelFormat::mono8, spec.rate_hz = 0;
  spec.title = "Front";
  show(1, 11), show(2, 22);
  entitle(0, 1, "Front"), entitle(1, 2, "Rear");
  auto camera = GrabCamera::open(spec, system_os(), why);
  ASSERT_TRUE(camera) << why;
  ASSERT_TRUE(eventually([&] { return show(1, 11) > 0; })) << "the camera asks this window";
  msg::ImageBuffer image(msg::PixelFormat::mono8, 32, 24);
  ASSERT_TRUE(eventually([&] {
    const auto read = (*camera)->read(*image);
    return read && *read;
  })) << "now two requests are open";
  grab::forget_window(grab::Api::glx, nullptr, 1);
  entitle(1, 2, "Front");
  EXPECT_TRUE(eventually([&] { return show(2, 22) > 0; }));
}

TEST_F(GrabSessionTest, TheWindowBehindADrawableIsTheOneThatWasNoted) {
  grab::note_x11_window(grab::Api::glx, nullptr, 9, 0x400007);
  show(9, 0), show(10, 0);
  EXPECT_EQ(grab::memory()->window[0].x11, 0x400007u);
  EXPECT_EQ(grab::memory()->window[1].x11, 10u) << "where nothing was noted it is the drawable itself";
  grab::forget_window(grab::Api::glx, nullptr, 9);
  show(9, 0);
  EXPECT_EQ(grab::memory()->window[0].x11, 9u) << "forgotten with the drawable";
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
