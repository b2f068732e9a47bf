#include "sim_hil/pitch/wheeled.hpp"

#include <algorithm>
#include <charconv>

namespace sinew::plant {
namespace {

using kinematics::Link;
using kinematics::Shape;
using math::Vec3;

constexpr const char* kNames[] = {"base", "l_wheel", "r_wheel", "l_paddle", "r_paddle"};
constexpr double kCasterFriction = 0.02;  // it turns where it is pushed
constexpr double kSlowDown = 1.15;        // no-load speed over the fastest that the robot is driven at
constexpr double kGain_per_m = 400;       // of the paddles

std::string words(const Vec3& v) {
  std::string out;
  for (int i = 0; i < 3; ++i) {
    char text[32];
    out.append(text, std::to_chars(text, text + sizeof text, v[i]).ptr);
    out += i < 2 ? " " : "";
  }
  return out;
}
std::string word(double v) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, v).ptr};
}

std::array<double, 6> of_box(double mass_kg, const Vec3& s) {
  return {mass_kg * (s.y * s.y + s.z * s.z) / 12,
          mass_kg * (s.x * s.x + s.z * s.z) / 12,
          mass_kg * (s.x * s.x + s.y * s.y) / 12,
          0,
          0,
          0};
}

}  // namespace

PitchBody pioneer_body(const PitchPlace& start) {
  const WheeledSize& z = kPioneer;
  PitchBody out;
  out.kind = PitchBody::Kind::wheeled;
  out.start = start;
  kinematics::Body& b = out.body;
  b.name = "pioneer";
  b.servos = {{"wheel", z.wheel_stall_nm, kSlowDown * z.fastest_mps / z.wheel_radius_m, 0.01},
              {"paddle", z.grip_n, z.grip_mps, 0.2}};

  const Vec3 body_size{z.length_m, z.width_m, z.high_m - z.low_m};
  Link base;
  base.name = kNames[0];
  base.mass_kg = z.mass_kg - 2 * z.wheel_kg;
  base.com_m = {z.middle_x_m / 2, 0, 0.1};  // batteries are low, between wheels and caster
  base.inertia_kgm2 = of_box(base.mass_kg, body_size);
  base.shapes = {{Shape::Kind::box, {z.middle_x_m, 0, (z.low_m + z.high_m) / 2}, body_size, {}},
                 {Shape::Kind::sphere, {z.caster_x_m, 0, z.caster_radius_m}, {z.caster_radius_m, 0, 0}, {}}};
  b.links = {base};
  for (const double side : {1.0, -1.0}) {
    Link wheel;
    wheel.name = kNames[side > 0 ? 1 : 2];
    wheel.parent = 0;
    wheel.at_m = {0, side * z.track_m / 2, z.wheel_radius_m};
    wheel.axis = {0, 1, 0};
    wheel.least_rad = -1e9, wheel.most_rad = 1e9;
    wheel.servo = 0;
    wheel.mass_kg = z.wheel_kg;
    const double r2 = z.wheel_radius_m * z.wheel_radius_m, w2 = z.wheel_width_m * z.wheel_width_m;
    const double across = z.wheel_kg * (3 * r2 + w2) / 12;
    wheel.inertia_kgm2 = {across, z.wheel_kg * r2 / 2, across, 0, 0, 0};
    wheel.shapes = {{Shape::Kind::sphere, {}, {z.wheel_radius_m, 0, 0}, {}}};  // drawn and touched as a cylinder
    b.links.push_back(wheel);
  }
  for (const double side : {1.0, -1.0}) {
    Link paddle;
    const Vec3 size{z.paddle_long_m, z.paddle_thick_m, z.paddle_high_m};
    paddle.name = kNames[side > 0 ? 3 : 4];
    paddle.parent = 0;
    paddle.at_m = {z.length_m / 2 + z.middle_x_m, side * (z.opening_m + z.paddle_thick_m) / 2, 0};
    paddle.axis = {0, -side, 0};
    paddle.most_rad = z.opening_m / 2;
    paddle.servo = 1;
    paddle.mass_kg = z.paddle_kg;
    paddle.com_m = {z.paddle_long_m / 2, 0, z.paddle_low_m + z.paddle_high_m / 2};
    paddle.inertia_kgm2 = of_box(z.paddle_kg, size);
    paddle.shapes = {{Shape::Kind::box, paddle.com_m, size, {}}};
    b.links.push_back(paddle);
  }
  b.places = {{"camera", 0, {{0.1, 0, 0.28}, math::Quat::from_axis_angle({0, 1, 0}, 0.3)}},
              {"imu", 0, {{0, 0, 0.1}, {}}}};
  out.gain_per_rad = kGain_per_m;
  out.errors.backlash_deg = 0;
  out.errors.encoder_steps = z.encoder_steps;
  return out;
}

void drive_wheels(Pitch& pitch, std::size_t robot, const WheelCommand& c) {
  const double most = kPioneer.fastest_mps / kPioneer.wheel_radius_m;
  const double turn = c.turn_radps * kPioneer.track_m / 2;
  const auto speed = [&](double mps) { return std::clamp(mps / kPioneer.wheel_radius_m, -most, most); };
  pitch.command(robot, kLeftWheel, {DriveMode::velocity, 0, speed(c.forward_mps - turn)});
  pitch.command(robot, kRightWheel, {DriveMode::velocity, 0, speed(c.forward_mps + turn)});
}

void grip(Pitch& pitch, std::size_t robot, double between_m) {
  const double way = std::clamp((kPioneer.opening_m - between_m) / 2, 0.0, kPioneer.opening_m / 2);
  for (const std::size_t paddle : {kLeftPaddle, kRightPaddle}) pitch.command(robot, paddle, {DriveMode::position, way});
}

double between_paddles_m(const BodySensors& sensors) {
  return kPioneer.opening_m - sensors.joint[kLeftPaddle].position_rad - sensors.joint[kRightPaddle].position_rad;
}

std::string wheeled_xml(const kinematics::Body& body, const std::string& end, double friction) {
  const auto named = [&](const char* kind, const Link& link) {
    return "<" + std::string(kind) + " name=\"" + link.name + end + "\"";
  };
  const auto inertial = [](const Link& link) {
    std::string out = "<inertial pos=\"" + words(link.com_m) + "\" mass=\"" + word(link.mass_kg) + "\" diaginertia=\"";
    return out + words({link.inertia_kgm2[0], link.inertia_kgm2[1], link.inertia_kgm2[2]}) + "\"/>";
  };
  const auto geom = [&](const Shape& s, double mu) {
    const bool box = s.kind == Shape::Kind::box;
    return "<geom type=\"" + std::string(box ? "box" : "sphere") + "\" pos=\"" + words(s.at_m) + "\" size=\"" +
           (box ? words(s.size_m * 0.5) : word(s.size_m.x)) + "\" friction=\"" + word(mu) + " 0.005 0.0001\"/>";
  };
  const Link& base = body.links[0];
  std::string out = named("body", base) + ">" + named("freejoint", base) + "/>" + inertial(base) +
                    geom(base.shapes[0], friction) + geom(base.shapes[1], kCasterFriction);
  for (const kinematics::Place& p : body.places) {
    const math::Quat& q = p.pose.q;
    out += "<site name=\"" + p.name + end + "\" pos=\"" + words(p.pose.p_m) + "\" quat=\"" + word(q.w) + ' ' +
           words(q.vec()) + "\"/>";
  }
  for (std::size_t i = 1; i < body.links.size(); ++i) {
    const Link& link = body.links[i];
    const bool wheel = i <= 2;
    out += named("body", link) + " pos=\"" + words(link.at_m) + "\">" + inertial(link) + named("joint", link) +
           " type=\"" + (wheel ? "hinge" : "slide") + "\" axis=\"" + words(link.axis) + "\" armature=\"" +
           word(body.servos[link.servo].armature_kgm2) + "\" limited=\"" + (wheel ? "false" : "true") +
           "\" range=\"0 " + word(link.most_rad) + "\"/>";
    if (wheel)
      out += "<geom type=\"cylinder\" size=\"" + word(kPioneer.wheel_radius_m) + ' ' +
             word(kPioneer.wheel_width_m / 2) + "\" euler=\"1.5707963267948966 0 0\" friction=\"" + word(friction) +
             " 0.005 0.0001\"/>";
    else
      out += geom(link.shapes[0], friction);
    out += "</body>\n";
  }
  return out + "</body>\n";
}

}  // namespace sinew::plant
