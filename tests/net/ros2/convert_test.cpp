// Values by hand: what the page says of units and frames.
#include "net/ros2/convert.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "msg/all.hpp"
#include "msg/camera_model.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/image_buffer.hpp"
#include "msg/joints.hpp"
#include "msg/motion.hpp"
#include "msg/sensors.hpp"
#include "msg/team.hpp"

namespace sinew::ros2 {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kToRos = 1'000'000'000'000;  // the robot started 1000 s after the epoch of ROS time

MapOptions all_options() {
  MapOptions o;
  o.frame = "odom", o.child_frame = "base_link", o.joints = {"hip", "knee"}, o.object = "ball", o.field = "pressure_pa";
  o.field_of_view_rad = 0.5, o.min_m = 0.25, o.max_m = 8, o.geoid_m = 40, o.camera = {300, 310, 160, 120};
  return o;
}

/// What goes out, read again as the ROS type.
struct Sent {
  std::unique_ptr<Message> message;
  bool sent = false;
  double number(std::string_view path) { return message->find(path)->number(); }
  std::int64_t integer(std::string_view path) { return message->find(path)->integer(); }
  std::string text(std::string_view path) { return message->find(path)->text; }
  Bytes bytes;
};
template <class M>
Sent send(std::string_view ros, const M& own, const MapOptions& options = all_options(), Distro distro = Distro::humble,
          std::span<const std::uint8_t> picture = {}) {
  Sent sent;
  std::string why;
  const auto out = Outgoing::make(distro, ros, msg::type_info<M>(), options, why);
  EXPECT_TRUE(out) << why;
  if (!out) return sent;
  sent.sent = out->encode(&own, kToRos, sent.bytes, picture);
  sent.message = std::make_unique<Message>(out->type());
  if (sent.sent) {
    EXPECT_TRUE(decode(out->type(), sent.bytes, sent.message->root()));
  }
  return sent;
}

template <class M>
Incoming::Result receive(std::string_view ros, const Bytes& bytes, M& own, const MapOptions& options = all_options()) {
  std::string why;
  const auto in = Incoming::make(Distro::humble, ros, msg::type_info<M>(), options, why);
  EXPECT_TRUE(in) << why;
  if (!in) return {"no translation"};
  return in->decode(bytes, kToRos, &own);
}

Bytes made(std::string_view ros, const std::function<void(Message&)>& fill) {
  Message message(*known_types(Distro::humble).find(ros));
  fill(message);
  Bytes bytes;
  encode(message.type(), message.root(), bytes);
  return bytes;
}

TEST(Ros2Convert, AnImuSampleKeepsItsAxesAndSaysThatItHasNoOrientation) {
  const msg::ImuSample imu{{2'500'000'000}, {0.1, 0.2, 0.3}, {0, 0, 9.81}};
  Sent sent = send("sensor_msgs/msg/Imu", imu);
  EXPECT_EQ(sent.integer("header.stamp.sec"), 1002);
  EXPECT_EQ(sent.integer("header.stamp.nanosec"), 500'000'000);
  EXPECT_EQ(sent.text("header.frame_id"), "odom");
  EXPECT_EQ(sent.number("angular_velocity.z"), 0.3);
  EXPECT_EQ(sent.number("linear_acceleration.z"), 9.81) << "+g upward at rest";
  EXPECT_EQ(sent.number("orientation_covariance[0]"), -1);
  EXPECT_EQ(sent.number("orientation.w"), 1);
  EXPECT_EQ(sent.bytes.size(), 4U + (4 + 4 + 4 + 5) + 7 + 8 * (4 + 9 + 3 + 9 + 3 + 9));
  msg::ImuSample back;
  const auto result = receive("sensor_msgs/msg/Imu", sent.bytes, back);
  ASSERT_TRUE(result) << result.error;
  EXPECT_EQ(result.stamp_ns, kToRos + 2'500'000'000);
  EXPECT_EQ(back.stamp.ns, 2'500'000'000);
  EXPECT_EQ(back.gyro_radps, imu.gyro_radps);
  EXPECT_EQ(back.accel_mps2, imu.accel_mps2);
}

TEST(Ros2Convert, OdometryHasItsVelocityInTheAxesOfTheRobot) {
  msg::NavState nav;
  nav.p_world_m = {1, 2, 3};
  nav.v_world_mps = {0, 2, 0};                                // to the north
  nav.q_world_base = {std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // which is where the nose points: yaw 90 deg
  nav.gyro_radps = {0, 0, 0.5};
  nav.p_std_m = 0.5, nav.v_std_mps = 0.1, nav.tilt_std_rad = 0.02;
  EXPECT_FALSE(send("nav_msgs/msg/Odometry", nav).sent) << "the position is not valid";
  nav.position_valid = 1;
  Sent sent = send("nav_msgs/msg/Odometry", nav);
  EXPECT_EQ(sent.text("child_frame_id"), "base_link");
  EXPECT_EQ(sent.number("pose.pose.position.y"), 2);
  EXPECT_NEAR(sent.number("twist.twist.linear.x"), 2, 1e-12) << "forward";
  EXPECT_NEAR(sent.number("twist.twist.linear.y"), 0, 1e-12);
  EXPECT_EQ(sent.number("twist.twist.angular.z"), 0.5);
  EXPECT_EQ(sent.number("pose.pose.orientation.z"), std::sqrt(0.5));
  EXPECT_EQ(sent.number("pose.covariance[7]"), 0.25);
  EXPECT_EQ(sent.number("pose.covariance[35]"), 1e6) << "the heading is not estimated";
  EXPECT_NEAR(sent.number("twist.covariance[0]"), 0.01, 1e-15);
  msg::NavState back;
  ASSERT_TRUE(receive("nav_msgs/msg/Odometry", sent.bytes, back));
  EXPECT_NEAR(back.v_world_mps.y, 2, 1e-12);
  EXPECT_EQ(back.p_world_m.z, 3);
  EXPECT_EQ(back.height_m, 3);
  EXPECT_EQ(back.p_std_m, 0.5);
  EXPECT_EQ(back.position_valid, 1U);
}

TEST(Ros2Convert, AnOrientationThatIsNoneIsRefused) {
  const Bytes zero = made("geometry_msgs/msg/PoseStamped", [](Message&) {});
  msg::TeamPose pose;
  EXPECT_EQ(receive("geometry_msgs/msg/PoseStamped", zero, pose).error, "an orientation that is not of length 1");
}

TEST(Ros2Convert, TransformsAreFoundByTheirFrames) {
  const msg::TeamPose pose{{7}, {1, 2, 3}, {0, 1, 0, 0}, {}};
  Sent sent = send("tf2_msgs/msg/TFMessage", pose);
  EXPECT_EQ(sent.text("transforms[0].header.frame_id"), "odom");
  EXPECT_EQ(sent.text("transforms[0].child_frame_id"), "base_link");
  EXPECT_EQ(sent.number("transforms[0].transform.rotation.x"), 1);
  EXPECT_EQ(sent.number("transforms[0].transform.rotation.w"), 0);
  msg::TeamPose back;
  ASSERT_TRUE(receive("tf2_msgs/msg/TFMessage", sent.bytes, back));
  EXPECT_EQ(back.p_team_m, pose.p_team_m);
  EXPECT_EQ(back.stamp.ns, 7);
  MapOptions other = all_options();
  other.child_frame = "camera";
  EXPECT_TRUE(receive("tf2_msgs/msg/TFMessage", sent.bytes, back, other).skipped);
}

TEST(Ros2Convert, NoEchoIsInfinityAndComesInAsNothing) {
  Sent sent = send("sensor_msgs/msg/Range", msg::RangeSample{{1}, std::nan("")});
  EXPECT_EQ(sent.number("range"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(sent.number("max_range"), 8);
  EXPECT_EQ(sent.number("field_of_view"), 0.5);
  msg::RangeSample back;
  EXPECT_TRUE(receive("sensor_msgs/msg/Range", sent.bytes, back).skipped);
  sent = send("sensor_msgs/msg/Range", msg::RangeSample{{1}, 2.5});
  ASSERT_TRUE(receive("sensor_msgs/msg/Range", sent.bytes, back));
  EXPECT_EQ(back.range_m, 2.5);
  const std::size_t humble = sent.bytes.size();
  EXPECT_EQ(send("sensor_msgs/msg/Range", msg::RangeSample{{1}, 2.5}, all_options(), Distro::jazzy).bytes.size(),
            humble + 4)
      << "jazzy's has a variance";
}

TEST(Ros2Convert, TheCurrentOfABatteryHasTheOtherSign) {
  Sent sent = send("sensor_msgs/msg/BatteryState", msg::BatterySample{{1}, 11.5, 4, 0.75});
  EXPECT_EQ(sent.number("current"), -4);
  EXPECT_EQ(sent.integer("power_supply_status"), 2) << "discharging";
  EXPECT_EQ(sent.number("percentage"), 0.75);
  EXPECT_TRUE(std::isnan(sent.number("temperature")));
  EXPECT_EQ(sent.integer("present"), 1);
  msg::BatterySample back;
  ASSERT_TRUE(receive("sensor_msgs/msg/BatteryState", sent.bytes, back));
  EXPECT_EQ(back.current_a, 4);
  const Bytes unknown =
      made("sensor_msgs/msg/BatteryState", [](Message& m) { m.find("percentage")->set(std::nan("")); });
  EXPECT_EQ(receive("sensor_msgs/msg/BatteryState", unknown, back).error, "percentage is not known");
}

TEST(Ros2Convert, AltitudesAreAboveTheEllipsoidInRos) {
  msg::GnssSample fix;
  fix.latitude_deg = 52.5, fix.longitude_deg = 13.25, fix.altitude_m = 35;
  fix.horizontal_accuracy_m = 2, fix.vertical_accuracy_m = 3, fix.fix = msg::GnssFix::full;
  Sent sent = send("sensor_msgs/msg/NavSatFix", fix);
  EXPECT_EQ(sent.number("altitude"), 75) << "the geoid is 40 m above it";
  EXPECT_EQ(sent.number("position_covariance[4]"), 4);
  EXPECT_EQ(sent.number("position_covariance[8]"), 9);
  EXPECT_EQ(sent.integer("status.status"), 0);
  msg::GnssSample back;
  ASSERT_TRUE(receive("sensor_msgs/msg/NavSatFix", sent.bytes, back));
  EXPECT_EQ(back.altitude_m, 35);
  EXPECT_EQ(back.vertical_accuracy_m, 3);
  EXPECT_EQ(back.fix, msg::GnssFix::full);
  fix.fix = msg::GnssFix::none;
  EXPECT_TRUE(receive("sensor_msgs/msg/NavSatFix", send("sensor_msgs/msg/NavSatFix", fix).bytes, back).skipped);
}

TEST(Ros2Convert, FieldAndPressureAreInTeslaAndPascal) {
  Sent mag = send("sensor_msgs/msg/MagneticField", msg::MagSample{{1}, {2e-5, 0, -4e-5}});
  EXPECT_EQ(mag.number("magnetic_field.z"), -4e-5);
  Sent baro = send("sensor_msgs/msg/FluidPressure", msg::BaroSample{{1}, 101325, 20});
  EXPECT_EQ(baro.number("fluid_pressure"), 101325);
  msg::BaroSample back;
  ASSERT_TRUE(receive("sensor_msgs/msg/FluidPressure", baro.bytes, back));
  EXPECT_EQ(back.temperature_c, 15);
}

TEST(Ros2Convert, JointsGoByTheirNamesInAnyOrder) {
  const Bytes bytes = made("sensor_msgs/msg/JointState", [](Message& m) {
    for (const char* list : {"name", "position", "velocity"}) m.find(list)->items.resize(3);
    m.find("name[0]")->text = "knee", m.find("name[1]")->text = "nose", m.find("name[2]")->text = "hip";
    m.find("position[0]")->set(1), m.find("position[1]")->set(9), m.find("position[2]")->set(2);
    m.find("velocity[2]")->set(0.5);
  });
  msg::JointState joints;
  ASSERT_TRUE(receive("sensor_msgs/msg/JointState", bytes, joints));
  EXPECT_EQ(joints.count, 2U);
  EXPECT_EQ(joints.position_rad[0], 2) << "the hip";
  EXPECT_EQ(joints.position_rad[1], 1);
  EXPECT_EQ(joints.velocity_radps[0], 0.5);
  EXPECT_EQ(joints.effort_nm[0], 0) << "not in it";
  EXPECT_EQ(joints.ready, 3U);
  Sent sent = send("sensor_msgs/msg/JointState", joints);
  EXPECT_EQ(sent.text("name[1]"), "knee");
  EXPECT_EQ(sent.number("position[0]"), 2);
  MapOptions more = all_options();
  more.joints.push_back("foot");
  EXPECT_EQ(receive("sensor_msgs/msg/JointState", bytes, joints, more).error, "a joint is missing");
}

TEST(Ros2Convert, ATrajectoryHasItsPointsInOrder) {
  const auto trajectory = [](std::int64_t second) {
    return made("trajectory_msgs/msg/JointTrajectory", [&](Message& m) {
      m.find("joint_names")->items.resize(2);
      m.find("joint_names[0]")->text = "knee", m.find("joint_names[1]")->text = "hip";
      Value& points = *m.find("points");
      points.items.resize(2);
      for (Value& p : points.items) {
        Message::make_default(*m.type().find("points")->nested, p);
        p.items[0].items.resize(2);
        p.items[0].items[0].set(1), p.items[0].items[1].set(2);
      }
      m.find("points[0].time_from_start.sec")->set_integer(1);
      m.find("points[1].time_from_start.sec")->set_integer(second);
      m.find("points[1].time_from_start.nanosec")->set_integer(5);
    });
  };
  msg::JointTrajectory path;
  ASSERT_TRUE(receive("trajectory_msgs/msg/JointTrajectory", trajectory(2), path));
  EXPECT_EQ(path.points, 2U);
  EXPECT_EQ(path.point[1].position_rad[0], 2) << "the hip";
  EXPECT_EQ(path.point[1].from_start_ns, 2'000'000'005);
  EXPECT_EQ(receive("trajectory_msgs/msg/JointTrajectory", trajectory(0), path).error,
            "points whose times do not rise");
}

TEST(Ros2Convert, SticksAndButtonsBecomeChannels) {
  const Bytes bytes = made("sensor_msgs/msg/Joy", [](Message& m) {
    m.find("axes")->items.resize(2), m.find("buttons")->items.resize(2);
    m.find("axes[0]")->set(0.5), m.find("axes[1]")->set(-3), m.find("buttons[1]")->set_integer(1);
  });
  msg::RcSample rc;
  ASSERT_TRUE(receive("sensor_msgs/msg/Joy", bytes, rc));
  EXPECT_EQ(rc.count, 4U);
  EXPECT_EQ(rc.channel[0], 0.5);
  EXPECT_EQ(rc.channel[1], -1);
  EXPECT_EQ(rc.channel[2], -1);
  EXPECT_EQ(rc.channel[3], 1);
}

TEST(Ros2Convert, ATwistIsInTheAxesOfTheRobot) {
  const Bytes bytes =
      made("geometry_msgs/msg/Twist", [](Message& m) { m.find("linear.x")->set(1), m.find("angular.z")->set(-0.5); });
  msg::VelocityCommand command;
  const auto result = receive("geometry_msgs/msg/Twist", bytes, command);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result.stamp_ns) << "it has no stamp";
  EXPECT_EQ(command.linear_mps.x, 1);
  EXPECT_EQ(command.angular_radps.z, -0.5);
}

TEST(Ros2Convert, PicturesGoWithAndWithoutPaddedRows) {
  msg::ImageBuffer image(3 * 2 * 3);
  ASSERT_TRUE(image->format_as(msg::PixelFormat::rgb8, 3, 2));
  for (std::uint32_t i = 0; i < 18; ++i) image->pixels()[i] = static_cast<std::uint8_t>(i);
  std::string why;
  const auto out =
      Outgoing::make(Distro::humble, "sensor_msgs/msg/Image", msg::type_info<msg::Image>(), all_options(), why);
  const auto in =
      Incoming::make(Distro::humble, "sensor_msgs/msg/Image", msg::type_info<msg::Image>(), all_options(), why);
  Bytes bytes;
  ASSERT_TRUE(out->encode(&*image, 0, bytes));
  msg::ImageBuffer back(100);
  ASSERT_TRUE(in->decode(bytes, 0, &*back, 100));
  EXPECT_EQ(back->format, msg::PixelFormat::rgb8);
  EXPECT_EQ(std::memcmp(back->pixels(), image->pixels(), 18), 0);
  EXPECT_EQ(in->decode(bytes, 0, &*back, 17).error, "an image of no size, or larger than its topic takes");

  const std::uint8_t padded[] = {1, 2, 3, 99, 4, 5, 6, 99};
  const auto of = [&](std::int64_t step, const char* encoding) {
    return made("sensor_msgs/msg/Image", [&](Message& m) {
      m.find("height")->set_integer(2), m.find("width")->set_integer(3), m.find("step")->set_integer(step);
      m.find("encoding")->text = encoding;
      m.find("data")->bytes = padded;
    });
  };
  ASSERT_TRUE(in->decode(of(4, "mono8"), 0, &*back, 100));
  EXPECT_EQ(back->pixels()[3], 4);
  EXPECT_EQ(in->decode(of(5, "mono8"), 0, &*back, 100).error, "rows that are not all there");
  EXPECT_THAT(std::string(in->decode(of(4, "32FC1"), 0, &*back, 100).error), HasSubstr("an encoding other than"));
}

TEST(Ros2Convert, ACameraSaysItsIntrinsics) {
  msg::ImageBuffer image(12);
  ASSERT_TRUE(image->format_as(msg::PixelFormat::mono8, 4, 3));
  std::string why;
  const auto out =
      Outgoing::make(Distro::humble, "sensor_msgs/msg/CameraInfo", msg::type_info<msg::Image>(), all_options(), why);
  Bytes bytes;
  ASSERT_TRUE(out->encode(&*image, 0, bytes));
  Message info(out->type());
  ASSERT_TRUE(decode(out->type(), bytes, info.root()));
  EXPECT_EQ(info.find("width")->integer(), 4);
  EXPECT_EQ(info.find("k[4]")->number(), 310);
  EXPECT_EQ(info.find("p[6]")->number(), 120);
  EXPECT_EQ(info.find("d")->items.size(), 5U);
}

TEST(Ros2Convert, ACompressedPictureIsHandedToWhatReadsFiles) {
  std::string why;
  const auto in = Incoming::make(Distro::humble, "sensor_msgs/msg/CompressedImage", msg::type_info<msg::Image>(),
                                 all_options(), why);
  ASSERT_TRUE(in) << why;
  const std::uint8_t file[] = {0xff, 0xd8, 7};
  const Bytes bytes = made("sensor_msgs/msg/CompressedImage", [&](Message& m) {
    m.find("format")->text = "bgr8; jpeg compressed bgr8";
    m.find("header.stamp.sec")->set_integer(1001);
    m.find("data")->bytes = file;
  });
  msg::ImageBuffer image(4);
  EXPECT_EQ(in->decode(bytes, kToRos, &*image, 4).error, "files of pictures are not read here");
  std::size_t handed = 0;
  ASSERT_TRUE(in->decode(bytes, kToRos, &*image, 4, [&](std::span<const std::uint8_t> picture, msg::Image& out) {
    handed = picture.size();
    EXPECT_EQ(out.capacity_bytes, 4U);
    return out.format_as(msg::PixelFormat::mono8, 2, 2) ? nullptr : "too large";
  }));
  EXPECT_EQ(handed, 3U);
  EXPECT_EQ(image->width, 2U);
  EXPECT_EQ(image->stamp.ns, 1'000'000'000);
  const auto refuse = [](std::span<const std::uint8_t>, msg::Image&) { return "damaged"; };
  EXPECT_EQ(in->decode(bytes, kToRos, &*image, 4, refuse).error, "damaged");
}

TEST(Ros2Convert, ACameraModelGoesThereAndBack) {
  const msg::CameraModel model{{5}, 640, 480, 500, 510, 320, 240, {0.1, -0.2, 0.001, 0.002, 0.03}};
  Sent sent = send("sensor_msgs/msg/CameraInfo", model);
  EXPECT_EQ(sent.text("distortion_model"), "plumb_bob");
  EXPECT_EQ(sent.number("k[0]"), 500);
  EXPECT_EQ(sent.number("p[6]"), 240);
  msg::CameraModel back;
  ASSERT_TRUE(receive("sensor_msgs/msg/CameraInfo", sent.bytes, back));
  EXPECT_EQ(std::memcmp(&back, &model, sizeof model), 0);
}

TEST(Ros2Convert, ACameraThatIsNoPinholeIsRefused) {
  const auto said = [](const std::function<void(Message&)>& change) {
    msg::CameraModel model;
    const Bytes bytes = made("sensor_msgs/msg/CameraInfo", [&](Message& m) {
      m.find("k[0]")->set(300), m.find("k[4]")->set(300);
      m.find("d")->items.resize(5);
      change(m);
    });
    return std::string(receive("sensor_msgs/msg/CameraInfo", bytes, model).error);
  };
  EXPECT_EQ(said([](Message&) {}), "") << "no distortion, and no name of a model";
  EXPECT_EQ(said([](Message& m) { m.find("distortion_model")->text = "equidistant"; }), "") << "with zeros";
  EXPECT_EQ(said([](Message& m) { m.find("distortion_model")->text = "equidistant", m.find("d[0]")->set(0.1); }),
            "a distortion model other than plumb_bob");
  EXPECT_EQ(said([](Message& m) {
              m.find("distortion_model")->text = "plumb_bob";
              m.find("d")->items.resize(8);
              m.find("d[7]")->set(0.1);
            }),
            "more than five coefficients of plumb_bob");
  EXPECT_EQ(said([](Message& m) { m.find("k[0]")->set(0); }), "a camera that is not calibrated (its k is 0)");
  EXPECT_EQ(said([](Message& m) { m.find("binning_x")->set_integer(2); }), "a picture of binned pixels");
  EXPECT_EQ(said([](Message& m) { m.find("roi.width")->set_integer(2); }), "a region of a picture");
  EXPECT_EQ(said([](Message& m) {
              m.find("distortion_model")->text = "plumb_bob";
              m.find("d[1]")->set(std::nan(""));
            }),
            "a number that is not finite");
}

TEST(Ros2Convert, DetectionsKeepTheirPlaceInTheImageAndInSpace) {
  msg::BallSighting ball;
  ball.found = 1, ball.direction_optical = {0, 0.6, 0.8}, ball.range_m = 2, ball.u_px = 100, ball.v_px = 50,
  ball.radius_px = 10;
  ball.confidence = 0.75;
  Sent sent = send("vision_msgs/msg/Detection2DArray", ball);
  EXPECT_EQ(sent.text("detections[0].results[0].hypothesis.class_id"), "ball");
  EXPECT_EQ(sent.number("detections[0].bbox.size_x"), 20);
  EXPECT_EQ(sent.number("detections[0].bbox.center.position.x"), 100);
  EXPECT_EQ(sent.number("detections[0].results[0].pose.pose.position.z"), 1.6);
  msg::BallSighting back;
  ASSERT_TRUE(receive("vision_msgs/msg/Detection2DArray", sent.bytes, back));
  EXPECT_EQ(back.found, 1U);
  EXPECT_EQ(back.radius_px, 10);
  EXPECT_NEAR(back.range_m, 2, 1e-12);
  EXPECT_NEAR(back.direction_optical.y, 0.6, 1e-12);
  MapOptions other = all_options();
  other.object = "goal";
  ASSERT_TRUE(receive("vision_msgs/msg/Detection2DArray", sent.bytes, back, other));
  EXPECT_EQ(back.found, 0U);
  ball.found = 0;
  EXPECT_EQ(send("vision_msgs/msg/Detection2DArray", ball).message->find("detections")->items.size(), 0U);
}

TEST(Ros2Convert, AnyNumberGoesAsAStandardType) {
  EXPECT_EQ(send("std_msgs/msg/Float64", msg::BaroSample{{1}, 101325, 20}).number("data"), 101325);
  EXPECT_EQ(send("std_msgs/msg/Int32", msg::BaroSample{{1}, 101325, 20}).integer("data"), 101325);
  EXPECT_THAT(send("std_msgs/msg/String", msg::BaroSample{{1}, 101325, 20}).text("data"),
              HasSubstr("\"pressure_pa\":101325"));
  msg::BaroSample back;
  ASSERT_TRUE(
      receive("std_msgs/msg/Float64", made("std_msgs/msg/Float64", [](Message& m) { m.find("data")->set(5); }), back));
  EXPECT_EQ(back.pressure_pa, 5);
  EXPECT_EQ(receive("std_msgs/msg/Float64",
                    made("std_msgs/msg/Float64", [](Message& m) { m.find("data")->set(std::nan("")); }), back)
                .error,
            "a number that is not finite");
}

TEST(Ros2Convert, AnOwnMessageGoesByItsOwnDefinition) {
  const msg::NavState nav{};
  Sent sent = send("sinew_msgs/msg/NavState", nav);
  EXPECT_EQ(sent.number("q_world_base.w"), 1);
  msg::NavState back;
  ASSERT_TRUE(receive("sinew_msgs/msg/NavState", sent.bytes, back));
}

TEST(Ros2Convert, EveryLineOfTheTableWorksInItsDirections) {
  for (const Distro distro : {Distro::humble, Distro::jazzy})
    for (const MapLine& line : map_table()) {
      const msg::TypeInfo* own = msg::find_type(line.own.empty() ? "BaroSample" : line.own);
      ASSERT_NE(own, nullptr) << line.own;
      std::string why;
      EXPECT_EQ(Outgoing::make(distro, line.ros, *own, all_options(), why) != nullptr, line.out)
          << line.ros << ": " << why;
      EXPECT_EQ(Incoming::make(distro, line.ros, *own, all_options(), why) != nullptr, line.in)
          << line.ros << ": " << why;
      for (const auto& [ros, from] : line.fields) {
        const std::string first = ros.substr(0, ros.find_first_of(".[, "));
        EXPECT_NE(known_types(distro).find(line.ros)->find(first), nullptr) << line.ros << ": " << ros;
      }
    }
}

TEST(Ros2Convert, AWrongPairOrAMissingOptionIsSaid) {
  std::string why;
  EXPECT_FALSE(
      Outgoing::make(Distro::humble, "sensor_msgs/msg/Imu", msg::type_info<msg::MagSample>(), all_options(), why));
  EXPECT_EQ(why, "goes with messages of ImuSample, and the topic's are MagSample");
  EXPECT_FALSE(Outgoing::make(Distro::humble, "sensor_msgs/msg/Imu", msg::type_info<msg::ImuSample>(), {}, why));
  EXPECT_EQ(why, "frame is required");
  EXPECT_FALSE(Outgoing::make(Distro::humble, "sensor_msgs/msg/Joy", msg::type_info<msg::RcSample>(), {}, why));
  EXPECT_EQ(why, "a type that is not translated in this direction");
  EXPECT_FALSE(Outgoing::make(Distro::humble, "std_msgs/msg/Float64", msg::type_info<msg::RcSample>(), {}, why));
  EXPECT_EQ(why, "field names a number of RcSample");
}

}  // namespace
}  // namespace sinew::ros2
