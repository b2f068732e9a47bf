#include "sim_hil/usarsim/image_session.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace sinew::usarsim::image_session_test {
namespace {

void send(ImageSession& s, std::string_view bytes) { s.receive(std::as_bytes(std::span(bytes.data(), bytes.size()))); }

std::uint32_t big(std::string_view bytes, std::size_t at, std::size_t n) {
  std::uint32_t v = 0;
  for (std::size_t i = 0; i < n; ++i) v = v << 8 | static_cast<unsigned char>(bytes[at + i]);
  return v;
}
std::string area(std::uint32_t x, std::uint32_t y, std::uint32_t w, std::uint32_t h) {
  std::string all = "U";
  for (const std::uint32_t v : {x, y, w, h})
    for (int shift = 24; shift >= 0; shift -= 8) all += static_cast<char>(v >> shift & 255);
  return all;
}
/// 5 x 3 pixels: red is x, green y.
Picture small() {
  Picture p{5, 3, {}};
  for (std::uint8_t y = 0; y < 3; ++y)
    for (std::uint8_t x = 0; x < 5; ++x) p.rgb.insert(p.rgb.end(), {x, y, 9});
  return p;
}
Options raw() {
  Options o;
  o.image_type = 0;
  return o;
}

TEST(UsarImages, OkGetsARawFrameWithRowsPaddedToFour) {
  Rig rig(raw());
  ImageSession s(rig.game, "");
  EXPECT_FALSE(s.wanted());
  send(s, "OK\r\n");
  ASSERT_TRUE(s.wanted());
  s.answer(small());
  const std::string_view all = s.waiting();
  ASSERT_EQ(all.size(), 1 + 4 + 4 + 3 * 16u);
  EXPECT_EQ(all[0], 0);
  EXPECT_EQ(big(all, 1, 4), 4 + 3 * 16u);
  EXPECT_EQ(big(all, 5, 2), 5u);
  EXPECT_EQ(big(all, 7, 2), 3u);
  EXPECT_EQ(all.substr(9 + 16, 3), std::string_view("\0\1\x9", 3)) << "second row, first pixel";
  EXPECT_EQ(all[9 + 15], 0) << "padding";
}

TEST(UsarImages, UGetsThePartThatIsInThePicture) {
  Rig rig(raw());
  ImageSession s(rig.game, "");
  const std::string ask = area(3, 1, 10, 1);
  for (const char c : ask) send(s, {&c, 1});  // however it is split
  ASSERT_TRUE(s.wanted());
  s.answer(small());
  const std::string_view all = s.waiting();
  EXPECT_EQ(big(all, 5, 2), 2u);
  EXPECT_EQ(big(all, 7, 2), 1u);
  EXPECT_EQ(all.substr(9, 6), std::string_view("\3\1\x9\4\1\x9", 6));
  s.drop_sent(all.size());
  send(s, area(5, 0, 1, 1) + area(0, 0, 0, 5) + area(0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF));
  for (int i = 0; i < 3; ++i) s.answer(small());
  EXPECT_TRUE(s.waiting().empty()) << "outside";
  EXPECT_EQ(rig.game.counts().unusable, 3u);
}

TEST(UsarImages, JpegHasItsType) {
  Options o;
  o.image_type = 3;
  Rig rig(o);
  ImageSession s(rig.game, "");
  send(s, "OK");
  s.answer(small());
  const std::string_view all = s.waiting();
  if (all[0] == 0) GTEST_SKIP() << "a build without JPEG";
  EXPECT_EQ(all[0], 3);
  EXPECT_EQ(big(all, 1, 4), all.size() - 5);
  EXPECT_EQ(all.substr(5, 2), "\xff\xd8");
}

TEST(UsarImages, OtherBytesAreSkippedAndRequestsQueueUp) {
  Rig rig(raw());
  ImageSession s(rig.game, "");
  send(s, "hello OX OK OK\n");
  EXPECT_EQ(rig.game.counts().skipped, 10u);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(s.wanted());
    s.answer(small());
    EXPECT_FALSE(s.wanted()) << "not before the last one is sent";
    s.drop_sent(s.waiting().size());
  }
  EXPECT_FALSE(s.wanted());
}

TEST(UsarImages, LegacySendsOneAtOnce) {
  Options o = raw();
  o.legacy = true;
  Rig rig(o);
  EXPECT_TRUE(ImageSession(rig.game, "").wanted());
}

// ---- whose pictures

/// Fills the tile with the number of the camera's place.
class TestPainter final : public Painter {
 public:
  bool busy() const override { return busy_ > 0 && busy_-- > 0; }
  void request(const plant::Scene& scene, std::uint8_t* rgb) override {
    std::fill_n(rgb, 320 * 240 * 3, static_cast<std::uint8_t>(100 + scene.camera.p_world_m.x));
    busy_ = 3;
  }

 private:
  mutable int busy_ = 0;
};

Picture made(Rig& rig, const std::string& address) {
  TestPainter painter;
  PictureMaker maker(rig.game, painter);
  maker.begin(rig.game.wall(address));
  for (int i = 0; i < 100; ++i)
    if (const Picture* p = maker.poll()) return *p;
  ADD_FAILURE() << "no picture";
  return {};
}
int pixel(const Picture& p, std::uint32_t x, std::uint32_t y) {
  return p.rgb[(std::size_t{y} * p.width + x) * 3] - 100;
}

TEST(UsarViews, CamerasOfAllRobotsStandSideBySideFourInARow) {
  Rig rig;
  EXPECT_EQ(made(rig, "").width, 320u) << "black, but a picture";
  for (int i = 0; i < 5; ++i) rig.with("AirRobot", "{Location " + std::to_string(10 * i) + ",20,1}");
  const Picture p = made(rig, "10.0.0.1");
  EXPECT_EQ(p.width, 4 * 320u);
  EXPECT_EQ(p.height, 2 * 240u);
  for (std::uint32_t i = 0; i < 5; ++i)
    EXPECT_EQ(pixel(p, i % 4 * 320 + 160, i / 4 * 240 + 120), static_cast<int>(10 * i)) << i;
}

TEST(UsarViews, AClientChoosesWhatItSees) {
  Rig rig;
  Client &a = rig.with("AirRobot", "{Location 10,20,1}"), &b = rig.with("P3AT", "{Location 20,20,1}");
  a.say("SET {Type Camera} {Robot R2} {Name Camera} {Client 10.0.0.9}");
  EXPECT_EQ(made(rig, "10.0.0.1").width, 640u) << "others see all";
  Picture p = made(rig, "10.0.0.9");
  EXPECT_EQ(p.width, 320u);
  EXPECT_EQ(pixel(p, 5, 5), 20);
  a.say(
      "SET {Type Viewports} {Config QuadView} {Viewport1 Camera} {Viewport2 Disabled} {Viewport3 R2} {Viewport4 None}");
  p = made(rig, "10.0.0.1");
  EXPECT_EQ(p.width, 640u);
  EXPECT_EQ(p.height, 480u);
  EXPECT_EQ(pixel(p, 10, 10), 10);
  EXPECT_EQ(pixel(p, 330, 10), -100) << "black";
  EXPECT_EQ(pixel(p, 10, 250), 20);
  b.leave();
  EXPECT_EQ(pixel(made(rig, "10.0.0.1"), 10, 250), -100) << "it is gone";
  EXPECT_EQ(made(rig, "10.0.0.9").width, 320u) << "whose only choice is gone sees all again: one";
}

}  // namespace
}  // namespace sinew::usarsim::image_session_test
