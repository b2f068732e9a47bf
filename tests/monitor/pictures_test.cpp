#include "monitor/pictures.hpp"

#include <gtest/gtest.h>

#include <future>
#include <map>
#include <set>

#include "site_rig.hpp"

namespace sinew::monitor::pictures_test {
namespace {

using test::HttpClient;
using test::Reply;
using test::SiteRig;
using namespace std::chrono_literals;

class MonitorPictures : public testing::Test {
 protected:
  static constexpr int kEyes = 8;
  static tap::RobotOptions with_eyes() {
    tap::RobotOptions options;
    options.graph.eyes = kEyes;
    return options;
  }
  tap::OwnRunDir dir_;
  tap::Robot robot_{with_eyes()};
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

/// The robot's feed, taken on the server's thread.
std::shared_ptr<RobotFeed> feed_of(SiteRig& rig) {
  std::promise<std::shared_ptr<RobotFeed>> feed;
  rig.server->post(
      [&] { rig.site->feeds().with("robot", [&](const auto& f, const std::string&) { feed.set_value(f); }); });
  return feed.get_future().get();
}

TEST_F(MonitorPictures, EightTopicsOfOneRobotAtOnce) {
  SiteRig rig;
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int i = 1; i <= kEyes; ++i) {
    const std::string name = i == 1 ? "eye" : "eye" + std::to_string(i);
    clients.push_back(std::make_unique<HttpClient>(rig.port()));
    clients.back()->send("GET /robot/images/" + name + ".image.mjpg HTTP/1.1\r\nHost: " + clients.back()->host() +
                         "\r\n\r\n");
  }
  for (const auto& client : clients) EXPECT_EQ(client->reply(true).status, 200);
  for (int round = 0; round < 3; ++round)
    for (const auto& client : clients) EXPECT_TRUE(client->wait_for("content-type: image/jpeg\r\n"));
}

TEST_F(MonitorPictures, ThoseOfHttpAndOfTheWebSocketAreTheSame) {
  SiteRig rig;
  const auto feed = feed_of(rig);
  ASSERT_TRUE(feed);
  HttpClient client(rig.port());
  EXPECT_EQ(client.get("/robot/images/eye.image.jpg").status, 200);
  robot_.real->stop();  // no newer picture comes
  const auto encoded = [&] { return feed->pictures()->counters().encoded; };
  const std::uint64_t before = encoded();
  const Reply reply = client.get("/robot/images/eye.image.jpg");
  const auto& channels = feed->facts().channels;
  const auto jpeg = std::find_if(channels.begin(), channels.end(),
                                 [](const foxglove::Channel& c) { return c.topic == "/eye.image/jpeg"; });
  ASSERT_NE(jpeg, channels.end());
  const auto take = [&](const foxglove::PictureSize& size) {
    const auto told = std::make_shared<std::promise<void>>();
    const auto inbox =
        std::make_shared<foxglove::Inbox>(1, std::make_shared<foxglove::Backlog>([told] { told->set_value(); }));
    const auto tap = feed->look(static_cast<std::size_t>(jpeg - channels.begin()), inbox);
    tap->want(size);
    told->get_future().wait();
    return std::move(*inbox->take());
  };
  const foxglove::Item same = take({});
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(same.payload->data()), same.payload->size()), reply.body);
  EXPECT_LE(encoded(), before + 1);  // 0: the last one of before was of the same message
  EXPECT_NE(*take({40, 0.5}).payload, *same.payload);
  EXPECT_LE(encoded(), before + 2);
}

TEST_F(MonitorPictures, OneEncodingHoweverManyLookAndNoneWhenNobodyDoes) {
  std::mutex mutex;                                // what viewers use is there until the picture thread has ended
  std::map<std::uint32_t, std::set<Bytes>> files;  // by sequence
  std::atomic<int> told{0};
  SiteRig rig;
  const auto feed = feed_of(rig);
  ASSERT_TRUE(feed);
  const auto pictures = feed->pictures();
  std::string why;
  const auto topic = pictures->find("eye.image", why);
  ASSERT_TRUE(topic) << why;
  {
    std::vector<std::shared_ptr<RobotPictures::Viewer>> viewers(8);
    for (auto& viewer : viewers) {
      viewer = RobotPictures::look(pictures, *topic, [&](const auto& picture) {
        const std::lock_guard lock(mutex);
        files[picture->sequence].insert(picture->file);
        ++told;
        return true;
      });
    }
    while (told < 80) {
      for (const auto& viewer : viewers) viewer->want({});
      std::this_thread::sleep_for(1ms);
    }
    viewers.clear();
    const std::lock_guard lock(mutex);
    for (const auto& [sequence, all] : files) EXPECT_EQ(all.size(), 1u) << sequence;
  }
  // Until the robot has published ten more of which none was encoded.
  const auto encoded = [&] { return pictures->counters().encoded; };
  auto client = robot_.client();
  const auto reader = client->reader();
  ASSERT_TRUE(reader);
  std::uint64_t before = 0;
  do {
    before = encoded();
    const std::uint32_t first = (*reader)->newest(*topic)->sequence;
    while ((*reader)->newest(*topic)->sequence - first < 10) std::this_thread::sleep_for(1ms);
  } while (encoded() != before);
}

TEST_F(MonitorPictures, AViewerThatWantsTheNextOneAtOnceGetsIt) {
  std::shared_ptr<RobotPictures::Viewer> viewer;
  std::promise<void> enough;
  std::atomic<int> calls{0};
  SiteRig rig;
  const auto feed = feed_of(rig);
  ASSERT_TRUE(feed);
  const auto pictures = feed->pictures();
  std::string why;
  viewer = RobotPictures::look(pictures, *pictures->find("eye.image", why), [&](const auto&) {
    if (++calls < 6) viewer->want({});
    if (calls == 6) enough.set_value();
    return true;
  });
  viewer->want({});
  enough.get_future().wait();
  viewer.reset();
}

TEST_F(MonitorPictures, AViewerThatHasNoUseForAPictureStillWantsOne) {
  std::promise<std::string> said;
  std::atomic<int> calls{0};
  SiteRig rig;
  const auto feed = feed_of(rig);
  ASSERT_TRUE(feed);
  const auto pictures = feed->pictures();
  std::string why;
  const auto viewer = RobotPictures::look(pictures, *pictures->find("eye.image", why), [&](const auto& picture) {
    if (++calls < 3) return false;
    if (calls == 3) said.set_value(picture->why);
    return true;
  });
  Recipe beyond;
  beyond.cut.x = 5000;
  viewer->want(beyond);
  EXPECT_NE(said.get_future().get().find("outside"), std::string::npos);
}

}  // namespace
}  // namespace sinew::monitor::pictures_test
