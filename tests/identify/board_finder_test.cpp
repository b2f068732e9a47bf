// vision::BoardFinder on pictures through secret lenses; here, where these pictures are made.
#include "vision/board_finder.hpp"

#include <gtest/gtest.h>

#include "board_picture.hpp"

namespace sinew::vision::board_finder_test {
namespace {

constexpr BoardSize kBoard{9, 6};
constexpr double kSquare = 0.03;
constexpr double kWidth = 320, kHeight = 240;
constexpr identify::LensCamera kCamera{230, 232, 165, 117, {-0.15, 0.03, 0, 0, 0}};

class FindsABoard : public testing::Test {
 protected:
  identify::test::BoardPictures pictures{kCamera, kBoard, kSquare, {.width = 320, .height = 240}};
  math::Random random{1};
  BoardFinder finder{kBoard};
  kinematics::Pose some() {
    return identify::test::held(pictures, kCamera, kBoard, kSquare, kWidth, kHeight, 0.6, random);
  }
};

TEST_F(FindsABoard, WithinATenthOfAPixel) {
  double squares = 0;
  int found = 0, count = 0;
  for (int i = 0; i < 20; ++i) {
    const kinematics::Pose plane = some();
    if (!finder.find(pictures.draw(plane, random))) continue;
    ++found;
    const auto truth = pictures.corners(plane);
    ASSERT_EQ(finder.corners().size(), truth.size());
    for (std::size_t k = 0; k < truth.size(); ++k, ++count) {
      const double off =
          math::hypot(finder.corners()[k].u_px - truth[k].u_px, finder.corners()[k].v_px - truth[k].v_px);
      EXPECT_LT(off, 1) << i << " corner " << k;
      squares += off * off;
    }
  }
  EXPECT_GE(found, 19);
  EXPECT_LT(math::sqrt(squares / count), 0.15);
}

TEST_F(FindsABoard, AndKnowsItsEndsWhenItIsUpsideDown) {
  kinematics::Pose plane{{-0.12, -0.07, 0.45}, math::Quat::exp({0.2, -0.2, 0.1})};
  plane = plane * kinematics::Pose{{8 * kSquare, 5 * kSquare, 0}, math::Quat::exp({0, 0, math::kPi})};
  ASSERT_TRUE(finder.find(pictures.draw(plane, random)));
  const auto truth = pictures.corners(plane);
  EXPECT_NEAR(finder.corners()[0].u_px, truth[0].u_px, 1);
  EXPECT_NEAR(finder.corners()[53].v_px, truth[53].v_px, 1);
}

TEST_F(FindsABoard, OnlyOfTheSizeThatItWasAskedFor) {
  const auto picture = pictures.draw({{-0.12, -0.07, 0.45}, {}}, random);
  EXPECT_TRUE(BoardFinder({9, 6}).find(picture));
  EXPECT_TRUE(BoardFinder({6, 9}).find(picture)) << "the same one, named the other way round";
  EXPECT_FALSE(BoardFinder({8, 6}).find(picture)) << "it would be there twice";
  EXPECT_FALSE(BoardFinder({10, 6}).find(picture));
  EXPECT_FALSE(BoardFinder({9, 33}).find(picture));
}

TEST_F(FindsABoard, OnlyWhole) {
  EXPECT_FALSE(finder.find(pictures.draw({{-0.42, -0.07, 0.45}, {}}, random))) << "its left end is outside";
}

TEST_F(FindsABoard, NeverInNoise) {
  std::vector<std::uint8_t> noise(320 * 240);
  for (int picture = 0; picture < 5; ++picture) {
    for (std::uint8_t& p : noise) p = static_cast<std::uint8_t>(random.below(256));
    EXPECT_FALSE(finder.find({noise.data(), 320, 240, 320, msg::PixelFormat::mono8}));
  }
  EXPECT_FALSE(finder.find({}));
  EXPECT_FALSE(finder.find({noise.data(), 20, 20, 20, msg::PixelFormat::mono8}));
  EXPECT_FALSE(finder.find({noise.data(), 160, 240, 320, msg::PixelFormat::yuyv})) << "mono8 only";
}

}  // namespace
}  // namespace sinew::vision::board_finder_test
