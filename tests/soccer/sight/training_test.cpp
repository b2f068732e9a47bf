// The ball classifier learns what it is shown; confidences are shares; the carpet of pictures is measured.
#include <gtest/gtest.h>

#include "apps/sight/carpets.hpp"
#include "apps/sight/train.hpp"
#include "apps/toml/body_reader.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::sight::training_test {
namespace {

using soccer::BallPatch;

/// Discs are balls, stripes are not; both bright on dark, with noise.
std::vector<Example> discs_and_stripes(std::size_t count, std::uint64_t seed, std::uint32_t one_of) {
  math::Random random(seed);
  std::vector<Example> all(count);
  for (Example& e : all) {
    e.is_ball = random.below(one_of) == 0;
    const double r = random.uniform(3, 6), cx = random.uniform(6, 9), cy = random.uniform(6, 9);
    const math::SinCos t = math::sincos(random.uniform(0, math::kPi));
    for (std::size_t y = 0; y < BallPatch::kSide; ++y)
      for (std::size_t x = 0; x < BallPatch::kSide; ++x) {
        const double dx = static_cast<double>(x) - cx, dy = static_cast<double>(y) - cy;
        const bool in = e.is_ball ? dx * dx + dy * dy < r * r : math::fabs(t.cos * dx + t.sin * dy) < 0.6 * r;
        e.patch.value[y * BallPatch::kSide + x] = static_cast<float>((in ? 1.2 : -0.8) + random.normal(0, 0.3));
      }
  }
  return all;
}

double mean_confidence(const std::vector<float>& weights, const std::vector<Example>& of, bool balls) {
  const soccer::BallNet net(std::span<const float, soccer::BallNet::kWeights>{weights});
  double sum = 0, n = 0;
  for (const Example& e : of)
    if (e.is_ball == balls) sum += net.confidence(e.patch), n += 1;
  return sum / n;
}

TEST(BallTraining, LearnsDiscsAndGivesTheSameWeightsTwice) {
  const std::vector<Example> shown = discs_and_stripes(1600, 1, 2), kept = discs_and_stripes(300, 2, 2);
  const std::vector<float> w = train(shown, {.epochs = 6});
  EXPECT_GT(mean_confidence(w, kept, true), 0.85);
  EXPECT_LT(mean_confidence(w, kept, false), 0.15);
  EXPECT_EQ(w, train(shown, {.epochs = 6}));
}

TEST(BallTraining, ConfidencesBecomeShares) {
  std::vector<float> w = train(discs_and_stripes(1600, 1, 2), {.epochs = 2});
  // Balls are rarer than among the examples.
  const std::vector<Example> as_they_come = discs_and_stripes(1500, 3, 10);
  calibrate(w, as_they_come);
  const soccer::BallNet net(std::span<const float, soccer::BallNet::kWeights>{w});
  double expected = 0, balls = 0;
  for (const Example& e : as_they_come) expected += net.confidence(e.patch), balls += e.is_ball;
  EXPECT_NEAR(expected, balls, 0.02 * balls);
}

TEST(BallNet, SeesThatAMirrorShowsAnotherPicture) {
  std::vector<Example> one = discs_and_stripes(1, 4, 1);
  BallPatch twice = one[0].patch;
  soccer::mirror(twice);
  EXPECT_NE(twice.value, one[0].patch.value);
  EXPECT_EQ(twice.value[0], one[0].patch.value[BallPatch::kSide - 1]);
  soccer::mirror(twice);
  EXPECT_EQ(twice.value, one[0].patch.value);
}

TEST(Carpets, AreMeasuredInPicturesAndWrittenForARobotsFile) {
  const app::LoadedBody op3 = app::load_body(test::source_dir() + "/robots/kid/op3.toml");
  ASSERT_TRUE(op3.problems.empty());
  SceneMaker maker(op3.body, {.lighting = Lighting::clean, .seed = 12});
  std::vector<Photo> photos(12);
  Scene scene;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    maker.make(i, scene);
    photos[i].width = scene.width, photos[i].height = scene.height, photos[i].yuyv = scene.yuyv;
  }
  Carpets carpets;
  measure_photos(photos, 0.5, carpets);
  EXPECT_EQ(carpets.pictures, 12u);
  ASSERT_GE(carpets.looks.size(), 8u);
  const soccer::CarpetLook look = median(carpets), drawn{};
  EXPECT_NEAR(look.u, drawn.u, 0.05);
  EXPECT_NEAR(look.v, drawn.v, 0.05);
  EXPECT_NE(report(carpets).find("params = { carpet_luma = "), std::string::npos);
}

TEST(Carpets, SayWhyARecordCannotBeMeasured) {
  Carpets carpets;
  std::string why;
  EXPECT_FALSE(measure_record("no_such_record.mcap", {}, carpets, why));
  EXPECT_NE(why.find("no_such_record.mcap"), std::string::npos);
}

}  // namespace
}  // namespace sinew::sight::training_test
