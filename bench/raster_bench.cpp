// Pictures of eight humanoids on a field, through the cameras on their heads, by sim_hil/raster: milliseconds of one
// core a picture, and triangles.
//
//   raster_bench [ROUNDS [BODY.toml [PICTURE.ppm]]]       BODY.toml: robots/kid/op3.toml without one
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "apps/toml/body_reader.hpp"
#include "math/random.hpp"
#include "sim_hil/raster/raster.hpp"

namespace {

using namespace sinew;
using kinematics::Pose;
using math::Quat;
using math::Vec3;
using raster::Colour;
using raster::Mesh;

struct Thing {
  Mesh mesh;
  Pose pose;
  Colour colour;
  std::uint8_t shows;
  bool on_surface = false;
};

Mesh line(double x0, double y0, double x1, double y1) {
  const double along_x = math::fabs(x1 - x0) > math::fabs(y1 - y0) ? 0 : 0.025, along_y = 0.025 - along_x;
  return raster::polygon({{std::min(x0, x1) - along_x, std::min(y0, y1) - along_y, 0},
                          {std::max(x0, x1) + along_x, std::min(y0, y1) - along_y, 0},
                          {std::max(x0, x1) + along_x, std::max(y0, y1) + along_y, 0},
                          {std::min(x0, x1) - along_x, std::max(y0, y1) + along_y, 0}});
}

/// A field of 9 m x 6 m with its lines, goals and ball.
std::vector<Thing> field() {
  std::vector<Thing> all;
  // Cut into pieces, so that those outside of the picture are left out as a whole.
  for (int i = -6; i < 6; ++i)
    all.push_back({raster::polygon({{i * 1.0, -4, 0}, {i + 1.0, -4, 0}, {i + 1.0, 4, 0}, {i * 1.0, 4, 0}}),
                   {},
                   {44, 124, 54},
                   1});
  const Colour white{245, 245, 245};
  const double lines[][4] = {
      {-4.5, -3, 4.5, -3}, {-4.5, 3, 4.5, 3}, {-4.5, -3, -4.5, 3}, {4.5, -3, 4.5, 3}, {0, -3, 0, 3}};
  for (const auto& l : lines) all.push_back({line(l[0], l[1], l[2], l[3]), {}, white, 2, true});
  for (const double side : {-1.0, 1.0}) {
    all.push_back({line(side * 3.5, -1.5, side * 3.5, 1.5), {}, white, 2, true});
    for (const double post : {-1.3, 1.3}) {
      all.push_back({line(side * 3.5, post < 0 ? -1.5 : 1.5, side * 4.5, post < 0 ? -1.5 : 1.5), {}, white, 2, true});
      all.push_back({raster::cylinder(0.05, 1.2), {{side * 4.5, post, 0.6}, {}}, white, 3});
    }
    all.push_back({raster::cylinder(0.05, 2.6),
                   {{side * 4.5, 0, 1.2}, Quat::from_axis_angle({1, 0, 0}, math::kPi / 2)},
                   white,
                   3});
  }
  all.push_back({raster::ring(0.725, 0.775), {}, white, 2, true});
  all.push_back({raster::sphere(0.065, 16, 10), {{0.2, 0.1, 0.065}, {}}, {240, 120, 20}, 4});
  return all;
}

struct Robot {
  kinematics::BodyPose pose;
  Colour colour;
};

Mesh mesh_of(const kinematics::Shape& s) {
  switch (s.kind) {
    case kinematics::Shape::Kind::box:
      return raster::box(s.size_m);
    case kinematics::Shape::Kind::capsule:
      return raster::capsule(s.size_m.x, s.size_m.z);
    case kinematics::Shape::Kind::sphere:
      break;
  }
  return raster::sphere(s.size_m.x);
}

}  // namespace

int main(int argc, char** argv) {
  const app::LoadedBody loaded = app::load_body(argc > 2 ? argv[2] : "robots/kid/op3.toml");
  if (!loaded.problems.empty()) return std::fprintf(stderr, "raster_bench: no body\n"), 2;
  const kinematics::Body& body = loaded.body;
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  const kinematics::Place* const eye = body.find_place("camera");
  if (!eye) return std::fprintf(stderr, "raster_bench: the body has no place called camera\n"), 2;

  std::vector<Thing> things = field();
  std::vector<Robot> robots;
  std::vector<std::pair<std::size_t, Mesh>> shapes;  // by link
  for (std::size_t i = 0; i < body.links.size(); ++i)
    for (const kinematics::Shape& s : body.links[i].shapes) shapes.emplace_back(i, mesh_of(s).moved({s.at_m, s.q}));
  math::Random random(1);
  for (int i = 0; i < 8; ++i) {
    std::vector<double> rad(body.joints());
    for (std::size_t j = 0; j < rad.size(); ++j) rad[j] = 0.15 * random.uniform(-1, 1);
    rad[*body.find_link("head_tilt") - 1] = 0.25;
    const double side = i < 4 ? -1 : 1;
    const Vec3 at{side * random.uniform(0.6, 3), random.uniform(-2, 2), 0.28};
    const double yaw = math::atan2(0.1 - at.y, 0.2 - at.x) + random.uniform(-0.3, 0.3);
    robots.push_back({kinematics::BodyPose(body), i < 4 ? Colour{40, 70, 190} : Colour{190, 40, 50}});
    robots.back().pose.set(rad, {at, Quat::from_axis_angle({0, 0, 1}, yaw)});
  }
  std::size_t triangles = 0;
  for (const Thing& t : things) triangles += t.mesh.triangles.size();
  for (const auto& s : shapes) triangles += s.second.triangles.size() * robots.size();

  for (const auto& [width, height] : {std::pair{320u, 240u}, {640u, 480u}}) {
    raster::Raster picture(width, height);
    std::vector<double> ms;
    for (int round = 0; round < rounds; ++round)
      for (std::size_t r = 0; r < robots.size(); ++r) {
        const auto begin = std::chrono::steady_clock::now();
        raster::Camera camera;
        // Of a camera that looks along x: right is -y, down is -z.
        camera.pose = robots[r].pose.place(*eye) * Pose{{}, Quat(0.5, -0.5, 0.5, -0.5)};
        camera.fx_px = camera.fy_px = 0.875 * height;
        camera.cx_px = width / 2.0, camera.cy_px = height / 2.0;
        picture.look(camera);
        picture.clear({150, 170, 190});
        for (const Thing& t : things) picture.draw(t.mesh, t.pose, t.colour, t.shows, t.on_surface);
        for (std::size_t other = 0; other < robots.size(); ++other)
          for (const auto& [link, mesh] : shapes)
            picture.draw(mesh, robots[other].pose.link(link), link == 0 ? robots[other].colour : Colour{60, 60, 65},
                         static_cast<std::uint8_t>(10 + other));
        ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
        if (argc > 3 && r == 2 && round == 0 && width == 640) {
          FILE* const out = std::fopen(argv[3], "wb");
          if (!out) return std::perror(argv[3]), 1;
          std::fprintf(out, "P6 %u %u 255\n", width, height);
          for (const std::uint32_t p : picture.pixels())
            for (int shift = 0; shift < 24; shift += 8) std::fputc(static_cast<int>(p >> shift & 255), out);
          std::fclose(out);
        }
      }
    std::sort(ms.begin(), ms.end());
    std::printf("raster_%ux%u   %.3f ms a picture (median of %zu, least %.3f), %zu triangles in the scene\n", width,
                height, ms[ms.size() / 2], ms.size(), ms.front(), triangles);
  }
}
