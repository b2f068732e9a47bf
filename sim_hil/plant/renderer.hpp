#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "msg/image.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// Draws the room without a display: OpenGL in software (Mesa's llvmpipe) on a surfaceless EGL context.
/// Thread:  create, use and destroy on one thread; several renderers may live on several threads.
/// Errors:  not_supported when EGL or OpenGL cannot be had, or draws no textures; `why` says which call failed.
class Renderer {
 public:
  struct Options {
    std::uint32_t width = 320, height = 240;
    bool picture = false;       // for people: vehicles are drawn, with shadows and smoothed edges; ten times as slow
    std::string_view room_xml;  // WorldType::room_xml
    std::size_t robots = 1;     // in the room; the camera sees them when there are several
  };
  static hal::Result<std::unique_ptr<Renderer>> create(const Options& options, std::string& why);
  ~Renderer();

  /// Moves the bodies of the room, as many as it has for this.
  void place(const Scene& scene);

  /// The view of the robot's camera; its own body is out of view.
  /// `out`: width * height * bytes per pixel, top row first.
  void camera_view(const CameraPose& pose, msg::PixelFormat format, std::uint8_t* out);

  /// The room as it was placed, robot included (only with `picture`), as rgb8.
  void outside_view(const msg::Vec3& eye_m, const msg::Vec3& target_m, std::uint8_t* out);

  /// OpenGL's own description of itself.
  const std::string& backend() const;

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew::plant
