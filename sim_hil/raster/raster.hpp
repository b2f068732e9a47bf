#pragma once
// Pictures of scenes of triangles, without a GPU and without a library: flat shading, a depth buffer, and what each
// pixel shows. The same bytes on every machine: additions, multiplications and divisions of IEEE doubles in the order
// written, and integers for what a triangle covers.
//
//   Raster picture(320, 240);
//   picture.look(camera);
//   picture.clear({135, 170, 210});
//   picture.draw(field, {}, {40, 120, 50}, kField);
//   picture.draw(ball, pose, {250, 120, 20}, kBall);
//   picture.rgb(0, 0);  picture.shown(160, 120) == kBall;
//
// Thread:  owner.
// Source:  J. Pineda, A parallel algorithm for polygon rasterization, SIGGRAPH 1988; fill rule: top-left, as OpenGL's
// and
//          Direct3D's with pixels at half coordinates.
#include <cstdint>
#include <span>
#include <vector>

#include "sim_hil/raster/mesh.hpp"

namespace sinew::raster {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// A pinhole camera: x right, y down, z into the picture.
struct Camera {
  kinematics::Pose pose;  // in the world
  double fx_px = 210, fy_px = 210, cx_px = 160, cy_px = 120;
  double near_m = 0.02;  // what is nearer is cut off
};

struct Light {
  math::Vec3 from{0.3, -0.2, 0.93};  // direction towards it, in the world
  double ambient = 0.55, diffuse = 0.45;
};

class Raster {
 public:
  /// At most 8192 on a side; sizes beyond are taken as that.
  Raster(std::uint32_t width, std::uint32_t height);

  void look(const Camera& camera);
  void light(const Light& light) { light_ = light; }
  /// Nothing is anywhere; every pixel shows 0.
  void clear(Colour sky);
  /// `shows`: a number from 1 to 255 that its pixels get. `on_surface`: it lies on what was drawn before (lines on a
  /// floor), and is seen where it is at most a 500th nearer or farther.
  void draw(const Mesh& mesh, const kinematics::Pose& pose, Colour colour, std::uint8_t shows, bool on_surface = false);

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  Colour rgb(std::uint32_t x, std::uint32_t y) const;
  std::uint8_t shown(std::uint32_t x, std::uint32_t y) const {
    return static_cast<std::uint8_t>(pixel_[std::size_t{y} * width_ + x] >> 24);
  }
  /// Along the camera's z, m; 0: nothing is there.
  double depth_m(std::uint32_t x, std::uint32_t y) const;
  /// Row after row from the top; a pixel is r | g << 8 | b << 16 | shows << 24.
  std::span<const std::uint32_t> pixels() const { return pixel_; }

 private:
  struct Corner {
    double x_px = 0, y_px = 0, nearness = 0;  // 1 / depth
  };
  void triangle(const Corner& a, const Corner& b, const Corner& c, std::uint32_t pixel, bool on_surface);
  void clipped(const math::Vec3& a, const math::Vec3& b, const math::Vec3& c, std::uint32_t pixel, bool on_surface);
  Corner projected(const math::Vec3& p) const;

  std::uint32_t width_, height_;
  Camera camera_;
  kinematics::Pose camera_world_;  // takes the world to the camera
  Light light_;
  std::vector<std::uint32_t> pixel_;
  std::vector<float> nearness_;
  std::vector<math::Vec3> seen_;  // points of the mesh that is drawn, in the camera's frame
  std::vector<Corner> corner_;    // and in the picture
};

}  // namespace sinew::raster
