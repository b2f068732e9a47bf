// The numbers that sinew-gait searches for.
#include "apps/gait/search.hpp"

#include <algorithm>

#include "apps/gait/down_trial.hpp"
#include "op3.hpp"

namespace sinew::gait {
namespace {

constexpr double kDegree = math::kPi / 180;

GaitSetup op3_setup() {
  const motion::Op3 op3;
  return {.body = op3.body, .book = op3.book};
}

const Searched* find(const std::vector<Searched>& numbers, const std::string& name) {
  const auto found = std::ranges::find(numbers, name, &Searched::name);
  return found == numbers.end() ? nullptr : &*found;
}

TEST(MotionSearch, NumbersOfAMotionAreItsDurationsAndTheAnglesThatItsPosesMove) {
  const GaitSetup setup = op3_setup();
  std::string why;
  const auto numbers = numbers_of_motion(setup, "rise_front", {"push up", "lean back"}, 40, why);
  ASSERT_EQ(why, "");
  EXPECT_EQ(numbers.size(), 2u + 8u) << "both move shoulder, hip, knee and ankle";
  const Searched* hip = find(numbers, "push up/hip_pitch");
  ASSERT_TRUE(hip) << "one for both sides";
  EXPECT_NEAR(hip->most, -60, 1e-9);
  EXPECT_NEAR(find(numbers, "push up/duration_s")->most, 1.2, 1e-9);
  for (const Searched& s : numbers) EXPECT_LT(s.least, s.most) << s.name;
  EXPECT_TRUE(numbers_of_motion(setup, "rise_front", {"jump"}, 40, why).empty());
  EXPECT_EQ(why, "rise_front has no pose \"jump\"");
}

TEST(MotionSearch, ASampleSetsBothSidesAndLaterPosesThatKeptTheAngle) {
  const GaitSetup setup = op3_setup();
  SearchOptions o;
  o.motion = "rise_front";
  std::string why;
  o.numbers = parse_searched(setup, o, "turn arms/shoulder_pitch:-170:-100,push up/duration_s:0.2:1", why);
  ASSERT_EQ(why, "");
  ASSERT_EQ(o.numbers.size(), 2u);
  const std::vector<double> start = start_of(setup, o);
  EXPECT_NEAR(start[0], 1.0 / 7, 1e-12);
  EXPECT_NEAR(start[1], 0.5, 1e-12);
  const GaitSetup same = setups_of(setup, o, {start}).front(), other = setups_of(setup, o, {{1, 0}}).front();
  const auto &poses = *other.book.find("rise_front"), &before = *setup.book.find("rise_front");
  for (const char* joint : {"l_shoulder_pitch", "r_shoulder_pitch"}) {
    const std::size_t j = *setup.body.find_link(joint) - 1;
    EXPECT_NEAR((*same.book.find("rise_front"))[1].rad[j], before[1].rad[j], 1e-12);
    EXPECT_EQ(poses[0].rad[j], before[0].rad[j]);
    EXPECT_NEAR(poses[1].rad[j], -100 * kDegree, 1e-12);
    EXPECT_NEAR(poses[2].rad[j], -100 * kDegree, 1e-12) << "\"arms ahead\" leaves it as it was";
    EXPECT_EQ(poses[3].rad[j], before[3].rad[j]);
  }
  EXPECT_NEAR(poses[3].duration_s, 0.2, 1e-12);
}

TEST(MotionSearch, AWrongNumberIsNamed) {
  const GaitSetup setup = op3_setup();
  std::string why;
  EXPECT_TRUE(parse_searched(setup, {.motion = "rise_front"}, "push up/wing:-1:1", why).empty());
  EXPECT_EQ(why, "push up/wing: rise_front has no number of this name");
  EXPECT_TRUE(parse_searched(setup, {.motion = "rise_front"}, "push up/knee:0:500", why).empty());
  EXPECT_NE(why.find("LEAST < MOST <="), std::string::npos) << why;
  EXPECT_TRUE(parse_searched(setup, {}, "push up/knee:0:50", why).empty());
  EXPECT_EQ(why, "push up/knee: the walk has no number of this name");
  const SearchFor kick{.kick = motion::KickWay::outward};
  EXPECT_TRUE(parse_searched(setup, kick, "period_s:0.2:0.3", why).empty());
  EXPECT_EQ(why, "period_s: the kick has no number of this name");
}

TEST(MotionSearch, EachKickHasNumbersOfItsOwn) {
  const GaitSetup setup = op3_setup();
  SearchOptions o;
  o.kick = motion::KickWay::outward;
  std::string why;
  o.numbers = parse_searched(setup, o, "strike_m:0.05:0.15", why);
  ASSERT_EQ(why, "");
  const GaitSetup other = setups_of(setup, o, {{1}}).front();
  EXPECT_EQ(other.book.kick_outward.strike_m, 0.15);
  EXPECT_EQ(other.book.kick_forward.strike_m, setup.book.kick_forward.strike_m);
  o.within_step = true;
  o.numbers = standard_numbers(o);
  EXPECT_EQ(start_of(setup, o).size(), o.numbers.size());
  EXPECT_TRUE(parse_searched(setup, o, "shift_s:0.2:0.3", why).empty()) << "within a step it has others";
}

TEST(MotionSearch, AKickThatMissesOrFallsCostsMoreThanASlowOne) {
  GaitSetup setup = op3_setup();
  SearchOptions o;
  o.kick = motion::KickWay::forward;
  o.runs = 2;
  std::string why;
  const double good = cost_of(setup, o, 0, why);
  setup.book.kick_forward.strike_s = 1;
  const double slow = cost_of(setup, o, 0, why);
  setup.book.kick_forward.strike_m = 0.02;
  setup.book.kick_forward.back_m = 0.1;
  const double missed = cost_of(setup, o, 0, why);
  EXPECT_EQ(why, "");
  EXPECT_LT(good, 0.5);
  EXPECT_GT(slow, good + 0.1);
  EXPECT_GE(missed, 1) << "or it falls";
}

TEST(MotionSearch, GettingDownIsGentleAndFallingOverCostsMore) {
  GaitSetup setup = op3_setup();
  std::string why;
  const auto r = run_down(setup, 900'061, why);
  ASSERT_TRUE(r) << why;
  EXPECT_TRUE(r->lies);
  EXPECT_TRUE(r->gently);
  EXPECT_LT(r->blow_mps2, 80);
  SearchOptions o;
  o.motion = kGetDown;
  o.runs = 1;
  const double gentle = cost_of(setup, o, 0, why);
  auto& poses = setup.book.poses[kGetDown];
  poses.resize(1);
  for (const char* joint : {"l_ankle_pitch", "r_ankle_pitch"})
    poses[0].rad[*setup.body.find_link(joint) - 1] = 0.5;  // onto its toes
  EXPECT_GT(cost_of(setup, o, 0, why), gentle + 0.25);
}

}  // namespace
}  // namespace sinew::gait
