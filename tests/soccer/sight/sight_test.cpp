// The module and what it sees in painted fields; figures over many rendered scenes: docs/soccer-vision.md.
#include "soccer/sight/sight.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "painted.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::soccer::sight_test {
namespace {

using namespace std::chrono_literals;
using msg::FieldMark;
using test::Painting;

struct SightRig {
  Sight sight;
  rt::ModuleRig rig{sight};
  msg::Time now{1'000'000'000};

  rt::StepStatus step(const Painting& p, msg::Time pose_stamp, msg::Time image_stamp) {
    rig.put_image("image", p.paint(image_stamp));
    rig.put("pose", p.pose(pose_stamp));
    msg::GaitState gait;
    gait.stamp = now;
    gait.x_m = p.robot.x_m, gait.y_m = p.robot.y_m, gait.heading_rad = p.robot.heading_rad;
    gait.mode = msg::GaitMode::stand;
    rig.put("gait", gait);
    now = now + 100ms;
    return rig.step(now - 80ms, 100ms);
  }
  const msg::SoccerSight* look(const Painting& p) {
    return step(p, now, now) == rt::StepStatus::ok ? rig.get<msg::SoccerSight>("sight") : nullptr;
  }
};

GroundXy in_robot(const RobotAt& robot, const FieldPoint& p) {
  const math::SinCos t = math::sincos(robot.heading_rad);
  const double dx = p.x_m - robot.x_m, dy = p.y_m - robot.y_m;
  return {t.cos * dx + t.sin * dy, t.cos * dy - t.sin * dx};
}

double distance(const msg::GroundPoint& a, const GroundXy& b) { return math::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }

TEST(Sight, SeesTheBallWhereItIsInDayAndTwilight) {
  SightRig rig;
  for (const double light : {1.0, 0.5, 1.3})
    for (const FieldPoint ball : {FieldPoint{0.2, 0.3}, {1.5, -0.4}, {-0.6, 0.05}}) {
      SCOPED_TRACE(testing::Message() << light << ": " << ball.x_m << ' ' << ball.y_m);
      const Painting p{.look_down_rad = 0.4, .ball = ball, .light = light};
      const msg::SoccerSight* s = rig.look(p);
      ASSERT_NE(s, nullptr);
      ASSERT_EQ(s->balls, 1u);
      EXPECT_GT(s->ball[0].confidence, 0.5);
      const GroundXy truth = in_robot(p.robot, ball);
      EXPECT_LT(distance(s->ball[0].at, truth), 0.03 + 0.04 * math::hypot(truth.x_m, truth.y_m));
      EXPECT_GT(s->ball[0].at.xx_m2, 0);
    }
}

TEST(Sight, AFieldWithoutABallHasNone) {
  SightRig rig;
  for (const double heading : {0.0, 0.7, 1.5, 2.2, 3.1, -0.8, -1.6, -2.4}) {
    const msg::SoccerSight* s = rig.look({.robot = {-2.5, 0.6, heading}});
    ASSERT_NE(s, nullptr);
    EXPECT_EQ(s->balls, 0u) << heading;
  }
}

TEST(Sight, LinesAreWhereTheFieldHasThem) {
  SightRig rig;
  const Field field;
  std::uint32_t lines = 0;
  for (const double heading : {0.0, 0.8, 1.6, 2.4, 3.1, -0.8, -1.6}) {
    const Painting p{.robot = {-2.2, 0.4, heading}};
    const msg::SoccerSight* s = rig.look(p);
    ASSERT_NE(s, nullptr);
    lines += s->lines;
    for (std::uint32_t i = 0; i < s->lines; ++i) {
      double best = math::kInf;
      for (const FieldLine& l : field.lines()) {
        const GroundXy a = in_robot(p.robot, l.from), b = in_robot(p.robot, l.to);
        const double n = math::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
        const auto off = [&](const msg::GroundPoint& q) {
          return math::fabs((b.x_m - a.x_m) * (q.y_m - a.y_m) - (b.y_m - a.y_m) * (q.x_m - a.x_m)) / n;
        };
        best = std::min(best, std::max(off(s->line[i].from), off(s->line[i].to)));
      }
      // A pixel and a half of its farther end.
      const double d2 = std::max(s->line[i].from.x_m * s->line[i].from.x_m + s->line[i].from.y_m * s->line[i].from.y_m,
                                 s->line[i].to.x_m * s->line[i].to.x_m + s->line[i].to.y_m * s->line[i].to.y_m);
      EXPECT_LT(best, 0.05 + 1.5 * (d2 + 0.2) / (p.camera_high_m * p.camera().fx_px)) << heading << ": line " << i;
    }
  }
  EXPECT_GT(lines, 12u);
}

TEST(Sight, TellsCornersApartAndWhereTheyPoint) {
  SightRig rig;
  const Field field;
  int found[5] = {};
  for (double heading = -3; heading < 3.1; heading += 0.8)
    for (const FieldPoint at : {FieldPoint{-3, 1}, {2.9, -1.2}, {-2.8, -1.9}}) {
      const Painting p{.robot = {at.x_m, at.y_m, heading}, .look_down_rad = 0.5};
      const msg::SoccerSight* s = rig.look(p);
      ASSERT_NE(s, nullptr);
      for (std::uint32_t i = 0; i < s->marks; ++i) {
        const msg::SeenMark& m = s->mark[i];
        if (m.kind != FieldMark::corner_l && m.kind != FieldMark::corner_t) continue;
        bool right = false;
        for (const FieldCorner& c : field.corners()) {
          const double turn = math::wrap_pi(m.heading_rad + heading - c.heading_rad);
          right =
              right || (c.kind == m.kind && distance(m.at, in_robot(p.robot, c.at)) < 0.15 && math::fabs(turn) < 0.25);
        }
        EXPECT_TRUE(right) << heading << ": " << m.at.x_m << ' ' << m.at.y_m;
        ++found[static_cast<std::size_t>(m.kind)];
      }
    }
  EXPECT_GT(found[0], 2);
  EXPECT_GT(found[1], 2);
}

TEST(Sight, SeesCircleAndPenaltyMark) {
  SightRig rig;
  const msg::SoccerSight* s = rig.look({.robot = {-1.6, 0.2, 0}, .look_down_rad = 0.3});
  ASSERT_NE(s, nullptr);
  bool circle = false;
  for (std::uint32_t i = 0; i < s->marks; ++i)
    if (s->mark[i].kind == FieldMark::circle) circle = distance(s->mark[i].at, {1.6, -0.2}) < 0.15;
  EXPECT_TRUE(circle);
  s = rig.look({.robot = {2, 0.2, 0}, .look_down_rad = 0.6});
  ASSERT_NE(s, nullptr);
  bool mark = false;
  for (std::uint32_t i = 0; i < s->marks; ++i)
    if (s->mark[i].kind == FieldMark::penalty_mark) mark = distance(s->mark[i].at, {0.975, -0.2}) < 0.08;
  EXPECT_TRUE(mark);
}

TEST(Sight, SeesPostsAndRobotsByWhatStandsUp) {
  SightRig rig;
  Painting p{.robot = {2, 0, 0}, .look_down_rad = 0.25};
  const Field field;
  for (const FieldPoint& post : field.posts()) p.poles.push_back({post, 0.05, 1.2, {225, 225, 225}});
  p.poles.push_back({{3.4, 0.3}, 0.12, 0.5, {36, 50, 150}});
  const msg::SoccerSight* s = rig.look(p);
  ASSERT_NE(s, nullptr);
  EXPECT_EQ(s->posts, 2u);
  for (std::uint32_t i = 0; i < s->posts; ++i) {
    double off = math::kInf;
    for (const FieldPoint& post : field.posts()) off = std::min(off, distance(s->post[i], in_robot(p.robot, post)));
    EXPECT_LT(off, 0.2);
  }
  ASSERT_EQ(s->robots, 1u);
  EXPECT_LT(distance(s->robot[0].at, {1.4, 0.3}), 0.2);
  EXPECT_EQ(s->robot[0].colour, msg::JerseyColour::blue);
}

TEST(Sight, APictureWithoutItsPoseIsStale) {
  SightRig rig;
  const Painting p;
  EXPECT_EQ(rig.step(p, rig.now, msg::Time{rig.now.ns - 100'000'000}), rt::StepStatus::stale) << "an older picture";
  EXPECT_NE(rig.look(p), nullptr);
  EXPECT_EQ(rig.rig.step(rig.now, 100ms), rt::StepStatus::stale) << "no new pose";
}

TEST(Sight, PlacesAreInTheFrameOfTheExposure) {
  SightRig rig;
  const Painting p{.robot = {-1, 0.5, 1}, .ball = FieldPoint{-0.6, 1.2}};
  rig.rig.put_image("image", p.paint(rig.now));
  rig.rig.put("pose", p.pose(rig.now));
  msg::GaitState gait;  // 20 ms later, by 10 mm farther ahead
  gait.stamp = rig.now + 20ms;
  gait.forward_mps = 0.5;
  gait.heading_rad = 1;
  gait.x_m = -1 + 0.01 * math::cos(1), gait.y_m = 0.5 + 0.01 * math::sin(1);
  rig.rig.put("gait", gait);
  ASSERT_EQ(rig.rig.step(rig.now + 30ms, 100ms), rt::StepStatus::ok);
  const auto* s = rig.rig.get<msg::SoccerSight>("sight");
  ASSERT_NE(s, nullptr);
  EXPECT_NEAR(s->x_m, -1, 1e-9);
  EXPECT_NEAR(s->y_m, 0.5, 1e-9);
  ASSERT_EQ(s->balls, 1u);
  EXPECT_LT(distance(s->ball[0].at, in_robot(p.robot, *p.ball)), 0.05);
}

/// Whatever pixels and poses come, a step ends, and numbers are within the message's limits.
TEST(FieldSight, SurvivesAnyPictureAndAnyPose) {
  math::Random random(5);
  FieldSight sight;
  msg::SoccerSight out;
  for (int i = 0; i < 60; ++i) {
    const std::uint32_t w = 2 * (1 + random.below(160)), h = 1 + random.below(240);
    msg::ImageBuffer image(msg::PixelFormat::yuyv, w, h);
    const std::uint32_t grain = 1 + random.below(200);
    std::uint32_t value = 0;
    for (std::uint32_t k = 0; k < w * h * 2; ++k) {
      if (k % grain == 0) value = random.next_u32();
      image->pixels()[k] = static_cast<std::uint8_t>(value >> (k % 4 * 8));
    }
    Painting p{.look_down_rad = random.uniform(-1.5, 1.5), .width = w, .height = h};
    p.camera_high_m = i % 10 == 9 ? math::kNan : random.uniform(0, 1.2);
    msg::CameraPose pose = p.pose();
    if (i % 7 == 6) pose.q_world_optical.w = math::kInf;
    const GroundView view(p.camera(), pose, p.robot, {});
    sight.look(vision::view(*image), view, out);
    EXPECT_LE(out.lines, out.line.size());
    EXPECT_LE(out.balls, out.ball.size());
    EXPECT_LE(out.marks, out.mark.size());
    for (std::uint32_t k = 0; k < out.balls; ++k) EXPECT_TRUE(math::is_finite(out.ball[k].at.x_m));
  }
}

TEST(FieldSight, WhatItSawBeforeOnlyChangesTheCarpet) {
  const Painting p{.ball = FieldPoint{0.3, 0.1}};
  const msg::ImageBuffer image = p.paint(), other = Painting{.robot = {2, 1, 1}, .light = 0.6}.paint();
  FieldSight fresh, used;
  msg::SoccerSight a, b;
  used.look(vision::view(*other), p.view(), b);
  ASSERT_TRUE(fresh.look(vision::view(*image), p.view(), a));
  b = {};
  ASSERT_TRUE(used.look(vision::view(*image), p.view(), b));
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

}  // namespace
}  // namespace sinew::soccer::sight_test
