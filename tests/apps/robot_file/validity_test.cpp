// Each bound of a run's validity, from both sides.
#include "apps/robot_file/validity.hpp"

#include <gmock/gmock.h>

#include "apps/robot_file/robot_file.hpp"

namespace sinew::app::validity_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

/// A run that no bound has anything against.
RunEvidence good_run() {
  RunEvidence run;
  run.real_time = true;
  run.plant.valid = true;
  run.plant.imu_gap_max_s = 0.0015;
  run.plant.frames = 1000;
  run.releases = 100'000;
  run.board.devices.resize(3);
  auto& imu = run.board.devices[0];
  imu.name = "imu", imu.samples = 30'000, imu.max_gap_stamp = 1ms, imu.max_gap_arrival = 4ms;
  run.board.devices[1].name = "camera", run.board.devices[1].kind = sim_hil::DeviceKind::camera;
  run.board.devices[1].samples = 900;
  run.board.devices[2].name = "motors", run.board.devices[2].kind = sim_hil::DeviceKind::actuators;
  run.board.remote = true;
  run.board.clock.followed = true, run.board.clock.exchanges = 150;
  run.board.clock.worst_bound = 300us, run.board.clock.drift = 20e-6;
  return run;
}

TEST(Validity, GoodRunIsValidAndEveryBoundWasLookedAt) {
  const auto findings = examine(good_run(), {});
  EXPECT_THAT(invalid_because(findings), IsEmpty());
  EXPECT_GE(findings.size(), 9u);
}

struct Case {
  const char* name;
  void (*within)(RunEvidence&);  // just inside the default bound
  void (*beyond)(RunEvidence&);
  const char* reason;
};
void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

class Bound : public testing::TestWithParam<Case> {};

TEST_P(Bound, HoldsJustInsideAndSaysWhyBeyond) {
  RunEvidence run = good_run();
  GetParam().within(run);
  EXPECT_THAT(invalid_because(examine(run, {})), IsEmpty());
  GetParam().beyond(run);
  EXPECT_THAT(invalid_because(examine(run, {})), ElementsAre(GetParam().reason));
}

INSTANTIATE_TEST_SUITE_P(
    Default, Bound,
    testing::Values(Case{"plant_gap", [](RunEvidence& r) { r.plant.imu_gap_max_s = 0.002; },
                         [](RunEvidence& r) { r.plant.imu_gap_max_s = 0.0025; },
                         "plant: 2.50 ms between two IMU samples leaving; the bound is plant_gap_ms = 2"},
                    Case{"plant_gap_in_robot_time", [](RunEvidence& r) { r.rate = 0.5, r.plant.imu_gap_max_s = 0.004; },
                         [](RunEvidence& r) { r.plant.imu_gap_max_s = 0.005; },
                         "plant: 2.50 ms between two IMU samples leaving; the bound is plant_gap_ms = 2"},
                    Case{"arrival_gap", [](RunEvidence& r) { r.board.devices[0].max_gap_arrival = 11ms; },
                         [](RunEvidence& r) { r.board.devices[0].max_gap_arrival = 12ms; },
                         "imu: 12.00 ms between two arrivals, 1.00 ms between their stamps at most; the bound is "
                         "arrival_gap_ms = 10"},
                    Case{"late", [](RunEvidence& r) { r.board.devices[0].late = 30; },
                         [](RunEvidence& r) { r.board.devices[0].late = 60; },
                         "imu: 0.20 % of 30000 samples came late; the bound is late_percent = 0.1"},
                    Case{"lost", [](RunEvidence&) {}, [](RunEvidence& r) { r.board.devices[1].lost = 2; },
                         "camera: 2 samples lost, 0 overwritten; the bound is lost = 0"},
                    Case{"frames_late", [](RunEvidence& r) { r.plant.render_late = 10; },
                         [](RunEvidence& r) { r.plant.render_late = 1000; },
                         "plant: 50.0 % of its frames late or left out; the bound is frames_late_percent = 1"},
                    Case{"commands_dropped", [](RunEvidence&) {}, [](RunEvidence& r) { r.board.commands_dropped = 3; },
                         "3 commands that the plant did not take in time; the bound is commands_dropped = 0"},
                    Case{"missed", [](RunEvidence& r) { r.missed = 100; }, [](RunEvidence& r) { r.missed = 200; },
                         "200 missed deadlines, 0.200 % of all releases; the bound is missed_percent = 0.1"},
                    Case{"clock", [](RunEvidence& r) { r.board.clock.worst_bound = 2ms; },
                         [](RunEvidence& r) { r.board.clock.worst_bound = 3ms; },
                         "clock of the plant known to 3.000 ms by 150 exchanges; the bound is clock_ms = 2"},
                    Case{"clock_not_followed", [](RunEvidence& r) { r.board.clock.worst_bound = 2ms; },
                         [](RunEvidence& r) { r.board.clock.worst_bound = 9ms, r.board.clock.followed = false; },
                         "clock of the plant known to 9.000 ms, not followed: no side line; the bound is clock_ms = 2"},
                    Case{"drift", [](RunEvidence& r) { r.board.clock.drift = -200e-6; },
                         [](RunEvidence& r) { r.board.clock.drift = -300e-6; },
                         "clock of the plant drifts by -300.0 ppm; the bound is drift_ppm = 200"},
                    Case{"clock_jumped", [](RunEvidence&) {}, [](RunEvidence& r) { r.board.clock.restarts = 1; },
                         "clock of the plant jumped 1 times; the bound is clock_ms = 0"},
                    Case{"link_down",
                         [](RunEvidence& r) {
                           r.board.outages.push_back({{}, 100ms, "closed"});
                         },
                         [](RunEvidence& r) {
                           r.board.outages.push_back({{}, 4s, "peer closed the connection"});
                         },
                         "without a plant for 4000 ms: peer closed the connection; the bound is link_down_ms = 100"},
                    Case{"plants_word", [](RunEvidence&) {},
                         [](RunEvidence& r) { r.plant.valid = false, r.plant.reason = "too hot"; },
                         "the plant says: too hot"}),
    [](const auto& c) { return c.param.name; });

TEST(Validity, LongestImuGapIsInTheTimeOfTheRobot) {
  RunEvidence run = good_run();
  run.rate = 0.25, run.plant.imu_gap_max_s = 0.004;
  EXPECT_DOUBLE_EQ(imu_gap_max_s(run), 0.001);
}

TEST(Validity, InVirtualTimeOnlyWhatWasLostOrBrokenCounts) {
  RunEvidence run = good_run();
  run.real_time = false;
  run.plant.imu_gap_max_s = 1, run.missed = 1000, run.board.devices[0].max_gap_arrival = 1s;
  EXPECT_THAT(invalid_because(examine(run, {})), IsEmpty());
  run.board.devices[0].late = 1;
  EXPECT_THAT(invalid_because(examine(run, {})),
              ElementsAre("imu: 1 samples after their grant; the bound is late_percent = 0"));
}

TEST(Validity, WhatAFaultyDeviceLostWasAskedFor) {
  RunEvidence run = good_run();
  run.plant.faults.push_back({"imu:off@1", "imu", 7});
  run.board.devices[0].lost = 5, run.board.devices[0].max_gap_arrival = 1s;
  EXPECT_THAT(invalid_because(examine(run, {})), IsEmpty());
  run.board.devices[1].lost = 1;
  EXPECT_THAT(invalid_because(examine(run, {})),
              ElementsAre("camera: 1 samples lost, 0 overwritten; the bound is lost = 0"));
}

TEST(Validity, RobotFileSetsTheBounds) {
  const auto loaded = parse_robot(R"(robot = { name = "x", board = "sim" }
[sim]
relink_s = 3
[sim.bounds]
plant_gap_ms = 5
lost = 7
clock_ms = 25
drift_ppm = 2000
colour = 1
)",
                                  "x.toml");
  EXPECT_EQ(loaded.robot.sim.relink_s, 3);
  const ValidityBounds& b = loaded.robot.sim.bounds;
  EXPECT_EQ(b.plant_gap_ms, 5);
  EXPECT_EQ(b.lost, 7);
  EXPECT_EQ(b.clock_ms, 25);
  EXPECT_EQ(b.missed_percent, ValidityBounds{}.missed_percent) << "the others keep their defaults";
  ASSERT_EQ(loaded.problems.size(), 2u);
  EXPECT_EQ(rt::to_string(loaded.problems[0], "x.toml"),
            "x.toml:8: sim.bounds.drift_ppm: 2000: a number from 0 to 1000");
}

}  // namespace
}  // namespace sinew::app::validity_test
