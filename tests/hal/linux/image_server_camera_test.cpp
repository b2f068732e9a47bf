// A camera against an image server that the test plays, over real sockets on this machine.
#include "hal/linux/image_server/image_server_camera.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "hal/platform.hpp"

namespace sinew::hal::image_server_camera_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

void append32(Bytes& to, std::uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) to.push_back(static_cast<std::uint8_t>(number >> shift));
}

/// A raw picture of 16x16: each pixel is (x, y, value), rows are padded by `pad` bytes.
Bytes raw(std::uint8_t value, std::uint32_t width = 16, std::uint32_t height = 16) {
  Bytes data{0, static_cast<std::uint8_t>(width), 0, static_cast<std::uint8_t>(height)};
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      data.push_back(static_cast<std::uint8_t>(x));
      data.push_back(static_cast<std::uint8_t>(y));
      data.push_back(value);
    }
    while ((data.size() - 4) % 4 != 0) data.push_back(0xAA);
  }
  Bytes all{0};
  append32(all, static_cast<std::uint32_t>(data.size()));
  all.insert(all.end(), data.begin(), data.end());
  return all;
}

/// Accepts, and answers each request with what the test says; nothing: it does not answer.
class Server {
 public:
  explicit Server(std::function<Bytes(int request)> answer, const std::string& at = "tcp:127.0.0.1:0")
      : answer_(std::move(answer)) {
    auto listener = listen_stream(at);
    if (!listener) throw std::runtime_error("no listener");
    listener_ = std::move(*listener);
    thread_ = std::thread([this] { run(); });
  }
  ~Server() {
    stop_ = true;
    thread_.join();
  }
  const std::string& endpoint() const { return listener_->endpoint(); }
  void cut() { cut_ = true; }
  int requests() const { return requests_; }
  int connections() const { return connections_; }
  Bytes last_request() const {
    const std::lock_guard lock(mutex_);
    return last_;
  }

 private:
  void run() {
    std::unique_ptr<Stream> peer;
    while (!stop_) {
      if (cut_.exchange(false)) peer.reset();
      if (!peer) {
        auto made = listener_->accept(20ms);
        if (!made) continue;
        peer = std::move(*made);
        peer->set_patience(20ms);
        ++connections_;
      }
      std::array<std::byte, 64> bytes;
      const auto got = peer->read(bytes);
      if (!got && got.error().code == Errc::timeout) continue;
      if (!got) {
        peer.reset();
        continue;
      }
      {
        const std::lock_guard lock(mutex_);
        last_.assign(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                     reinterpret_cast<const std::uint8_t*>(bytes.data()) + *got);
      }
      const Bytes answer = answer_(++requests_);
      if (!answer.empty() && !peer->write(std::as_bytes(std::span(answer)))) peer.reset();
    }
  }
  std::function<Bytes(int)> answer_;
  std::unique_ptr<Listener> listener_;
  std::atomic<bool> stop_{false}, cut_{false};
  std::atomic<int> requests_{0}, connections_{0};
  mutable std::mutex mutex_;
  Bytes last_;
  std::thread thread_;
};

struct Rig {
  ImageServerSpec spec;
  std::unique_ptr<Camera> camera;
  msg::ImageBuffer image{msg::PixelFormat::rgb8, 16, 16};

  explicit Rig(const std::string& endpoint) {
    spec.endpoint = endpoint;
    spec.width = spec.height = 16;
    spec.rate_hz = 100;
    spec.silent = 200ms;
  }
  void open() {
    std::string why;
    auto opened = ImageServerCamera::open(spec, system_os(), why);
    ASSERT_TRUE(opened) << why;
    camera = std::move(*opened);
  }
  /// Reads until something comes: true, or an error; or 5 s are over.
  Result<bool> read() {
    for (const Time end = system_os().now() + 5s; system_os().now() < end;) {
      const auto got = camera->read(*image);
      if ((got && *got) || (!got && got.error().code != Errc::closed)) return got;
      system_os().sleep_until(system_os().now() + 2ms);
    }
    return false;
  }
  ImageServerStats stats() const { return static_cast<ImageServerCamera*>(camera.get())->stats(); }
  std::string trouble() const { return static_cast<ImageServerCamera*>(camera.get())->trouble(); }
  bool until(const std::function<bool()>& true_now) {
    for (const Time end = system_os().now() + 5s; system_os().now() < end;) {
      if (true_now()) return true;
      system_os().sleep_until(system_os().now() + 2ms);
    }
    return false;
  }
};

TEST(ImageServerCamera, BringsRawPicturesWithNumbersAndStampsBetweenRequestAndAnswer) {
  Server server([](int n) { return raw(static_cast<std::uint8_t>(n)); });
  Rig rig(server.endpoint());
  rig.open();
  Time before;
  for (std::uint32_t n = 0; n < 5; ++n) {
    const auto got = rig.read();
    ASSERT_TRUE(got && *got);
    EXPECT_EQ(rig.image->frame_number, n);
    EXPECT_EQ(rig.image->row(3)[3 * 7 + 0], 7);
    EXPECT_EQ(rig.image->row(3)[3 * 7 + 1], 3);
    EXPECT_EQ(rig.image->row(3)[3 * 7 + 2], n + 1) << "each was asked for, none is skipped";
    EXPECT_GT(rig.image->stamp, before);
    EXPECT_LE(rig.image->stamp, system_os().now());
    before = rig.image->stamp;
  }
  EXPECT_EQ(rig.trouble(), "");
  EXPECT_EQ(server.last_request(), (Bytes{'O', 'K'}));
  EXPECT_EQ(rig.stats().connections, 1u);
}

TEST(ImageServerCamera, AsksForNoMoreThanIsTaken) {
  Server server([](int n) { return raw(static_cast<std::uint8_t>(n)); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.until([&] { return rig.camera->ready_at() == Time{0}; }));
  system_os().sleep_until(system_os().now() + 100ms);
  EXPECT_EQ(server.requests(), 1) << "nobody took the first one";
}

TEST(ImageServerCamera, WakesWhoWaits) {
  struct Count final : Wake {
    std::atomic<int> rings{0};
    void wake() noexcept override { ++rings; }
  } count;
  Server server([](int n) { return raw(static_cast<std::uint8_t>(n)); });
  Rig rig(server.endpoint());
  rig.open();
  rig.camera->set_wake(&count);
  const auto got = rig.read();
  ASSERT_TRUE(got && *got);
  EXPECT_TRUE(rig.until([&] { return count.rings > 0; }));
  rig.camera->set_wake(nullptr);
}

TEST(ImageServerCamera, TurnsBytesRoundForAServerThatSendsBgr) {
  Server server([](int) { return raw(200); });
  Rig rig(server.endpoint());
  rig.spec.raw_is_bgr = true;
  rig.open();
  const auto got = rig.read();
  ASSERT_TRUE(got && *got);
  EXPECT_EQ(rig.image->row(3)[3 * 7 + 0], 200);
  EXPECT_EQ(rig.image->row(3)[3 * 7 + 2], 7);
}

TEST(ImageServerCamera, AsksForAPart) {
  Server server([](int) { return raw(1); });
  Rig rig(server.endpoint());
  rig.spec.x = 320, rig.spec.region_width = 16, rig.spec.region_height = 16;
  rig.open();
  const auto got = rig.read();
  ASSERT_TRUE(got && *got);
  EXPECT_EQ(server.last_request(), (Bytes{'U', 0, 0, 1, 0x40, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0, 0, 16}));
}

TEST(ImageServerCamera, IsGoneWithoutAServerAndGoesOnWhenThereIsOne) {
  std::string endpoint;
  {
    Server gone([](int) { return Bytes{}; });
    endpoint = gone.endpoint();
  }
  Rig rig(endpoint);
  rig.open();
  ASSERT_TRUE(rig.until([&] { return !rig.trouble().empty(); }));
  EXPECT_NE(rig.trouble().find(endpoint), std::string::npos);
  const auto none = rig.camera->read(*rig.image);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::closed);
  Server server([](int) { return raw(9); }, endpoint);
  const auto got = rig.read();
  ASSERT_TRUE(got && *got);
  EXPECT_TRUE(rig.until([&] { return rig.trouble().empty(); }));
}

TEST(ImageServerCamera, ACutConnectionIsMadeAnew) {
  Server server([](int n) { return raw(static_cast<std::uint8_t>(n)); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.read());
  server.cut();
  ASSERT_TRUE(rig.until([&] {
    static_cast<void>(rig.camera->read(*rig.image));
    return server.connections() == 2;
  }));
  const auto got = rig.read();
  EXPECT_TRUE(got && *got);
}

TEST(ImageServerCamera, AServerThatFallsSilentIsGoneAndAskedAnew) {
  std::atomic<bool> silent{false};
  Server server([&](int n) { return silent ? Bytes{} : raw(static_cast<std::uint8_t>(n)); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.read());
  silent = true;
  ASSERT_TRUE(rig.until([&] {
    const auto got = rig.camera->read(*rig.image);
    return !got && got.error().code == Errc::closed;
  }));
  EXPECT_NE(rig.trouble().find("sends no pictures"), std::string::npos) << rig.trouble();
  silent = false;
  const auto got = rig.read();
  EXPECT_TRUE(got && *got);
}

TEST(ImageServerCamera, GarbageIsNoPictureAndTheConnectionIsMadeAnew) {
  Server server([](int n) { return n == 2 ? Bytes{'H', 'T', 'T', 'P', '/', '1', '.', '1'} : raw(3); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.read());
  ASSERT_TRUE(rig.read());
  EXPECT_EQ(rig.stats().broken, 1u);
  EXPECT_EQ(rig.stats().connections, 2u);
}

TEST(ImageServerCamera, AnEnormousSizeAllocatesNothing) {
  Server server([](int n) { return n == 1 ? Bytes{0, 0xFF, 0xFF, 0xFF, 0xFF} : raw(3); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.read());
  EXPECT_EQ(rig.stats().broken, 1u);
}

TEST(ImageServerCamera, PicturesOfAnotherSizeAreNamed) {
  Server server([](int) { return raw(3, 20, 10); });
  Rig rig(server.endpoint());
  rig.open();
  ASSERT_TRUE(rig.until([&] { return rig.stats().refused > 0; }));
  EXPECT_NE(rig.trouble().find("20x10"), std::string::npos) << rig.trouble();
  EXPECT_NE(rig.trouble().find("16x16"), std::string::npos);
}

TEST(ImageServerCamera, ATopicThatIsTooSmallIsAnError) {
  Server server([](int) { return raw(3); });
  Rig rig(server.endpoint());
  rig.image = msg::ImageBuffer(100);
  rig.open();
  const auto got = rig.read();
  ASSERT_FALSE(got);
  EXPECT_EQ(got.error().code, Errc::bad_argument);
}

TEST(ImageServerCamera, EndsAtOnceWhileAServerIsSilent) {
  Server server([](int) { return Bytes{}; });
  Rig rig(server.endpoint());
  rig.spec.silent = 60s;
  rig.open();
  ASSERT_TRUE(rig.until([&] { return server.requests() == 1; }));
  const Time begin = system_os().now();
  rig.camera.reset();
  EXPECT_LT(system_os().now() - begin, 2s);
}

}  // namespace
}  // namespace sinew::hal::image_server_camera_test
