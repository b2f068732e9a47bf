// The same scene of the pitch by sim_hil/raster and by MuJoCo's own renderer, as PNG side by side, and what a picture
// takes of one core: docs/pitch.md.
//
//   pitch_pictures FOLDER [BODY.toml]
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "apps/toml/body_reader.hpp"
#include "images/encode.hpp"
#include "kinematics/leg.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/view.hpp"
#include "sim_hil/plant/renderer.hpp"

namespace {

using namespace sinew;
using namespace sinew::plant;
using math::Quat;
using math::Vec3;

constexpr std::uint32_t kWidth = 480, kHeight = 360;

std::string text(const Vec3& v) { return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z); }

std::string geom(const char* type, const std::string& size, const Vec3& at, const Quat& q, const char* rgba) {
  return std::string("<geom type=\"") + type + "\" size=\"" + size + "\" pos=\"" + text(at) + "\" quat=\"" +
         std::to_string(q.w) + ' ' + text(q.vec()) + "\" rgba=\"" + rgba + "\"/>\n";
}

/// The scene as a model in which nothing moves.
std::string still_xml(const PitchOptions& o, const std::vector<PitchBody>& bodies, const PitchScene& scene) {
  const FieldSize& f = o.field;
  std::string xml =
      "<mujoco><compiler angle=\"radian\" discardvisual=\"false\"/><size njmax=\"10\" nconmax=\"10\"/>"
      "<visual><quality numslices=\"10\" numstacks=\"6\" numquads=\"1\"/><headlight ambient=\".5 .5 .5\" "
      "diffuse=\".5 .5 .5\" specular=\"0 0 0\"/></visual>"
      "<asset><texture name=\"sky\" type=\"skybox\" builtin=\"flat\" rgb1=\".66 .72 .78\" width=\"32\" height=\"32\"/>"
      "<texture name=\"grass\" type=\"2d\" builtin=\"checker\" rgb1=\".18 .48 .22\" rgb2=\".16 .44 .2\" width=\"64\" "
      "height=\"64\"/><material name=\"grass\" texture=\"grass\" texrepeat=\"24 24\"/></asset><worldbody>"
      "<geom type=\"plane\" size=\"" +
      text({f.length_m / 2 + f.border_m, f.width_m / 2 + f.border_m, 1}) + "\" material=\"grass\"/>\n";
  const char* const white = ".94 .94 .94 1";
  for (const FieldLine& l : field_lines(f)) {
    const double half = f.line_m / 2;
    xml += geom("box", text({std::max(half, (l.x1_m - l.x0_m) / 2), std::max(half, (l.y1_m - l.y0_m) / 2), 0.001}),
                {(l.x0_m + l.x1_m) / 2, (l.y0_m + l.y1_m) / 2, 0.001}, {}, white);
  }
  constexpr int kPieces = 48;
  for (int i = 0; i < kPieces; ++i) {
    const double angle = 2 * math::kPi * i / kPieces, r = f.circle_diameter_m / 2;
    xml += geom("box", text({f.line_m / 2, r * math::kPi / kPieces * 1.05, 0.001}),
                {r * math::cos(angle), r * math::sin(angle), 0.001}, Quat::from_axis_angle({0, 0, 1}, angle), white);
  }
  for (const double side : {-1.0, 1.0}) {
    const double half = f.goal_width_m / 2 + f.post_radius_m, x = side * f.length_m / 2;
    const std::string round = std::to_string(f.post_radius_m) + ' ';
    for (const double y : {-half, half})
      xml += geom("cylinder", round + std::to_string(f.goal_height_m / 2), {x, y, f.goal_height_m / 2}, {}, white);
    xml += geom("cylinder", round + std::to_string(half), {x, 0, f.goal_height_m + f.post_radius_m},
                Quat::from_axis_angle({1, 0, 0}, math::kPi / 2), white);
  }
  xml += geom("sphere", std::to_string(o.ball.radius_m), scene.ball.p_m, {}, white);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t l = 0; l < bodies[i].body.links.size(); ++l)
      for (const kinematics::Shape& s : bodies[i].body.links[l].shapes) {
        const kinematics::Pose at = scene.robots[i].link[l] * kinematics::Pose{s.at_m, s.q};
        const char* const colour = l > 0 ? ".23 .23 .25 1" : bodies[i].team == 0 ? ".16 .31 .82 1" : ".8 .18 .2 1";
        if (s.kind == kinematics::Shape::Kind::box)
          xml += geom("box", text(s.size_m * 0.5), at.p_m, at.q, colour);
        else if (s.kind == kinematics::Shape::Kind::capsule)
          xml +=
              geom("capsule", std::to_string(s.size_m.x) + ' ' + std::to_string(s.size_m.z / 2), at.p_m, at.q, colour);
        else
          xml += geom("sphere", std::to_string(s.size_m.x), at.p_m, at.q, colour);
      }
  return xml + "</worldbody></mujoco>";
}

/// Of this process's processor time.
double core_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// `left` and `right`: rgb8; written side by side.
void write_pair(const std::string& path, const std::vector<std::uint8_t>& left,
                const std::vector<std::uint8_t>& right) {
  std::vector<std::uint8_t> both(left.size() * 2);
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    std::copy_n(&left[y * kWidth * 3], kWidth * 3, &both[y * kWidth * 6]);
    std::copy_n(&right[y * kWidth * 3], kWidth * 3, &both[y * kWidth * 6 + kWidth * 3]);
  }
  images::Encoder encoder;
  const auto png =
      encoder.encode({both, 2 * kWidth, kHeight, 2 * kWidth * 3, msg::PixelFormat::rgb8}, images::Kind::png, {}, {});
  FILE* const out = png ? std::fopen(path.c_str(), "wb") : nullptr;
  if (!out) return std::perror(path.c_str());
  std::fwrite(png->data(), 1, png->size(), out);
  std::fclose(out);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: pitch_pictures FOLDER [BODY.toml]\n"), 2;
  const app::LoadedBody loaded = app::load_body(argc > 2 ? argv[2] : "robots/kid/op3.toml");
  if (!loaded.problems.empty()) return std::fprintf(stderr, "pitch_pictures: no body\n"), 2;
  PitchOptions options;
  options.ball_at = {.x_m = 0.1, .y_m = 0.1};
  std::vector<PitchBody> bodies;
  for (int i = 0; i < 8; ++i) {
    PitchBody b{.body = loaded.body};
    const double side = i < 4 ? -1 : 1, row = i % 4;
    b.team = static_cast<std::uint8_t>(i / 4);
    b.start = {.x_m = side * (0.7 + 0.5 * row), .y_m = 1.1 * (row - 1.5)};
    b.start.heading_rad = math::atan2(-b.start.y_m, -b.start.x_m);
    b.start.joints_rad.assign(loaded.body.joints(), 0);
    if (const auto head = loaded.body.find_link("head_tilt")) b.start.joints_rad[*head - 1] = 0.25;
    bodies.push_back(b);
  }
  auto pitch = Pitch::create(options, bodies, 1);
  if (!pitch) return std::fprintf(stderr, "pitch_pictures: no pitch\n"), 1;
  for (int step = 0; step < 600; ++step) {  // two that nobody holds fall
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (i != 3 && i != 6 && step % 5 == 0) (*pitch)->command(i, bodies[i].start.joints_rad);
    if (step == 10) (*pitch)->push(3, {1.5, 0, 0}, 100'000'000), (*pitch)->push(6, {-1, 1, 0}, 100'000'000);
    (*pitch)->step();
  }
  PitchScene scene;
  scene.take(**pitch);
  const PitchView view(options, bodies);
  std::string why;
  const std::string xml = still_xml(options, bodies, scene);
  auto renderer = Renderer::create({.width = kWidth, .height = kHeight, .picture = false, .room_xml = xml}, why);
  if (!renderer) return std::fprintf(stderr, "pitch_pictures: %s\n", why.c_str()), 1;
  struct Shot {
    const char* name;
    raster::Camera camera;
  };
  const Shot shots[] = {{"pitch_robot", view.camera(scene, 2, 0, kWidth, kHeight)},
                        {"pitch_field", camera_at({-3.4, -2.6, 1.9}, {0.2, 0.2, 0.1}, kWidth, kHeight)}};
  for (const Shot& shot : shots) {
    raster::Raster picture(kWidth, kHeight);
    std::vector<std::uint8_t> ours, theirs(std::size_t{kWidth} * kHeight * 3);
    const CameraPose pose{shot.camera.pose.p_m.to<msg::Vec3>(), shot.camera.pose.q.to<msg::Quat>(), 0.875};
    constexpr int kTimes = 20;
    const double begin = core_ms();
    for (int i = 0; i < kTimes; ++i) view.draw(picture, scene, shot.camera);
    const double between = core_ms();
    for (int i = 0; i < kTimes; ++i) (*renderer)->camera_view(pose, msg::PixelFormat::rgb8, theirs.data());
    const double end = core_ms();
    for (const std::uint32_t p : picture.pixels())
      for (int shift = 0; shift < 24; shift += 8) ours.push_back(static_cast<std::uint8_t>(p >> shift));
    write_pair(std::string(argv[1]) + '/' + shot.name + ".png", ours, theirs);
    std::printf("%-12s %ux%u: raster %.2f ms, MuJoCo's renderer %.2f ms a picture (%s)\n", shot.name, kWidth, kHeight,
                (between - begin) / kTimes, (end - between) / kTimes, (*renderer)->backend().c_str());
  }
}
