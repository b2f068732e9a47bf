#include "apps/sim/render_test.hpp"

#include <png.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <vector>

#include "sim_hil/plant/renderer.hpp"

namespace sinew::plant {
namespace {

constexpr std::uint32_t kOutsideWidth = 800, kOutsideHeight = 450;

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

std::unique_ptr<Renderer> open(const Renderer::Options& options) {
  std::string why;
  auto renderer = Renderer::create(options, why);
  if (renderer) return std::move(*renderer);
  std::fprintf(stderr, "sinew-sim: no rendering: %s\n", why.c_str());
  return nullptr;
}

/// Prints the time of a frame of this scene.
void time_frames(Renderer& renderer, const Scene& scene, const CameraOptions& view) {
  constexpr int kFrames = 200;
  std::vector<std::uint8_t> pixels(std::size_t{view.width} * view.height * 2);
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  for (int i = 0; i < kFrames; ++i) {
    renderer.place(scene);
    renderer.camera_view(scene.camera, msg::PixelFormat::yuyv, pixels.data());
  }
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
  time_frames(*renderer, last->scene, view);
  return true;
}

}  // namespace

int render_test(const std::string& folder, const CameraOptions& view, const WorldType& world) {
  const std::vector<Portrait> portraits = world.portraits();
  if (portraits.empty() || view.room_xml.empty()) {
    std::fprintf(stderr, "sinew-sim: --render-test: the world %s has no pictures\n", world.info.name);
    return 1;
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    std::fprintf(stderr, "sinew-sim: cannot make %s: %s\n", folder.c_str(), error.message().c_str());
    return 1;
  }
  return draw(folder, view, portraits, false) && draw(folder, view, portraits, true) ? 0 : 1;
}

}  // namespace sinew::plant
