#include "apps/sim/render_test.hpp"

#include <png.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <vector>

#include "math/elementary.hpp"
#include "math/linear.hpp"
#include "sim_hil/plant/pixels.hpp"
#include "sim_hil/plant/renderer.hpp"

namespace sinew::plant {
namespace {

constexpr std::uint32_t kOutsideWidth = 800, kOutsideHeight = 450;

}  // namespace

bool write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
               const std::vector<std::uint8_t>& rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&image, path.c_str(), 0, rgb.data(), 0, nullptr)) return true;
  std::fprintf(stderr, "sinew-sim: cannot write %s: %s\n", path.c_str(), image.message);
  return false;
}

CameraPose camera_of(const Viewpoint& from) {
  const math::Vec3 eye(from.eye_m), ahead = math::normalized(math::Vec3(from.target_m) - eye);
  const double yaw = math::atan2(ahead.y, ahead.x), pitch = math::asin(-ahead.z);
  const math::Quat optical{0.5, -0.5, 0.5, -0.5};  // x right, y down, z ahead of a body that looks along x
  return {from.eye_m, (math::Quat::from_yaw_pitch_roll({yaw, pitch, 0}) * optical).to<msg::Quat>()};
}

namespace {

std::unique_ptr<Renderer> open(const Renderer::Options& options) {
  std::string why;
  auto renderer = Renderer::create(options, why);
  if (renderer) return std::move(*renderer);
  std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
  return nullptr;
}

/// Prints the time of a frame, which `draw` draws.
template <class Draw>
void time_pictures(const CameraOptions& view, Draw&& draw) {
  constexpr int kFrames = 200;
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  for (int i = 0; i < kFrames; ++i) draw();
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - begin;
  const double cpu_ms = 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  std::printf("%u x %u: %.2f ms per frame, %.2f ms of CPU\n", view.width, view.height, wall.count() / kFrames,
              cpu_ms / kFrames);
}

/// Draws the portraits from outside, or those through the camera: a thread has one OpenGL context at a time.
bool draw(const std::filesystem::path& folder, const CameraOptions& view, const std::vector<Portrait>& portraits,
          bool outside) {
  Renderer::Options options{view.width, view.height, outside, view.room_xml};
  if (outside) options.width = kOutsideWidth, options.height = kOutsideHeight;
  const auto renderer = open(options);
  if (!renderer) return false;
  std::vector<std::uint8_t> rgb(std::size_t{options.width} * options.height * 3);
  const Portrait* last = nullptr;
  for (const Portrait& portrait : portraits) {
    if (portrait.outside.has_value() != outside) continue;
    renderer->place(portrait.scene);
    if (outside)
      renderer->outside_view(portrait.outside->eye_m, portrait.outside->target_m, rgb.data());
    else
      renderer->camera_view(portrait.scene.camera, msg::PixelFormat::rgb8, rgb.data());
    if (!write_png(folder / (portrait.name + ".png"), options.width, options.height, rgb)) return false;
    last = &portrait;
  }
  if (outside || !last) return true;
  std::printf("rendering by %s\n", renderer->backend().c_str());
  std::vector<std::uint8_t> pixels(std::size_t{view.width} * view.height * 2);
  time_pictures(view, [&] {
    renderer->place(last->scene);
    renderer->camera_view(last->scene.camera, msg::PixelFormat::yuyv, pixels.data());
  });
  return true;
}

/// The same with the world's own painter, which draws from outside as through a camera.
bool paint(const std::filesystem::path& folder, const CameraOptions& view, const std::vector<Portrait>& portraits,
           const WorldChoice& choice) {
  for (const Portrait& portrait : portraits) {
    const std::uint32_t width = portrait.outside ? kOutsideWidth : view.width;
    const std::uint32_t height = portrait.outside ? kOutsideHeight : view.height;
    Scene scene = portrait.scene;
    if (portrait.outside) scene.camera = camera_of(*portrait.outside);
    std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3);
    const auto painter = choice.type->painter(width, height, choice);
    convert_image(reinterpret_cast<const std::uint8_t*>(painter->draw(scene).data()), width, height,
                  msg::PixelFormat::rgb8, rgb.data(), FirstRow::top);
    if (!write_png(folder / (portrait.name + ".png"), width, height, rgb)) return false;
  }
  const auto painter = choice.type->painter(view.width, view.height, choice);
  time_pictures(view, [&] { static_cast<void>(painter->draw(portraits.front().scene)); });
  return true;
}

}  // namespace

int render_test(const std::string& folder, const CameraOptions& view, const WorldChoice& choice) {
  const WorldType& world = *choice.type;
  const std::vector<Portrait> portraits = world.portraits(choice);
  if (portraits.empty() || (view.room_xml.empty() && !world.painter)) {
    std::fprintf(stderr, "sinew-sim: --render-test: the world %s has no pictures\n", world.info.name);
    return 1;
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    std::fprintf(stderr, "sinew-sim: cannot make %s: %s\n", folder.c_str(), error.message().c_str());
    return 1;
  }
  if (world.painter) return paint(folder, view, portraits, choice) ? 0 : 1;
  return draw(folder, view, portraits, false) && draw(folder, view, portraits, true) ? 0 : 1;
}

}  // namespace sinew::plant
