#include "apps/sim/render_test.hpp"

#include <png.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <vector>

#include "sim_hil/plant/renderer.hpp"
#include "sim_hil/worlds/head_body.hpp"
#include "sim_hil/worlds/head_world.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::plant {
namespace {

bool write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height, msg::PixelFormat format,
               const std::vector<std::uint8_t>& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format == msg::PixelFormat::mono8 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, path.c_str(), 0, pixels.data(), 0, nullptr)) return true;
  std::fprintf(stderr, "sinew-sim: cannot write %s: %s\n", path.c_str(), image.message);
  return false;
}

CameraPose camera_at(const msg::Vec3& base, const msg::Quat& q_world_base) {
  return {add(base, Rotation(q_world_base).apply(kCameraPBase)), mul(q_world_base, kCameraQBaseOptical)};
}

/// Prints the time of a frame. `draw(i)` draws the i-th of many.
template <class Draw>
void time_frames(std::uint32_t width, std::uint32_t height, Draw&& draw) {
  constexpr int kFrames = 200;
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  for (int i = 0; i < kFrames; ++i) draw(i);
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
  const double cpu_ms = 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  std::printf("%u x %u: %.2f ms per frame, %.2f ms of CPU\n", width, height, wall.count() / kFrames, cpu_ms / kFrames);
}

struct View {
  const char* name;
  msg::Vec3 base;
  msg::Quat q;
};

/// Camera views at the heights of a flight, then the time of a frame.
int camera_pictures(const std::filesystem::path& folder, std::uint32_t width, std::uint32_t height) {
  std::string why;
  auto renderer = Renderer::create({width, height, false}, why);
  if (!renderer) {
    std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
    return 1;
  }
  std::printf("rendering by %s\n", (*renderer)->backend().c_str());
  const View views[] = {{"camera_start", {0.7, 0.4, 0.12}, {}},
                        {"camera_0.3m", {0.02, 0, 0.3}, {}},
                        {"camera_1.5m", {0.4, -0.2, 1.5}, {0.98, 0.02, -0.03, 0.19}},
                        {"camera_3m", {-0.6, 0.5, 3.0}, {}}};
  std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3), yuyv(std::size_t{width} * height * 2);
  for (const View& v : views) {
    const double n = 1 / std::sqrt(v.q.w * v.q.w + v.q.x * v.q.x + v.q.y * v.q.y + v.q.z * v.q.z);
    const msg::Quat q{v.q.w * n, v.q.x * n, v.q.y * n, v.q.z * n};
    (*renderer)->camera_view(camera_at(v.base, q), msg::PixelFormat::rgb8, rgb.data());
    if (!write_png(folder / (std::string(v.name) + ".png"), width, height, msg::PixelFormat::rgb8, rgb)) return 1;
  }
  // A place on the orange, 0.22 m beside the centre: its colour as the robot gets it.
  (*renderer)->camera_view(camera_at({0.22, 0, 1.0}, {}), msg::PixelFormat::yuyv, yuyv.data());
  const std::size_t at = (std::size_t{height / 2} * width + width / 2) * 2;
  std::printf("pad as rendered: Y %d U %d V %d\n", yuyv[at], yuyv[at + 1], yuyv[at + 3]);

  time_frames(width, height, [&](int i) {
    (*renderer)->camera_view(camera_at({0.005 * i, 0.3, 1.5}, {}), msg::PixelFormat::yuyv, yuyv.data());
  });
  return 0;
}

int outside_pictures(const std::filesystem::path& folder) {
  constexpr std::uint32_t kWidth = 800, kHeight = 450;
  std::string why;
  auto renderer = Renderer::create({kWidth, kHeight, true}, why);
  if (!renderer) {
    std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
    return 1;
  }
  std::vector<std::uint8_t> rgb(std::size_t{kWidth} * kHeight * 3);
  TruthState vehicle;
  vehicle.omega_radps.fill(600);
  const auto shoot = [&](const char* name, const msg::Vec3& at, const msg::Quat& q, const msg::Vec3& eye,
                         const msg::Vec3& target) {
    vehicle.p_world_m = at;
    vehicle.q_world_base = q;
    if (at.z <= kFeetBelowBase) vehicle.omega_radps.fill(0);
    (*renderer)->outside_view(vehicle, eye, target, rgb.data());
    return write_png(folder / name, kWidth, kHeight, msg::PixelFormat::rgb8, rgb);
  };
  const bool ok = shoot("flight.png", {0.12, -0.02, 0.62}, {0.9957, 0.035, -0.055, 0.065}, {-0.70, -0.80, 1.02},
                        {0.12, 0.0, 0.36}) &&
                  shoot("room.png", {0.2, 0.1, 1.6}, {1, 0, 0, 0}, {-3.5, -3.4, 2.6}, {0.5, 0.5, 0.8}) &&
                  shoot("landed.png", {0.03, -0.02, 0.12}, {0.98, 0, 0, 0.199}, {0.75, -0.8, 0.55}, {0, 0, 0.08});
  return ok ? 0 : 1;
}

/// Pan and tilt that point the head at the ball.
std::array<double, kHeadJoints> aim(const HeadWorld& world) {
  const math::Quat q_base = world.q_world_base();
  const math::Vec3 neck = kPivot + q_base.rotate(kPBaseYoke + kPYokeHead);
  const math::Vec3 d = q_base.conjugate().rotate(world.ball_m() - neck);
  return {math::atan2(d.y, d.x), math::atan2(-d.z, math::hypot(d.x, d.y))};
}

/// A head that is told where the ball is: from outside and through its camera.
int head_pictures(const std::filesystem::path& folder, std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t kWidth = 800, kHeight = 450;
  std::string why;
  auto outside = Renderer::create({kWidth, kHeight, true, WorldKind::desk_head}, why);
  HeadWorld world({.seed = 1});
  std::vector<std::uint8_t> rgb(std::size_t{kWidth} * kHeight * 3), small(std::size_t{width} * height * 3);
  const auto advance = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 4000); ++i) {
      const auto command = aim(world);
      world.step(command);
    }
  };
  if (!outside) {
    std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
    return 1;
  }
  advance(3.0);
  (*outside)->place(world.scene());
  (*outside)->outside_view({-0.75, -0.95, 1.50}, {0.55, 0.10, 0.98}, rgb.data());
  if (!write_png(folder / "desk_head.png", kWidth, kHeight, msg::PixelFormat::rgb8, rgb)) return 1;
  (*outside)->outside_view({0.55, -0.55, 1.12}, {0.0, 0.0, 0.93}, rgb.data());
  if (!write_png(folder / "desk_head_close.png", kWidth, kHeight, msg::PixelFormat::rgb8, rgb)) return 1;
  outside->reset();  // one OpenGL context at a time on a thread
  auto camera = Renderer::create({width, height, false, WorldKind::desk_head}, why);
  if (!camera) {
    std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
    return 1;
  }
  for (int i = 0; i < 6; ++i) {
    (*camera)->place(world.scene());
    (*camera)->camera_view(world.camera_pose(), msg::PixelFormat::rgb8, small.data());
    const std::string name = "desk_head_camera_" + std::to_string(i) + ".png";
    if (!write_png(folder / name, width, height, msg::PixelFormat::rgb8, small)) return 1;
    advance(1.7);
  }
  time_frames(width, height, [&](int) {
    (*camera)->place(world.scene());
    (*camera)->camera_view(world.camera_pose(), msg::PixelFormat::rgb8, small.data());
  });
  return 0;
}

}  // namespace

int render_test(const std::string& folder, const CameraOptions& view) {
  const std::uint32_t width = view.width, height = view.height;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    std::fprintf(stderr, "sinew-sim: cannot make %s: %s\n", folder.c_str(), error.message().c_str());
    return 1;
  }
  if (view.world == WorldKind::desk_head) return head_pictures(folder, width, height);
  if (const int code = camera_pictures(folder, width, height); code != 0) return code;
  return outside_pictures(folder);
}

}  // namespace sinew::plant
