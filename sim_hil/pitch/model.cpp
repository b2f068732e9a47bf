#include "sim_hil/pitch/model.hpp"

#include <charconv>

#include "sim_hil/mujoco/body_xml.hpp"
#include "sim_hil/pitch/wheeled.hpp"

namespace sinew::plant {
namespace {

std::string digits(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}
std::string triple(double x, double y, double z) { return digits(x) + ' ' + digits(y) + ' ' + digits(z); }

/// A geom that stands still, for what has these contact bits.
std::string fixed(const char* type, const std::string& size, const std::string& at, int touches,
                  const char* more = "") {
  return std::string("<geom type=\"") + type + "\" size=\"" + size + "\" pos=\"" + at + "\" contype=\"" +
         std::to_string(touches) + "\" conaffinity=\"0\" friction=\"0.1 0.005 0.0001\" " + more + "/>\n";
}

std::string goal(const FieldSize& f, double side) {
  const double x = side * f.length_m / 2, back = side * (f.length_m / 2 + f.goal_depth_m);
  const double half = f.goal_width_m / 2 + f.post_radius_m, middle = (x + back) / 2;
  const double high = f.goal_height_m, thick = 0.01;
  std::string out;
  for (const double post : {-half, half}) {
    out += fixed("cylinder", digits(f.post_radius_m) + ' ' + digits(high / 2), triple(x, post, high / 2), kSolid);
    // The net holds the ball; robots walk through it, since it gives way.
    out += fixed("box", triple(f.goal_depth_m / 2, thick, high / 2), triple(middle, post, high / 2), kBallOnly);
  }
  out += fixed("cylinder", digits(f.post_radius_m) + ' ' + digits(half), triple(x, 0, high + f.post_radius_m), kSolid,
               "euler=\"1.5707963267948966 0 0\"");
  out += fixed("box", triple(thick, half, high / 2), triple(back, 0, high / 2), kBallOnly);
  return out;
}

}  // namespace

std::string robot_name_end(std::size_t robot) { return '_' + std::to_string(robot); }

std::string pitch_xml(const PitchOptions& o, std::span<const ModelRobot> robots) {
  const std::size_t n = robots.size();
  const FieldSize& f = o.field;
  const double half_x = f.length_m / 2 + f.border_m + 1, half_y = f.width_m / 2 + f.border_m + 1;
  const double rough = o.ground.roughness_mm / 1000;
  // MuJoCo's own functions are exact copies of ours (sim_hil/mujoco/elementary.cpp). Euler treats damping implicitly.
  std::string xml =
      "<mujoco><compiler angle=\"radian\" discardvisual=\"false\"/>\n"
      "<option timestep=\"" +
      digits(kPitchStepNs * 1e-9) +
      "\" gravity=\"0 0 -9.81\" integrator=\"Euler\" solver=\"Newton\" jacobian=\"sparse\"/>\n"
      "<size njmax=\"" +
      std::to_string(200 + 300 * n) + "\" nconmax=\"" + std::to_string(50 + 80 * n) + "\" nstack=\"" +
      std::to_string(300'000 + 100'000 * n) + "\"/>\n<default><geom solref=\"0.01 1\"/></default>\n";
  if (rough > 0) {
    const auto points = [](double half) { return static_cast<int>(2 * half / kGroundCell_m) + 1; };
    xml += std::string("<asset><hfield name=\"") + kGroundName + "\" nrow=\"" + std::to_string(points(half_y)) +
           "\" ncol=\"" + std::to_string(points(half_x)) + "\" size=\"" + digits(half_x) + ' ' + digits(half_y) + ' ' +
           digits(2 * rough) + " 0.1\"/></asset>\n";
  }
  xml += "<worldbody>\n";
  const std::string half = triple(half_x, half_y, 1);
  if (rough > 0)
    xml += std::string("<geom name=\"") + kGroundName + "\" type=\"hfield\" hfield=\"" + kGroundName + "\" pos=\"0 0 " +
           digits(-rough) + "\" contype=\"" + std::to_string(kUneven) +
           "\" conaffinity=\"0\" friction=\"0.1 0.005 0.0001\"/>\n";
  // Under feet the ground is uneven; a ball rolls on the grass above that.
  xml += fixed("plane", half, "0 0 0", rough > 0 ? kBallOnly : kBallOnly | kUneven);
  if (rough > 0) xml += fixed("plane", half, "0 0 " + digits(-rough - 0.002), kUneven);
  for (const double side : {-1.0, 1.0}) xml += goal(f, side);
  if (const PitchWall& w = o.wall; w.high_m > 0)
    xml += fixed("box", triple(w.thick_m / 2, (w.to_y_m - w.from_y_m) / 2, w.high_m / 2),
                 triple(w.x_m, (w.to_y_m + w.from_y_m) / 2, w.high_m / 2), kSolid);
  for (std::size_t i = 0; i < n; ++i) {
    const ModelRobot& r = robots[i];
    if (r.kind == PitchBody::Kind::wheeled)
      xml += wheeled_xml(r.body, robot_name_end(i), r.friction);
    else
      xml += body_xml(r.body, {.name_end = robot_name_end(i), .at_m = {}, .friction = r.friction});
  }
  if (o.has_ball) {
    const double r = o.ball.radius_m, m = o.ball.mass_kg;
    const std::string inertia = digits(2.0 / 3 * m * r * r);  // a shell
    xml += std::string("<body name=\"") + kBallName + "\" pos=\"0 0 " + digits(r) +
           "\"><freejoint/><inertial pos=\"0 0 0\" mass=\"" + digits(m) + "\" diaginertia=\"" + inertia + ' ' +
           inertia + ' ' + inertia + "\"/><geom type=\"sphere\" size=\"" + digits(r) + "\" contype=\"" +
           std::to_string(kSolid) + "\" conaffinity=\"" + std::to_string(kSolid | kBallOnly) +
           "\" friction=\"0.5 0.005 0.0001\"/></body>\n";
  }
  return xml + "</worldbody></mujoco>\n";
}

}  // namespace sinew::plant
