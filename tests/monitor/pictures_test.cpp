#include "monitor/pictures.hpp"

#include <gtest/gtest.h>

#include "site_rig.hpp"

namespace sinew::monitor::pictures_test {
namespace {

using test::HttpClient;
using test::Reply;
using test::SiteRig;
using namespace std::chrono_literals;

class MonitorPictures : public testing::Test {
 protected:
  tap::OwnRunDir dir_;
  tap::Robot robot_;
  void SetUp() override { robot_.start(); }
};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

TEST_F(MonitorPictures, ComeInEachKindWholeInPartAndSmaller) {
  SiteRig rig;
  HttpClient client(rig.port());
  const std::string topic = "/robot/images/eye.image";
  const Reply jpeg = client.get(topic + ".jpg?quality=90&chroma=422");
  EXPECT_EQ(jpeg.status, 200) << jpeg.body;
  EXPECT_EQ(jpeg.headers.at("content-type"), "image/jpeg");
  EXPECT_EQ(jpeg.body.substr(0, 2), "\xff\xd8");
  const Reply png = client.get(topic + ".png");
  ASSERT_EQ(png.body.substr(1, 3), "PNG");
  EXPECT_EQ(big_endian(png.body, 16), tap::Eye::kWidth);
  EXPECT_EQ(big_endian(png.body, 20), tap::Eye::kHeight);
  const Reply part = client.get(topic + ".png?region=10,20,40,30&scale=0.5");
  EXPECT_EQ(big_endian(part.body, 16), 20u);
  EXPECT_EQ(big_endian(part.body, 20), 15u);
  EXPECT_EQ(client.get(topic + ".bmp").body.substr(0, 2), "BM");
  EXPECT_EQ(client.get(topic + ".tiff").body.substr(0, 2), "II");
  const Reply head = client.ask("HEAD", topic + ".png");
  EXPECT_EQ(head.status, 200);
  EXPECT_GT(std::stoul(head.headers.at("content-length")), 0u);
  EXPECT_GT(std::stoul(head.headers.at("x-sinew-sequence")), 0u);
}

TEST_F(MonitorPictures, AreNotSentTwiceToWhoHasThem) {
  SiteRig rig;
  HttpClient client(rig.port());
  EXPECT_EQ(client.get("/robot/images/eye.image.png").status, 200);
  robot_.real->stop();  // no newer picture comes
  const Reply first = client.get("/robot/images/eye.image.png");
  ASSERT_EQ(first.status, 200) << first.body;
  const Reply again = client.get("/robot/images/eye.image.png", "If-None-Match: " + first.headers.at("etag") + "\r\n");
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(client.get("/robot/images/eye.image.png").body, first.body);
}

TEST_F(MonitorPictures, ErrorsSayWhatIsAllowed) {
  SiteRig rig;
  HttpClient client(rig.port());
  const auto says = [&](const std::string& path, int status, const std::string& text) {
    const Reply r = client.get("/robot/images/" + path);
    EXPECT_EQ(r.status, status) << path;
    EXPECT_NE(r.body.find(text), std::string::npos) << path << ": " << r.body;
  };
  says("eye.image.jpg?quality=0", 400, "an integer from 1 to 100");
  says("eye.image.jpg?scale=2", 400, "a number above 0, at most 1");
  says("eye.image.jpg?region=1,2,3", 400, "X,Y,WIDTH,HEIGHT");
  says("eye.image.jpg?region=500,0,10,10", 400, "outside");
  says("eye.image.jpg?colour=1", 400, "quality, chroma, scale, region");
  says("eye.image.gif", 400, ".jpg, .png, .tiff or .bmp");
  says("counter.range.jpg", 404, "eye.image");
  EXPECT_EQ(client.get("/nobody/images/eye.image.jpg").status, 404);
  EXPECT_EQ(client.ask("POST", "/robot/images/eye.image.jpg").status, 405);
}

TEST_F(MonitorPictures, AMovieHasTheNewestPicturesOneAfterTheOther) {
  SiteRig rig;
  HttpClient client(rig.port());
  client.send("GET /robot/images/eye.image.mjpg HTTP/1.1\r\nHost: " + client.host() + "\r\n\r\n");
  const Reply head = client.reply(true);
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-type").substr(0, 34), "multipart/x-mixed-replace; boundar");
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(client.wait_for("\r\ncontent-type: image/jpeg\r\n"));
  robot_.real->stop();  // a robot that ends publishes nothing more
  robot_.server.reset(), robot_.name.reset();
  EXPECT_TRUE(client.is_ended());
}

TEST_F(MonitorPictures, OneEncodingHoweverManyLookAndNoneWhenNobodyDoes) {
  std::string why;
  const auto stream = ImageStream::open("robot", "eye.image", why);
  ASSERT_TRUE(stream) << why;
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(stream->counters().encoded, 0u);
  std::atomic<int> told{0};
  {
    std::vector<std::shared_ptr<ImageStream::Viewer>> viewers;
    for (int i = 0; i < 8; ++i) viewers.push_back(stream->look({}, [&] { ++told; }));
    const auto until = std::chrono::steady_clock::now() + 10s;
    while (told < 80 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(1ms);
    EXPECT_GE(told, 80);
    // A viewer that came is told of the newest picture also when it was encoded before.
    EXPECT_LE(stream->counters().encoded, stream->counters().seen);
    EXPECT_EQ(viewers.front()->newest().bytes, viewers.back()->newest().bytes);
    // Another recipe has pictures of its own.
    Recipe other;
    other.cut.scale = 0.25;
    const auto small = stream->look(other, [] {});
    while (small->newest().serial == 0 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(1ms);
    ASSERT_GT(small->newest().serial, 0u);
    EXPECT_LT(small->newest().bytes->size(), viewers.front()->newest().bytes->size());
  }
  std::this_thread::sleep_for(20ms);
  const std::uint64_t before = stream->counters().encoded;
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(stream->counters().encoded, before);
}

}  // namespace
}  // namespace sinew::monitor::pictures_test
