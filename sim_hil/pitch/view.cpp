#include "sim_hil/pitch/view.hpp"

#include <algorithm>

#include "sim_hil/pitch/wheeled.hpp"

namespace sinew::plant {
namespace {

using kinematics::Shape;
using math::Quat;
using math::Vec3;
using raster::Colour;
using raster::Mesh;

constexpr Colour kSky{168, 184, 200}, kCarpet{46, 122, 56}, kCarpetStripe{42, 114, 52}, kWhite{240, 240, 240},
    kBallBlack{30, 30, 34}, kBallOrange{236, 112, 24}, kDark{58, 58, 64}, kWall{96, 104, 116};
constexpr Colour kTeams[] = {{40, 80, 210}, {205, 45, 50}};
constexpr double kTile_m = 1;                   // of the carpet: tiles outside of a picture are left out as a whole
constexpr double kFar_m = 2.5;                  // from here on a robot has fewer faces
constexpr Quat kOptical{0.5, -0.5, 0.5, -0.5};  // of a camera that looks along x: right is -y, down is -z

Mesh tile(double x0, double y0, double x1, double y1) {
  return raster::polygon({{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}});
}

Mesh strip(const FieldLine& l, double width_m) {
  const double half = width_m / 2;
  const bool along_x = l.y0_m == l.y1_m;
  const double more_x = along_x ? 0 : half, more_y = half - more_x;
  // Corners of outer lines are filled by those along x.
  const double past = along_x ? half : 0;
  return tile(std::min(l.x0_m, l.x1_m) - more_x - past, std::min(l.y0_m, l.y1_m) - more_y,
              std::max(l.x0_m, l.x1_m) + more_x + past, std::max(l.y0_m, l.y1_m) + more_y);
}

Mesh mesh_of(const Shape& s, bool far) {
  switch (s.kind) {
    case Shape::Kind::box:
      return raster::box(s.size_m);
    case Shape::Kind::capsule:
      return far ? raster::capsule(s.size_m.x, s.size_m.z, 5, 1) : raster::capsule(s.size_m.x, s.size_m.z);
    case Shape::Kind::sphere:
      break;
  }
  return far ? raster::sphere(s.size_m.x, 6, 4) : raster::sphere(s.size_m.x);
}

/// How far from link 0 anything of the body can be: along its chains, all stretched.
double reach_m(const kinematics::Body& body) {
  double most = 0;
  std::vector<double> to(body.links.size());
  for (std::size_t i = 0; i < body.links.size(); ++i) {
    const kinematics::Link& link = body.links[i];
    if (i > 0) to[i] = to[link.parent] + norm(link.at_m);
    for (const Shape& s : link.shapes) most = std::max(most, to[i] + norm(s.at_m) + norm(s.size_m));
  }
  return most;
}

}  // namespace

raster::Camera camera_at(const Vec3& eye, const Vec3& target, std::uint32_t width, std::uint32_t height,
                         double focal_per_height) {
  const Vec3 z = math::normalized(target - eye), x = math::normalized(cross(z, Vec3{0, 0, 1})), y = cross(z, x);
  raster::Camera c;
  c.pose = {eye, Quat::from_matrix({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z})};
  c.fx_px = c.fy_px = focal_per_height * height;
  c.cx_px = width / 2.0, c.cy_px = height / 2.0;
  return c;
}

kinematics::Pose PitchBoard::pose() const {
  const Quat heading = Quat::from_axis_angle({0, 0, 1}, heading_rad);
  // Right of who looks along x is -y; down the page is -x where it lies, and down where it stands.
  const math::SinCos lean = math::sincos(lean_rad);
  const Vec3 x = heading.rotate({0, -1, 0}), y = heading.rotate({-lean.cos, 0, -lean.sin}), z = cross(x, y);
  const Vec3 near{x_m, y_m, 0};
  return {near - x * ((kBoardColumns - 1) * 0.5 * square_m) - y * ((kBoardRows + 1) * square_m),
          Quat::from_matrix({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z})};
}

void PitchScene::take(const Pitch& pitch) {
  robots.resize(pitch.robots());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const std::size_t links = pitch.body(i).links.size();
    std::copy_n(pitch.truth(i).link.begin(), links, robots[i].link.begin());
  }
  ball = {pitch.ball().p_m, pitch.ball().q};
}

PitchView::PitchView(const PitchOptions& o, std::span<const PitchBody> bodies) {
  const FieldSize& f = o.field;
  const double half_x = f.length_m / 2 + f.border_m, half_y = f.width_m / 2 + f.border_m;
  int stripe = 0;
  for (double x = -half_x; x < half_x - 1e-9; x += kTile_m, ++stripe)
    for (double y = -half_y; y < half_y - 1e-9; y += 2 * kTile_m)
      still_.push_back({tile(x, y, std::min(x + kTile_m, half_x), std::min(y + 2 * kTile_m, half_y)),
                        stripe % 2 ? kCarpet : kCarpetStripe, kShowsCarpet});
  for (const FieldLine& l : field_lines(f)) still_.push_back({strip(l, f.line_m), kWhite, kShowsLine, true});
  still_.push_back({raster::ring((f.circle_diameter_m - f.line_m) / 2, (f.circle_diameter_m + f.line_m) / 2), kWhite,
                    kShowsLine, true});
  const Quat across = Quat::from_axis_angle({1, 0, 0}, math::kPi / 2);
  for (const double side : {-1.0, 1.0}) {
    Mesh frame;
    const double x = side * f.length_m / 2, half = f.goal_width_m / 2 + f.post_radius_m;
    for (const double y : {-half, half})
      frame.add(raster::cylinder(f.post_radius_m, f.goal_height_m).moved({{x, y, f.goal_height_m / 2}, {}}));
    frame.add(raster::cylinder(f.post_radius_m, 2 * half).moved({{x, 0, f.goal_height_m + f.post_radius_m}, across}));
    still_.push_back({frame, kWhite, kShowsGoal});
  }
  if (const PitchWall& w = o.wall; w.high_m > 0)
    still_.push_back({raster::box({w.thick_m, w.to_y_m - w.from_y_m, w.high_m})
                          .moved({{w.x_m, (w.from_y_m + w.to_y_m) / 2, w.high_m / 2}, {}}),
                      kWall, kShowsWall});
  if (o.board.square_m > 0) {
    const double a = o.board.square_m;
    const auto part = [&](double x0, double y0, double x1, double y1, const Colour& colour, bool on_surface) {
      const kinematics::Pose at = o.board.pose();
      std::vector<Vec3> corners;
      for (const auto& [x, y] : {std::pair{x0, y0}, {x0, y1}, {x1, y1}, {x1, y0}}) corners.push_back(at.of({x, y, 0}));
      still_.push_back({raster::polygon(corners), colour, kShowsBoard, on_surface});
    };
    // On the ground it lies on the carpet.
    part(-2 * a, -2 * a, (kBoardColumns + 1) * a, (kBoardRows + 1) * a, kWhite, o.board.lean_rad < 0.02);
    for (int j = 0; j <= kBoardRows; ++j)
      for (int i = j % 2; i <= kBoardColumns; i += 2) part((i - 1) * a, (j - 1) * a, i * a, j * a, kBallBlack, true);
  }
  // Every third pair of faces of the ball is black.
  const Mesh whole = raster::sphere(o.ball.radius_m, 12, 8);
  Mesh white = whole, black = whole;
  white.triangles.clear(), black.triangles.clear();
  for (std::size_t i = 0; i < whole.triangles.size(); ++i)
    (i / 2 % 3 == 0 ? black : white).triangles.push_back(whole.triangles[i]);
  if (o.has_ball && o.orange_ball)
    ball_ = {{whole, kBallOrange, kShowsBall}};
  else if (o.has_ball)
    ball_ = {{white, kWhite, kShowsBall}, {black, kBallBlack, kShowsBall}};

  for (const PitchBody& given : bodies) {
    Robot r;
    r.radius_m = reach_m(given.body);
    r.focal_per_height = given.focal_per_height;
    for (std::size_t i = 0; i < given.body.links.size(); ++i) {
      LinkPart part;
      part.link = i;
      part.colour = i == 0 ? kTeams[given.team % 2] : kDark;
      if (given.kind == PitchBody::Kind::wheeled && (i == 1 + kLeftWheel || i == 1 + kRightWheel)) {
        part.near = raster::cylinder(kPioneer.wheel_radius_m, kPioneer.wheel_width_m).moved({{}, across});
        part.far = part.near;
        r.parts.push_back(std::move(part));
        continue;
      }
      for (const Shape& s : given.body.links[i].shapes) {
        part.near.add(mesh_of(s, false).moved({s.at_m, s.q}));
        part.far.add(mesh_of(s, true).moved({s.at_m, s.q}));
      }
      if (!part.near.triangles.empty()) r.parts.push_back(std::move(part));
    }
    for (const kinematics::Place& place : given.body.places)
      if (place.name.rfind("camera", 0) == 0) r.camera.push_back(place);
    robot_.push_back(std::move(r));
  }
}

const std::string& PitchView::camera_name(std::size_t robot, std::size_t camera) const {
  return robot_[robot].camera[camera].name;
}

raster::Camera PitchView::camera(const PitchScene& scene, std::size_t robot, std::size_t camera, std::uint32_t width,
                                 std::uint32_t height) const {
  const kinematics::Place& place = robot_[robot].camera[camera];
  raster::Camera c;
  c.pose = scene.robots[robot].link[place.link] * place.pose * kinematics::Pose{{}, kOptical};
  c.fx_px = c.fy_px = robot_[robot].focal_per_height * height;
  c.cx_px = width / 2.0, c.cy_px = height / 2.0;
  return c;
}

void PitchView::draw(raster::Raster& picture, const PitchScene& scene, std::size_t robot, std::size_t which) const {
  draw(picture, scene, camera(scene, robot, which, picture.width(), picture.height()));
}

void PitchView::draw(raster::Raster& picture, const PitchScene& scene, const raster::Camera& camera) const {
  picture.look(camera);
  picture.clear(kSky);
  for (const Part& p : still_) picture.draw(p.mesh, {}, p.colour, p.shows, p.on_surface);
  if (scene.has_ball)
    for (const Part& p : ball_) picture.draw(p.mesh, scene.ball, p.colour, p.shows);
  const Vec3 ahead = camera.pose.q.rotate({0, 0, 1});
  for (std::size_t i = 0; i < robot_.size(); ++i) {
    const Robot& r = robot_[i];
    const auto& link = scene.robots[i].link;
    const Vec3 way = link[0].p_m - camera.pose.p_m;
    if (dot(way, ahead) < -r.radius_m) continue;
    const bool far = squared_norm(way) > kFar_m * kFar_m;
    const auto shows = static_cast<std::uint8_t>(kShowsRobot + i);
    for (const LinkPart& p : r.parts) picture.draw(far ? p.far : p.near, link[p.link], p.colour, shows);
  }
}

}  // namespace sinew::plant
