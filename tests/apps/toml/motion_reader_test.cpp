// Motions from files.
#include "apps/toml/motion_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "apps/toml/body_reader.hpp"

namespace sinew::test {
std::string source_dir();
}

namespace sinew::app::motion_reader_test {
namespace {

namespace fs = std::filesystem;

const std::string kKid = test::source_dir() + "/robots/kid/";

/// What is said of a file in `folder_`, beside a link to op3_motion.toml.
class MotionFile : public ::testing::Test {
 protected:
  MotionFile() : body_(load_body(kKid + "op3.toml").body) {
    folder_ = fs::temp_directory_path() /
              ("sinew_motion_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
    fs::copy_file(kKid + "op3_motion.toml", folder_ / "op3_motion.toml", fs::copy_options::overwrite_existing);
  }
  ~MotionFile() override { fs::remove_all(folder_); }

  LoadedMotions load(const std::string& text) {
    std::ofstream(folder_ / "mine.toml", std::ios::binary) << text;
    return load_motions((folder_ / "mine.toml").string(), body_);
  }
  std::string said_of(const std::string& text) {
    std::string all;
    for (const rt::Problem& p : load(text).problems) all += rt::to_string(p, "mine.toml") + "\n";
    return all;
  }

  kinematics::Body body_;
  fs::path folder_;
};

TEST_F(MotionFile, IsAnotherOneWithWhatItSaysOverIt) {
  const LoadedMotions mine = load("extends = \"op3_motion.toml\"\n[walk]\nperiod_s = 0.25\nmost_forward_mps = 0.42\n");
  EXPECT_THAT(mine.problems, ::testing::IsEmpty());
  EXPECT_EQ(mine.book.walk.period_s, 0.25);
  motion::MotionBook op3 = load_motions(kKid + "op3_motion.toml", body_).book;
  EXPECT_NE(motions_text(mine.book, body_, ""), motions_text(op3, body_, ""));
  op3.walk.period_s = 0.25, op3.walk.most_forward_mps = 0.42;
  EXPECT_EQ(motions_text(mine.book, body_, ""), motions_text(op3, body_, "")) << "nothing else differs";
}

TEST_F(MotionFile, ProblemsComeWithTheLineOfTheFile) {
  EXPECT_THAT(said_of("extends = \"op3_motion.toml\"\n\n[walk]\nperiod_s = -1\n"),
              ::testing::StartsWith("mine.toml:4: walk.period_s: -1: "));
  EXPECT_EQ(
      said_of("# mine\nextends = \"nowhere.toml\"\n"),
      "mine.toml:2: extends: \"nowhere.toml\": a file that can be read: " + (folder_ / "nowhere.toml").string() + "\n");
  EXPECT_EQ(said_of("extends = \"mine.toml\"\n"),
            "mine.toml:1: extends: \"mine.toml\": a file that does not extend this one: they go in a circle\n");
  EXPECT_THAT(said_of("extends = \n"), ::testing::StartsWith("mine.toml:1: TOML"));
}

TEST(MotionsOfTheFastKid, AreThoseOfTheKidButForTheWalk) {
  const LoadedBody fast = load_body(kKid + "op3_58.toml"), kid = load_body(kKid + "op3.toml");
  ASSERT_THAT(fast.problems, ::testing::IsEmpty());
  EXPECT_EQ(fast.body.joints(), kid.body.joints());
  for (const auto& servo : fast.body.servos) EXPECT_EQ(servo.no_load_radps, 5.8);
  LoadedMotions of_fast = load_motions(kKid + "op3_58_motion.toml", fast.body);
  ASSERT_THAT(of_fast.problems, ::testing::IsEmpty());
  const motion::MotionBook of_kid = load_motions(kKid + "op3_motion.toml", kid.body).book;
  EXPECT_GT(of_fast.book.walk.most_forward_mps, of_kid.walk.most_forward_mps);
  of_fast.book.walk = of_kid.walk;
  EXPECT_EQ(motions_text(of_fast.book, fast.body, ""), motions_text(of_kid, kid.body, ""));
}

}  // namespace
}  // namespace sinew::app::motion_reader_test
