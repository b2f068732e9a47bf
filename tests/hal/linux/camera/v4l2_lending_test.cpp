// V4l2Camera fills memory that its reader lends it: hal/camera_memory.hpp, on a simulated device.
#include <linux/videodev2.h>

#include <algorithm>

#include "../rt/counting_new.hpp"
#include "v4l2_fixture.hpp"

namespace sinew::hal::v4l2_lending_test {
namespace {

using ::testing::HasSubstr;

class V4l2Lending : public V4l2Test {
 protected:
  static constexpr std::size_t kImages = 7;
  V4l2Lending() {
    for (std::size_t i = 0; i < kImages; ++i) {
      images_.emplace_back(kRoom);
      free_.push_back(&*images_.back());
    }
  }
  ~V4l2Lending() override { end(); }
  /// On another simulated camera than the default one.
  std::optional<Errc> open_on(V4l2Sim& sim) {
    camera_.reset();
    auto opened = V4l2Camera::open(sim, spec_, system_os(), watch_, options_, why_);
    if (!opened) return opened.error().code;
    camera_ = std::move(*opened);
    return std::nullopt;
  }
  std::optional<Errc> begin(std::uint32_t room = kRoom) {
    const auto begun = camera_->begin_lending(room, why_);
    if (!begun) return begun.error().code;
    EXPECT_EQ(*begun, spec_.buffers);
    return std::nullopt;
  }
  /// Acts as a reader in each cycle: takes a filled image, then lends the images that the camera lacks. Null: none
  /// filled.
  msg::Image* cycle() {
    const auto got = camera_->take_filled();
    msg::Image* image = got ? *got : nullptr;
    if (image) --lent_;
    while (lent_ < spec_.buffers && !free_.empty() && camera_->lend(*free_.front())) {
      free_.erase(free_.begin());
      ++lent_;
    }
    return image;
  }
  void give_up(msg::Image* image) { free_.push_back(image); }
  bool streams() {
    return eventually([&] {
      if (msg::Image* image = cycle()) give_up(image);
      return sim_.streams() && sim_.queued() == spec_.buffers && is_open();
    });
  }
  /// The camera's own thread has its hands off the stream.
  bool is_open() const { return camera_->state().find("): streaming ") != std::string::npos; }
  bool start() { return open() == std::nullopt && begin() == std::nullopt && streams(); }
  std::size_t take_all_back() {
    std::size_t n = 0;
    while (msg::Image* image = camera_->take_back()) give_up(image), --lent_, ++n;
    return n;
  }
  void end() {
    if (!camera_) return;
    camera_->stop_lending();
    take_all_back();
    EXPECT_EQ(lent_, 0u) << "an image was lost";
  }
  void TearDown() override {
    end();
    V4l2Test::TearDown();
  }
  static bool holds(const msg::Image& image, const msg::ImageBuffer& expected) {
    return image.bulk_used() == expected->bulk_used() &&
           std::equal(expected->pixels(), expected->pixels() + expected->bulk_used(), image.pixels());
  }

  static constexpr std::uint32_t kRoom = 320 * 240 * 3;
  std::vector<msg::ImageBuffer> images_;
  std::vector<msg::Image*> free_;
  std::size_t lent_ = 0;
};

TEST_F(V4l2Lending, PicturesLieWhereTheDriverPutThem) {
  ASSERT_TRUE(start()) << why_ << camera_->state();
  for (std::uint32_t n = 0; n < 100; ++n) {
    ASSERT_TRUE(deliver(n));
    msg::Image* image = cycle();
    ASSERT_NE(image, nullptr) << n;
    ASSERT_EQ(image->pixels(), sim_.filled());
    ASSERT_TRUE(holds(*image, picture(n)));
    ASSERT_EQ(image->frame_number, n);
    ASSERT_EQ(image->stamp, stamp(n));
    ASSERT_EQ(image->width, 320u);
    ASSERT_EQ(image->stride, 640u);
    ASSERT_EQ(sim_.queued(), spec_.buffers);
    give_up(image);
  }
  EXPECT_EQ(camera_->stats().frames, 100u);
  EXPECT_EQ(camera_->stats().lost, 0u);
  EXPECT_THAT(camera_->state(), HasSubstr("; the driver fills the topic's slots"));
}

TEST_F(V4l2Lending, CameraThatIsWellComplainsOfNothing) {
  ASSERT_TRUE(start()) << why_ << camera_->state();
  const Time until = system_os().now() + 1500ms;
  for (std::uint32_t n = 0; system_os().now() < until; ++n) {
    ASSERT_TRUE(deliver(n));
    if (msg::Image* image = cycle()) give_up(image);
    ASSERT_EQ(camera_->trouble(), "");
    system_os().sleep_until(system_os().now() + 20ms);
  }
}

TEST_F(V4l2Lending, WhoWaitsIsWokenForMemoryAndForFrames) {
  ASSERT_EQ(open(), std::nullopt);
  ASSERT_EQ(begin(), std::nullopt) << why_;
  WakeCounter wakes;
  camera_->set_wake(&wakes);
  EXPECT_TRUE(eventually([&] { return wakes.count() > 0; })) << "it has nothing to fill yet";
  EXPECT_THAT(camera_->state(), HasSubstr("waits for memory to fill"));
  ASSERT_TRUE(streams());
  EXPECT_EQ(cycle(), nullptr);
  EXPECT_EQ(camera_->ready_at(), kNever);
  const auto before = wakes.count();
  ASSERT_TRUE(deliver(0));
  EXPECT_TRUE(eventually([&] { return wakes.count() > before; }));
  msg::Image* image = cycle();
  ASSERT_NE(image, nullptr);
  give_up(image);
  camera_->set_wake(nullptr);
}

TEST_F(V4l2Lending, NoImageIsHandedOutWhileItIsLent) {
  ASSERT_TRUE(start());
  std::vector<msg::Image*> kept;
  for (std::uint32_t n = 0; n < kImages; ++n) {
    ASSERT_EQ(deliver(n), true);
    kept.push_back(cycle());
    ASSERT_NE(kept.back(), nullptr);
  }
  EXPECT_FALSE(deliver(99)) << "all are with the reader";
  std::sort(kept.begin(), kept.end());
  EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
  for (msg::Image* image : kept) give_up(image);
  ASSERT_TRUE(streams());
  ASSERT_TRUE(deliver(100));
  msg::Image* image = cycle();
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->frame_number, kImages + 1) << "the one that met no image is missing";
  EXPECT_EQ(camera_->stats().lost, 1u);
  give_up(image);
}

TEST_F(V4l2Lending, FaultyPicturesGoBackToTheDriverAndNotToTheReader) {
  ASSERT_TRUE(start());
  sim_.set_fault(V4l2Fault::corrupt);
  ASSERT_TRUE(deliver(0));
  const auto got = camera_->take_filled();
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::bad_data);
  EXPECT_EQ(camera_->stats().corrupted, 1u);
  EXPECT_EQ(sim_.queued(), spec_.buffers);
  sim_.set_fault(V4l2Fault::stuck);
  ASSERT_TRUE(deliver(1));
  EXPECT_FALSE(camera_->take_filled());
  EXPECT_EQ(camera_->stats().repeated, 1u);
  EXPECT_EQ(sim_.queued(), spec_.buffers);
}

TEST_F(V4l2Lending, CameraThatComesBackGoesOnWithWhatItWasLent) {
  ASSERT_TRUE(start());
  for (std::uint32_t round = 1; round <= 10; ++round) {
    ASSERT_TRUE(deliver(round));
    msg::Image* image = cycle();
    ASSERT_NE(image, nullptr);
    ASSERT_TRUE(holds(*image, picture(round)));
    give_up(image);
    ASSERT_TRUE(deliver(round + 100)) << "is filled and lost with the device";
    sim_.unplug();
    const auto got = camera_->take_filled();
    ASSERT_FALSE(got);
    EXPECT_EQ(got.error().code, Errc::closed);
    sim_.plug_in();
    ASSERT_TRUE(streams()) << camera_->state();
    EXPECT_EQ(lent_, spec_.buffers) << "the same images, none is missing";
    EXPECT_EQ(cycle(), nullptr) << "and none of them is a picture";
    EXPECT_EQ(camera_->stats().reopens, round);
  }
}

TEST_F(V4l2Lending, DriverThatFailsIsOpenedAgainAndFillsThemAgain) {
  ASSERT_TRUE(start());
  sim_.set_fault(V4l2Fault::io_error);
  EXPECT_FALSE(camera_->take_filled());
  ASSERT_TRUE(eventually([&] { return camera_->stats().reopens == 1; }));
  ASSERT_TRUE(streams());
  ASSERT_TRUE(deliver(3));
  msg::Image* image = cycle();
  ASSERT_NE(image, nullptr);
  give_up(image);
}

TEST_F(V4l2Lending, AskedForThemAllComeBackAfterTheStreamHasEndedAndItBeginsAnew) {
  ASSERT_TRUE(start());
  for (std::uint32_t round = 0; round < 5; ++round) {
    ASSERT_TRUE(deliver(round));
    std::size_t back = 0;
    ASSERT_TRUE(eventually([&] { return (back += take_all_back()) == spec_.buffers; }));
    EXPECT_FALSE(sim_.streams());
    EXPECT_EQ(sim_.queued(), 0u);
    EXPECT_EQ(camera_->take_back(), nullptr);
    ASSERT_TRUE(streams());
  }
}

TEST_F(V4l2Lending, StoppedWhileTheDeviceIsGoneTheyComeBackToo) {
  ASSERT_TRUE(start());
  sim_.unplug();
  EXPECT_FALSE(camera_->take_filled());
  camera_->stop_lending();
  EXPECT_EQ(take_all_back(), spec_.buffers);
}

TEST_F(V4l2Lending, MoreThanItWorksOnAndTooSmallOnesAreRefused) {
  ASSERT_TRUE(start());
  EXPECT_EQ(camera_->lend(*free_.front()).error().code, Errc::bad_argument);
  msg::ImageBuffer small(16);
  ASSERT_TRUE(deliver(0));
  const auto got = camera_->take_filled();
  ASSERT_TRUE(got && *got);
  --lent_;
  EXPECT_EQ(camera_->lend(*small).error().code, Errc::bad_argument);
  give_up(*got);
}

/// Each reason not to lend, in words; the camera then is read as ever.
struct Refusal {
  const char* name;
  const char* why;
  void (*change)(V4l2SimCamera& camera, CameraSpec& spec, std::uint32_t& room);
};
class V4l2LendingRefused : public V4l2Lending, public ::testing::WithParamInterface<Refusal> {};
class V4l2LendingDemanded : public V4l2LendingRefused {};

TEST_P(V4l2LendingRefused, SaysWhyAndIsReadWithOnePass) {
  V4l2SimCamera pretends;
  std::uint32_t room = kRoom;
  GetParam().change(pretends, spec_, room);
  V4l2Sim other(pretends);
  ASSERT_EQ(open_on(other), std::nullopt) << why_;
  EXPECT_EQ(begin(room), Errc::not_supported);
  EXPECT_THAT(why_, HasSubstr(GetParam().why));
  EXPECT_THAT(camera_->path_of_pixels(), HasSubstr(std::string("pixels are copied once: ") + GetParam().why));
  EXPECT_EQ(camera_->lend(*free_.front()).error().code, Errc::not_supported);
  EXPECT_EQ(camera_->take_filled().error().code, Errc::not_supported);
  ASSERT_TRUE(other.deliver(*picture(1), stamp(1)));
  ASSERT_TRUE(read());
  EXPECT_TRUE(same_pixels(1));
  camera_.reset();
  EXPECT_EQ(other.mapped(), 0u);
}

TEST_P(V4l2LendingDemanded, IsAnErrorWithTheReason) {
  V4l2SimCamera pretends;
  std::uint32_t room = kRoom;
  GetParam().change(pretends, spec_, room);
  spec_.memory = CameraSpec::Memory::lent;
  V4l2Sim other(pretends);
  ASSERT_EQ(open_on(other), std::nullopt) << why_;
  EXPECT_EQ(begin(room), Errc::bad_argument);
  EXPECT_THAT(why_, HasSubstr(std::string("/dev/video0 ('Simulated Camera'): ") + GetParam().why));
  EXPECT_THAT(why_, HasSubstr("; memory = \"userptr\" cannot be had"));
  camera_.reset();
}

const Refusal kByKey{"Key", "memory = \"mmap\"",
                     [](V4l2SimCamera&, CameraSpec& s, std::uint32_t&) { s.memory = CameraSpec::Memory::mapped; }};
const Refusal kByTheDevice[] = {
    {"Driver", "the driver does not take memory of the caller (VIDIOC_REQBUFS: Invalid argument)",
     [](V4l2SimCamera& c, CameraSpec&, std::uint32_t&) { c.user_pointers = false; }},
    {"Alignment", "the driver does not take memory of the caller (VIDIOC_QBUF: Invalid argument)",
     [](V4l2SimCamera& c, CameraSpec&, std::uint32_t&) { c.pointer_alignment = 4096; }},
    {"Rows", "the driver's rows are 704 bytes long, an image's 640",
     [](V4l2SimCamera& c, CameraSpec&, std::uint32_t&) { c.padding_bytes = 64; }},
    {"Room", "the driver wants 153600 bytes for a picture, the topic's images have 153599",
     [](V4l2SimCamera&, CameraSpec&, std::uint32_t& room) { room = 320 * 240 * 2 - 1; }},
    {"Buffers", "the driver works on 6 buffers at least: buffers = 6",
     [](V4l2SimCamera& c, CameraSpec&, std::uint32_t&) { c.fewest_buffers = 6; }}};
std::string name_of(const ::testing::TestParamInfo<Refusal>& refusal) { return refusal.param.name; }

INSTANTIATE_TEST_SUITE_P(Key, V4l2LendingRefused, ::testing::Values(kByKey), name_of);
INSTANTIATE_TEST_SUITE_P(Device, V4l2LendingRefused, ::testing::ValuesIn(kByTheDevice), name_of);
INSTANTIATE_TEST_SUITE_P(Device, V4l2LendingDemanded, ::testing::ValuesIn(kByTheDevice), name_of);

TEST_F(V4l2Lending, DriverThatRefusesTheMemoryItselfIsReadFromThenOn) {
  ASSERT_EQ(open(), std::nullopt);
  ASSERT_EQ(begin(), std::nullopt);
  sim_.refuse(VIDIOC_QBUF, EFAULT);
  const Status lent = camera_->lend(*free_.front());
  ASSERT_FALSE(lent);
  EXPECT_EQ(lent.error().code, Errc::not_supported);
  sim_.refuse(VIDIOC_QBUF, 0);
  ASSERT_TRUE(eventually([&] { return sim_.mapped() == spec_.buffers && sim_.streams(); }));
  ASSERT_TRUE(deliver(1));
  EXPECT_TRUE(eventually([&] { return read(); }));
  EXPECT_THAT(camera_->state(),
              HasSubstr("pixels are copied once: the driver refuses the topic's memory (Bad address)"));
}

/// Passes everything on, and counts what the simulated driver itself allocated meanwhile.
class CountingPort final : public V4l2Port {
 public:
  explicit CountingPort(V4l2Port& port) : port_(port) {}
  std::vector<std::string> nodes() override { return port_.nodes(); }
  std::vector<std::string> links(const std::string& folder) override { return port_.links(folder); }
  int open(const std::string& path) override { return port_.open(path); }
  void close(int fd) noexcept override { port_.close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) noexcept override {
    const std::uint64_t before = test::allocations();
    const int said = port_.ioctl(fd, request, argument);
    inside_ += static_cast<std::size_t>(test::allocations() - before);
    return said;
  }
  void* map(int fd, std::size_t bytes, std::int64_t offset) override { return port_.map(fd, bytes, offset); }
  void unmap(void* memory, std::size_t bytes) noexcept override { port_.unmap(memory, bytes); }
  std::size_t inside() const { return inside_; }

 private:
  V4l2Port& port_;
  std::atomic<std::size_t> inside_{0};  // 64 bits are not atomic on every board
};

TEST_F(V4l2Lending, CycleAllocatesNothing) {
  CountingPort port(sim_);
  options_.look_every = 1h;  // nor does the camera's own thread, which is no part of a cycle, while this is counted
  auto opened = V4l2Camera::open(port, spec_, system_os(), watch_, options_, why_);
  ASSERT_TRUE(opened) << why_;
  camera_ = std::move(*opened);
  ASSERT_EQ(begin(), std::nullopt) << why_;
  free_.reserve(kImages);
  ASSERT_TRUE(streams());
  const auto shown = picture(0);
  std::uint64_t allocated = 0;
  for (std::uint32_t n = 0; n < 200; ++n) {
    ASSERT_TRUE(sim_.deliver(*shown, stamp(n)));
    const std::uint64_t before = test::allocations() - port.inside();
    msg::Image* image = cycle();
    allocated += test::allocations() - port.inside() - before;
    ASSERT_NE(image, nullptr);
    give_up(image);
  }
  EXPECT_EQ(allocated, 0u);
  end();
  camera_.reset();  // before the port
}

TEST_F(V4l2Lending, TakingWhileItComesAndGoesAndRestsNeverMixesPictures) {
  ASSERT_TRUE(start());
  std::atomic<bool> done{false};
  auto world = system_os().start_thread(named("world"), [&] {
    for (std::uint32_t i = 0; i < 600; ++i) {
      if (i % 100 == 50) sim_.unplug();
      if (i % 100 == 55) sim_.plug_in();
      deliver(i);
      system_os().sleep_until(system_os().now() + 100us);
    }
    done = true;
  });
  ASSERT_TRUE(world);
  std::uint32_t last = 0;
  std::uint64_t frames = 0, cycles = 0;
  while (!done.load()) {
    if (++cycles % 5000 < 500) {  // switched off for a while
      take_all_back();
      continue;
    }
    msg::Image* image = cycle();
    if (!image) continue;
    ASSERT_TRUE(holds(*image, picture(image->pixels()[0])));
    if (frames++ > 0) {
      ASSERT_LT(last, image->frame_number);
    }
    last = image->frame_number;
    give_up(image);
  }
  (*world)->join();
  EXPECT_EQ(frames, camera_->stats().frames);
}

}  // namespace
}  // namespace sinew::hal::v4l2_lending_test
