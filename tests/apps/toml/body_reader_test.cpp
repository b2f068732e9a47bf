// Bodies from files.
#include "apps/toml/body_reader.hpp"

#include <gtest/gtest.h>

#include "kinematics/leg.hpp"
#include "kinematics/limbs.hpp"
#include "math/random.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::app::body_reader_test {
namespace {

using kinematics::Body;
using kinematics::BodyPose;

LoadedBody of_kid(const char* name) { return load_body(test::source_dir() + "/robots/kid/" + name + ".toml"); }

std::string all(const LoadedBody& loaded) {
  std::string text;
  for (const auto& p : loaded.problems) text += rt::to_string(p, "body.toml") + "\n";
  return text;
}

std::string said_of(const std::string& links) {
  return all(parse_body(
      "name = \"x\"\n[[servo]]\nname = \"s\"\nstall_nm = 1\nno_load_radps = 5\n[[link]]\nname = \"torso\"\n" + links,
      "body.toml"));
}

class BodyOfKid : public ::testing::TestWithParam<const char*> {};

TEST_P(BodyOfKid, IsReadAndItsRightSideIsTheMirrorImageOfTheLeft) {
  const LoadedBody loaded = of_kid(GetParam());
  ASSERT_EQ(all(loaded), "");
  const Body& body = loaded.body;
  EXPECT_GE(body.joints(), 20u);
  EXPECT_LE(body.joints(), 22u);
  EXPECT_GT(body.mass_kg(), 3);
  EXPECT_LT(body.mass_kg(), 6);
  math::Random random(1);
  BodyPose pose(body);
  std::vector<double> rad(body.joints());
  for (std::size_t i = 1; i < body.links.size(); ++i)
    if (!body.links[i].name.starts_with("r_"))
      rad[i - 1] = random.uniform(body.links[i].least_rad, body.links[i].most_rad);
  const auto mirrored = [&](std::size_t i) { return *body.find_link("r_" + body.links[i].name.substr(2)); };
  for (std::size_t i = 1; i < body.links.size(); ++i)
    if (body.links[i].name.starts_with("l_")) {
      rad[mirrored(i) - 1] = rad[i - 1];
    } else if (!body.links[i].name.starts_with("r_")) {
      rad[i - 1] = 0;
    }
  pose.set(rad);
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    if (!body.links[i].name.starts_with("l_")) continue;
    const math::Vec3 l = pose.link(i).of(body.links[i].com_m),
                     r = pose.link(mirrored(i)).of(body.links[mirrored(i)].com_m);
    EXPECT_LT(norm(math::Vec3{l.x, -l.y, l.z} - r), 1e-12) << body.links[i].name;
  }
}

TEST_P(BodyOfKid, ItsLegsAreSolvedAndItStandsOnItsSoles) {
  const LoadedBody loaded = of_kid(GetParam());
  const Body& body = loaded.body;
  for (const char* side : {"l_", "r_"}) {
    const std::size_t foot = body.find_place(std::string(side) + "sole")->link;
    std::string why;
    const auto leg = kinematics::Leg::make(body, foot, why);
    ASSERT_TRUE(leg) << why;
    math::Random random(2);
    BodyPose pose(body);
    int reached = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      std::vector<double> rad(body.joints());
      for (const std::size_t link : leg->links()) {
        const auto& l = body.links[link];
        rad[link - 1] = random.uniform(l.least_rad, l.most_rad);
      }
      auto& knee = rad[leg->links()[3] - 1];
      knee = std::abs(knee);  // to the front: not solved
      pose.set(rad);
      const kinematics::Pose wanted = pose.link(foot);
      const auto found = leg->solve(wanted);
      reached += found.reached ? 1 : 0;
      for (std::size_t j = 0; j < kinematics::kLegJoints; ++j) rad[leg->links()[j] - 1] = found.rad[j];
      pose.set(rad);
      if (found.reached) {
        EXPECT_LT(norm(pose.link(foot).p_m - wanted.p_m), 1e-6);
      }
    }
    EXPECT_GT(reached, 990);  // the others fold the leg so far that the hip is below the sole
  }
  BodyPose pose(body);
  const double sole_z = pose.place(*body.find_place("l_sole")).p_m.z;
  EXPECT_NEAR(sole_z, pose.place(*body.find_place("r_sole")).p_m.z, 1e-12);
  for (std::size_t i = 0; i < body.links.size(); ++i) {
    for (const auto& shape : body.links[i].shapes) {
      if (shape.kind != kinematics::Shape::Kind::box) continue;
      EXPECT_GE(pose.link(i).of(shape.at_m).z - shape.size_m.z / 2, sole_z - 1e-9) << body.links[i].name;
    }
  }
}

TEST_P(BodyOfKid, JointsBelongToTheLimbsThatTheyMove) {
  const Body body = of_kid(GetParam()).body;
  const auto limbs = kinematics::Limbs::of(body);
  std::size_t joints = 0;
  for (std::size_t limb = 0; limb < kinematics::kLimbs; ++limb) {
    const std::string name(to_string(static_cast<kinematics::Limb>(limb)));
    for (const std::size_t joint : limbs.joints[limb]) {
      const std::string& link = body.links[joint + 1].name;
      EXPECT_EQ(link.substr(0, 2), name == "head" ? "he" : name.substr(0, 1) + "_") << name;
      EXPECT_EQ(link.find("shoulder") != link.npos || link.find("elbow") != link.npos, name.ends_with("arm")) << link;
      ++joints;
    }
  }
  EXPECT_EQ(joints, body.joints());
  EXPECT_EQ(limbs.of(kinematics::Limb::left_leg).size(), 6u);
  EXPECT_EQ(body.links[limbs.of(kinematics::Limb::left_leg).back() + 1].name, "l_ankle_roll");
}

INSTANTIATE_TEST_SUITE_P(Bodies, BodyOfKid, ::testing::Values("op3", "nao"));

TEST(BodyFile, ProblemsComeWithLineKeyAndWhatIsAllowed) {
  EXPECT_EQ(said_of(""), "");
  EXPECT_EQ(all(load_body("/nowhere.toml")), "body.toml: file: /nowhere.toml: a file of a body that can be read\n");
  EXPECT_EQ(all(parse_body("name = ", "body.toml")).substr(0, 17), "body.toml:1: TOML");
  EXPECT_EQ(said_of("[[link]]\nname = \"a\"\nparent = \"b\"\naxis = [0, 0, 1]\nrange_deg = [-1, 1]\nservo = \"s\"\n"),
            "body.toml:8: link.a.parent: \"b\": the name of a link that stands before it\n");
  EXPECT_EQ(
      said_of("[[link]]\nname = \"a\"\nparent = \"torso\"\naxis = [0, 0, 0]\nrange_deg = [1, -1]\nservo = \"t\"\n"),
      "body.toml:8: link.a.axis: \"[0, 0, 0]\": a direction\n"
      "body.toml:8: link.a.range_deg: \"\": the lesser angle first\n"
      "body.toml:8: link.a.servo: \"t\": the name of a [[servo]]\n");
  EXPECT_NE(said_of("[[link]]\nname = \"a\"\nparent = \"torso\"\n").find("its joint"), std::string::npos);
  EXPECT_NE(said_of("[[link]]\nname = \"a\"\nparent = \"torso\"\naxis = [0, 0, 1]\nrange_deg = [0, 1]\nservo = "
                    "\"s\"\nmirror = true\n")
                .find("begins with \"l_\""),
            std::string::npos);
  EXPECT_NE(said_of("[[place]]\nname = \"p\"\nlink = \"q\"\n").find("place.p.link: \"q\": the name of a link"),
            std::string::npos);
  EXPECT_NE(said_of("[[link.shape]]\nkind = \"cone\"\n").find("one of"), std::string::npos);
  EXPECT_NE(said_of("weight_kg = 3\n").find("weight_kg"), std::string::npos);
}

}  // namespace
}  // namespace sinew::app::body_reader_test
