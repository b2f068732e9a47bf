#include "sim_hil/places/place.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::plant::place_test {
namespace {

using math::Quat;
using math::Vec3;

/// Flat ground with a wall at x = 3, a ramp of 12 degrees at y = 3 from x = 1 on, and an edge of 0.12 m at y = -3.
PlaceMap ground() {
  PlaceMap map;
  map.name = "Test";
  map.solids.push_back({Shape::plane, {}, {}, {}});
  map.solids.push_back({Shape::box, {3.5, 0, 1}, {}, {0.5, 1.2, 1}});
  const double tilt = 12 * math::kPi / 180;
  map.solids.push_back({Shape::box,
                        {1 + 2 * std::cos(tilt) + 0.1 * std::sin(tilt), 3, 2 * std::sin(tilt) - 0.1 * std::cos(tilt)},
                        Quat::from_axis_angle({0, 1, 0}, -tilt),
                        {2, 0.8, 0.1}});
  map.solids.push_back({Shape::box, {3, -3, 0.06}, {}, {1, 0.8, 0.06}});
  map.starts = {{"Pose1", {0, 0, 0}, 0}};
  map.target_way = {{10, 10, 0.25}, {12, 10, 0.25}};
  return map;
}

Vehicle& put(Place& place, const VehicleKind& kind, double x, double y, double yaw = 0) {
  const auto slot = place.enter(kind, {{x, y, kind.rest_m}, yaw}, {1, false, 1});
  EXPECT_TRUE(slot);
  return *place.vehicle(*slot);
}

void wait(Place& place, double seconds) {
  for (int i = 0; i < seconds * 1e9 / kStepNs; ++i) place.advance({});
}

TEST(Solid, ClearancesAndBeamsOfEachShapeAgreeWithGeometry) {
  const Quat turned = Quat::from_axis_angle({0, 0, 1}, math::kPi / 2);
  const Solid box{Shape::box, {1, 2, 3}, turned, {0.5, 1, 2}};  // turned: 1 in x, 0.5 in y
  EXPECT_NEAR(clearance(box, {3, 2, 3}).distance_m, 1, 1e-12);
  EXPECT_NEAR(clearance(box, {1, 3, 3}).distance_m, 0.5, 1e-12);
  EXPECT_NEAR(clearance(box, {1, 2, 3}).distance_m, -0.5, 1e-12) << "inside: the nearest face";
  EXPECT_NEAR(clearance(box, {1, 3, 3}).out.y, 1, 1e-12);
  Hit hit{10, {}};
  EXPECT_TRUE(meets(box, {5, 2, 3}, {-1, 0, 0}, hit));
  EXPECT_NEAR(hit.range_m, 3, 1e-12);
  EXPECT_NEAR(hit.normal.x, 1, 1e-12);
  hit = {2.9, {}};
  EXPECT_FALSE(meets(box, {5, 2, 3}, {-1, 0, 0}, hit)) << "it ends before the box";
  const Solid column{Shape::cylinder, {0, 0, 1}, {}, {0.5, 0, 1}};
  EXPECT_NEAR(clearance(column, {2, 0, 1}).distance_m, 1.5, 1e-12);
  EXPECT_NEAR(clearance(column, {0, 0, 3}).distance_m, 1, 1e-12);
  EXPECT_NEAR(clearance(column, {3.5, 0, 6}).distance_m, 5, 1e-12) << "from its edge";
  hit = {10, {}};
  EXPECT_TRUE(meets(column, {0, 0, 5}, {0, 0, -1}, hit));
  EXPECT_NEAR(hit.range_m, 3, 1e-12);
  hit = {10, {}};
  EXPECT_TRUE(meets(column, {-4, 0.3, 1}, {1, 0, 0}, hit));
  EXPECT_NEAR(hit.range_m, 4 - 0.4, 1e-12);
  hit = {10, {}};
  EXPECT_FALSE(meets(column, {-4, 0.6, 1}, {1, 0, 0}, hit));
  const Solid ball{Shape::sphere, {0, 0, 0}, {}, {1, 0, 0}};
  hit = {10, {}};
  EXPECT_TRUE(meets(ball, {0, 0.6, 5}, {0, 0, -1}, hit));
  EXPECT_NEAR(hit.range_m, 5 - 0.8, 1e-12);
  const Solid floor{Shape::plane, {}, {}, {}};
  hit = {10, {}};
  EXPECT_FALSE(meets(floor, {0, 0, 1}, {1, 0, 0}, hit));
}

TEST(Place, AnAirRobotFollowsVelocitiesInTheAxesOfItsHeadingAndHovers) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0, math::kPi / 2);
  EXPECT_FALSE(v.body().touches);
  v.drive({{{0, 0, 1}, 0}, 0, 0});
  wait(place, 2);
  EXPECT_NEAR(v.body().p_world_m.z, kAirRobot.rest_m + 2 - kAirRobot.lag_s, 0.05);
  v.drive({{{-0.5, 0.25, 0}, 0}, 0, 0});  // backwards and to the left of a vehicle that looks along y
  wait(place, 2);
  EXPECT_NEAR(v.body().v_world_mps.y, -0.5, 0.01);
  EXPECT_NEAR(v.body().v_world_mps.x, -0.25, 0.01);
  v.drive({});
  wait(place, 2);
  const Vec3 there = v.body().p_world_m;
  wait(place, 2);
  EXPECT_NEAR(math::norm(v.body().p_world_m - there), 0, 0.001) << "it hovers";
  v.drive({{{}, 0.5}, 0, 0});
  wait(place, 2);
  EXPECT_NEAR(v.body().angles_rad.yaw, math::kPi / 2 + 0.5 * (2 - kAirRobot.lag_s), 0.01) << "to the left";
}

TEST(Place, WhereAVehicleHasLeftOrAThingWasRemovedThereIsRoomAtOnce) {
  Place place(ground(), {});
  const VehicleKind& kind = kAirRobot;
  const Vehicle& first = put(place, kind, 0, 0);
  EXPECT_FALSE(place.enter(kind, {{0, 0, kind.rest_m}, 0}, {1, false, 1}));
  place.leave(first.slot());
  const auto again = place.enter(kind, {{0, 0, kind.rest_m}, 0}, {1, false, 1});
  ASSERT_TRUE(again);
  place.leave(*again);
  ASSERT_TRUE(place.create(0, "crate", {{0, 0, kind.rest_m}, {}}));
  EXPECT_FALSE(place.enter(kind, {{0, 0, kind.rest_m}, 0}, {1, false, 1}));
  EXPECT_TRUE(place.remove("crate"));
  EXPECT_TRUE(place.enter(kind, {{0, 0, kind.rest_m}, 0}, {1, false, 1}));
}

TEST(Place, AnAirRobotLeansIntoItsAccelerationAndItsImuFeelsIt) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, -20, 0);
  v.drive({{{0, 0, 1}, 0}, 0, 0});
  wait(place, 2);
  v.drive({{{2, 0, 0}, 0}, 0, 0});
  wait(place, 0.15);
  EXPECT_GT(v.body().angles_rad.pitch, 0.1) << "nose down";
  EXPECT_GT(v.due().imu_sample.gyro_radps.y, 0.5);
  wait(place, 4);
  EXPECT_NEAR(v.body().angles_rad.pitch, std::atan(2 * kAirRobot.drag_per_s / kGravity), 0.005) << "against the drag";
  const msg::Vec3& f = v.due().imu_sample.accel_mps2;
  EXPECT_NEAR(std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z), kGravity, 0.02);
  EXPECT_LT(f.x, 0) << "gravity, in the axes of a nose that looks down: +g upward";
}

TEST(Place, AnAirRobotLandsStandsAndTakesOffAgain) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  wait(place, 0.1);
  EXPECT_TRUE(v.body().stands);
  v.drive({{{1, 0, 0}, 1}, 0, 0});
  wait(place, 1);
  EXPECT_NEAR(v.body().p_world_m.x, 0, 0.001) << "no way on the ground";
  v.drive({{{0, 0, 0.5}, 0}, 0, 0});
  wait(place, 1);
  EXPECT_FALSE(v.body().stands);
  v.drive({{{0, 0, -0.4}, 0}, 0, 0});
  wait(place, 3);
  EXPECT_TRUE(v.body().stands);
  EXPECT_NEAR(v.body().p_world_m.z, kAirRobot.rest_m, 0.003);
  EXPECT_EQ(v.touches(), 0u) << "the ground is no obstacle";
}

TEST(Place, AWallStopsAnAirRobotAndIsTold) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  v.drive({{{0, 0, 1}, 0}, 0, 0});
  wait(place, 1);
  v.drive({{{3, 0, 0}, 0}, 0, 0});
  wait(place, 3);
  EXPECT_NEAR(v.body().p_world_m.x, 3 - kAirRobot.hull_radius_m, 0.01);
  EXPECT_TRUE(v.body().touches);
  EXPECT_EQ(v.touches(), 1u);
  EXPECT_FALSE(v.verdict().good);
}

TEST(Place, AnEmptyBatteryLandsAnAirRobotAndStopsWheels) {
  Place place(ground(), {});
  const auto slot = place.enter(kAirRobot, {{0, 0, 2}, 0}, {1, false, 1.0 / kAirRobot.battery_s});
  ASSERT_TRUE(slot);
  const auto other = place.enter(kP3at, {{-5, 0, kP3at.rest_m}, 0}, {1, false, 1.0 / kP3at.battery_s});
  ASSERT_TRUE(other);
  Vehicle &air = *place.vehicle(*slot), &wheels = *place.vehicle(*other);
  air.drive({{{0, 0, 0.5}, 0}, 0, 0});
  wheels.drive({{}, 5, 5});
  wait(place, 5);
  EXPECT_TRUE(air.body().stands);
  EXPECT_EQ(air.battery_s(), 0);
  EXPECT_LT(wheels.body().p_world_m.x, -4);
}

TEST(Place, WheelsRollAsFastAsTheyTurnAndSkidRound) {
  Place place(ground(), {});
  Vehicle& v = put(place, kP3at, -5, 0);
  v.drive({{}, 4, 4});
  wait(place, 3);
  EXPECT_NEAR(v.body().p_world_m.x, -5 + 4 * 0.11 * (3 - kP3at.wheel_lag_s), 0.01);
  EXPECT_NEAR(v.wheels().left_rad(), 4 * (3 - kP3at.wheel_lag_s), 0.01);
  v.drive({{}, -2, 2});
  wait(place, 1);
  EXPECT_GT(v.body().angles_rad.yaw, 0) << "to the left";
  v.drive({});
  wait(place, 1);
  const double yaw = math::wrap_pi(0.11 * (v.wheels().right_rad() - v.wheels().left_rad()) / kP3at.track_m);
  EXPECT_NEAR(v.body().angles_rad.yaw, yaw, 1e-3);
}

VehicleCommand steer(double spin_radps, double front_rad, double rear_rad) {
  VehicleCommand command;
  command.steered = {spin_radps, front_rad, rear_rad};
  return command;
}

/// The circle's radius: of the middle of the axle that does not steer, wheelbase / tan(angle).
TEST(Place, SteeredWheelsRollOnTheCircleOfTheirAngle) {
  Place place(ground(), {});
  Vehicle& v = put(place, kFrontSteered, -4, -7);
  v.drive(steer(0, 0.3, 0));
  wait(place, 1);
  EXPECT_NEAR(v.wheels().front_steer_rad(), 0.3, 1e-9);
  v.drive(steer(4, 0.3, 0));
  wait(place, 6);
  const double rear_way = kFrontSteered.wheel_radius_m * (v.wheels().left_rad() + v.wheels().right_rad()) / 2;
  EXPECT_NEAR(v.body().angles_rad.yaw, rear_way * std::tan(0.3) / kFrontSteered.wheelbase_m, 0.01) << "to the left";
  const double half = kFrontSteered.wheelbase_m / 2, radius = kFrontSteered.wheelbase_m / std::tan(0.3);
  const double yaw = v.body().angles_rad.yaw;
  EXPECT_NEAR(v.body().p_world_m.x, -4 - half + radius * std::sin(yaw) + half * std::cos(yaw), 0.01);
  EXPECT_NEAR(v.body().p_world_m.y, -7 + radius * (1 - std::cos(yaw)) + half * std::sin(yaw), 0.01);
  EXPECT_GT(v.wheels().right_rad(), v.wheels().left_rad()) << "the outer wheels turn more";
}

TEST(Place, RearWheelsTurnedLeftSteerToTheRight) {
  Place place(ground(), {});
  Vehicle& v = put(place, kRearSteered, -4, 0);
  v.drive(steer(4, 0.5, 0.4));
  wait(place, 2);
  EXPECT_NEAR(v.wheels().rear_steer_rad(), 0.4, 1e-9);
  EXPECT_EQ(v.wheels().front_steer_rad(), 0) << "it has no wheels in front that steer";
  EXPECT_LT(v.body().angles_rad.yaw, -0.3);
}

TEST(Place, SteeringIsLimitedInAngleAndRateAndSpinInSpeed) {
  Place place(ground(), {});
  Vehicle& v = put(place, kFrontSteered, -4, 0);
  v.drive(steer(1e9, 1e9, 1e9));
  wait(place, 0.2);
  EXPECT_NEAR(v.wheels().front_steer_rad(), 0.2 * kFrontSteered.steer_radps, 1e-6);
  wait(place, 1);
  EXPECT_NEAR(v.wheels().front_steer_rad(), kFrontSteered.front_steer_rad, 1e-9);
  EXPECT_LE((v.wheels().left_radps() + v.wheels().right_radps()) / 2, kFrontSteered.wheel_radps);
  EXPECT_TRUE(math::is_finite(v.body().p_world_m));
}

TEST(Place, VehiclesThatSteerHaveTheirOwnPictures) {
  Place place(ground(), {});
  const Vehicle& v = put(place, kFrontSteered, -4, 0);
  const Scene scene = place.bodies(kMostRobots);
  EXPECT_NEAR(scene.body[SceneOrder::kSteered + v.slot()].p_world_m.x, -4, 1e-9);
  EXPECT_LT(scene.body[SceneOrder::kWheeled + v.slot()].p_world_m.z, -100) << "out of sight";
}

TEST(Place, WheelsClimbARampAndLeanWithIt) {
  Place place(ground(), {});
  Vehicle& v = put(place, kP3at, 0, 3);
  v.drive({{}, 5, 5});
  wait(place, 4);
  EXPECT_NEAR(v.body().angles_rad.pitch, -12 * math::kPi / 180, 0.02) << "nose up";
  EXPECT_FALSE(v.body().touches);
  const double up = std::tan(12 * math::kPi / 180) * (v.body().p_world_m.x - 1);
  EXPECT_NEAR(v.body().p_world_m.z, kP3at.rest_m + up, 0.03);
  EXPECT_LT(v.due().imu_sample.accel_mps2.x * -1, 0) << "gravity pulls backwards: +g upward has a part forward";
}

TEST(Place, AnEdgeTooHighForWheelsStopsThemWhileTheyTurn) {
  Place place(ground(), {});
  Vehicle& v = put(place, kP3at, 0, -3);
  v.drive({{}, 5, 5});
  wait(place, 6);
  EXPECT_NEAR(v.body().p_world_m.x, 2 - kP3at.wheelbase_m / 2, 0.02);
  EXPECT_NEAR(v.body().p_world_m.z, kP3at.rest_m, 0.001);
  EXPECT_TRUE(v.body().touches);
  EXPECT_GT(v.wheels().left_rad(), 25) << "the odometer is deceived";
  v.drive({{}, -5, -5});
  wait(place, 2);
  EXPECT_LT(v.body().p_world_m.x, 1.5) << "backwards it comes away";
}

TEST(Place, VehiclesMeetEachOther) {
  Place place(ground(), {});
  Vehicle& a = put(place, kP3at, -6, 0);
  Vehicle& b = put(place, kP3at, -3, 0, math::kPi);
  a.drive({{}, 5, 5});
  b.drive({{}, 5, 5});
  wait(place, 6);
  EXPECT_GT(b.body().p_world_m.x - a.body().p_world_m.x, 2 * kP3at.hull_radius_m - 0.01);
  EXPECT_GE(a.touches() + b.touches(), 1u);
  EXPECT_FALSE(place.enter(kP3at, {b.body().p_world_m, 0}, {})) << "one stands about there";
}

TEST(Place, TheCameraTurnsAtItsRateWithinItsLimits) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  v.aim(kPan, {false, 1.0});
  wait(place, 0.2);
  EXPECT_NEAR(v.camera().position_rad[kPan], 0.2 * kAirRobot.camera_radps, 0.01);
  wait(place, 1);
  EXPECT_NEAR(v.camera().position_rad[kPan], 1, 1e-6);
  v.aim(kTilt, {true, 9});
  wait(place, 3);
  EXPECT_NEAR(v.camera().position_rad[kTilt], kAirRobot.tilt_down_rad, 1e-9);
  const Quat q(v.camera_pose().q_world_optical);
  EXPECT_LT(q.rotate({0, 0, 1}).z, -0.9) << "tilt downwards is positive";
  v.aim(kTilt, {false, 0});
  wait(place, 2);
  const Vec3 ahead = Quat(v.camera_pose().q_world_optical).rotate({0, 0, 1});
  EXPECT_NEAR(std::atan2(ahead.y, ahead.x), 1, 1e-3) << "pan to the left is positive";
}

TEST(Place, SimulatedDrivesTakeTheCamerasJointsOverAndGiveThemBack) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  PlantJoints& joints = *v.joints();
  v.aim(kPan, {false, -0.5});
  joints.drive(kPan, {DriveMode::velocity, 0, 0.5});
  wait(place, 1);
  EXPECT_NEAR(joints.motion(kPan).position_rad, 0.5, 1e-3);
  joints.drive(kPan, {DriveMode::off});
  wait(place, 1);
  EXPECT_NEAR(joints.motion(kPan).position_rad, 0.5, 1e-3) << "its gear holds it";
  joints.release(kPan);
  wait(place, 2);
  EXPECT_NEAR(joints.motion(kPan).position_rad, -0.5, 1e-3);
}

TEST(Place, TheTargetGoesRoundAndIsSeenUnlessSomethingIsBetween) {
  PlaceMap map = ground();
  map.target_way = {{2, 0, 0.07}, {2, 1, 0.07}};  // begins before the camera: it counts as found after 0.3 s
  Place place(map, {1, 0.1, false});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  wait(place, 5);
  EXPECT_NEAR(place.target_m().y, 0.5, 1e-3);
  wait(place, 10);
  EXPECT_NEAR(place.target_m().y, 0.5, 1e-3) << "and back";
  EXPECT_NE(v.outcome().find("target in view for 100 %"), std::string::npos) << v.outcome();
  place.put_target({6, 0, 0.25});  // behind the wall
  wait(place, 14.7);
  EXPECT_NE(v.outcome().find("target in view for 50 %"), std::string::npos) << v.outcome();
}

TEST(Place, ATargetThatPassesThroughThePictureIsNotFoundYet) {
  PlaceMap map = ground();
  map.target_way = {{2, -1, 0.07}, {2, 1, 0.07}};
  Place place(map, {1, 1, false});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  wait(place, 2);
  EXPECT_EQ(v.outcome().find("target in view"), std::string::npos) << v.outcome();
}

TEST(Place, AGoalIsReachedOverATargetThatIsInView) {
  PlaceMap map = ground();
  map.target_way = {{2, 0, 0.07}};
  Place::Options options{1, 0, false};
  options.has_goal = true;
  Place place(map, options);
  Vehicle& v = put(place, kAirRobot, 0, 0);
  EXPECT_EQ(v.verdict().outcome, "never saw the target");
  wait(place, 1);
  EXPECT_EQ(v.verdict().outcome, "did not reach the target");
  EXPECT_FALSE(v.verdict().good);
  place.put_target({6, 0, 0.25});  // behind the wall
  wait(place, 1);
  EXPECT_EQ(v.verdict().outcome, "lost the target from view");
}

TEST(Place, WindCarriesAVehicleInTheAirAndNoneThatStands) {
  Place::Options options{1, 0, false};
  options.wind.steady_mps = 2, options.wind.toward_rad = 0;
  Place place(ground(), options);
  Vehicle& v = put(place, kAirRobot, 0, 0);
  wait(place, 1);
  EXPECT_NEAR(v.body().p_world_m.x, 0, 1e-6);
  v.drive({{{0, 0, 0.5}, 0}, 0, 0});
  wait(place, 2);
  EXPECT_GT(v.body().p_world_m.x, 0.1);
  EXPECT_LT(v.body().angles_rad.pitch, -0.01) << "it leans against the wind";
}

TEST(Place, ThingsStandInTheWayOfBeamsUntilTheyAreRemoved) {
  Place place(ground(), {});
  Vehicle& v = put(place, kAirRobot, 0, 0);
  EXPECT_NEAR(place.beam(v, {0, 0, 0.2}, {1, 0, 0}, 9)->range_m, 3, 1e-9);
  ASSERT_TRUE(place.create(1, "crate", {{1, 0, 0.2}, {}}));
  EXPECT_FALSE(place.create(1, "crate", {{5, 0, 0.2}, {}})) << "the name is taken";
  place.advance({});
  EXPECT_NEAR(place.beam(v, {0, 0, 0.2}, {1, 0, 0}, 9)->range_m, 1 - kThing_m / 2, 1e-9);
  const Scene scene = place.bodies(kMostRobots);
  EXPECT_EQ(scene.body[SceneOrder::kThings + kMostOfAKind].p_world_m, (msg::Vec3{1, 0, 0.2}));
  EXPECT_TRUE(place.remove("crate"));
  EXPECT_FALSE(place.remove("crate"));
  place.advance({});
  EXPECT_NEAR(place.beam(v, {0, 0, 0.2}, {1, 0, 0}, 9)->range_m, 3, 1e-9);
}

TEST(Place, ARoofHidesSatellites) {
  PlaceMap map = ground();
  Place open(map, {});
  EXPECT_EQ(open.satellites({-30, -30, 0}), Place::kSatellites);
  map.solids.push_back({Shape::box, {0, 0, 5}, {}, {100, 100, 0.1}});
  Place hall(map, {});
  EXPECT_EQ(hall.satellites({0, 0, 0}), 0u);
}

TEST(Place, EightVehiclesEnterAndTheNinthIsRefused) {
  Place place(ground(), {});
  for (int i = 0; i < static_cast<int>(kMostRobots); ++i) put(place, kAirRobot, -5 - 2 * i, 0);
  const auto ninth = place.enter(kAirRobot, {{0, 8, 1}, 0}, {});
  ASSERT_FALSE(ninth);
  EXPECT_EQ(ninth.error().code, hal::Errc::busy);
  place.leave(3);
  EXPECT_EQ(*place.enter(kP3at, {{0, 8, kP3at.rest_m}, 0}, {}), 3u);
}

TEST(Place, SameCommandsGiveTheSameBytes) {
  const auto run = [] {
    Place place(ground(), {7, 0.4, true});
    Vehicle& v = put(place, kAirRobot, 0, 0);
    const std::array<double, 6> command{1.5, -0.3, 0.4, 0.7, 0.2, 0.3};
    const RobotCommand one(command);
    for (int i = 0; i < 8000; ++i) place.advance({&one, 1});
    return std::pair(v.body().p_world_m, v.due().imu_sample.accel_mps2);
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace sinew::plant::place_test
