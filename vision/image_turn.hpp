#pragma once
#include <optional>

#include "math/linear.hpp"
#include "vision/luma.hpp"
#include "vision/pinhole.hpp"

namespace sinew::vision {

/// How a camera turned between two pictures: the rotation that makes one lie best on the other, by Gauss-Newton on the
/// grey values of the whole picture, coarse to fine. The scene should stand still and be far: the camera's own travel
/// looks like a turn of travel / distance (across the line of sight only, not about it). Things that move in a part of
/// the picture, come in or leave, count little.
/// Frames:  camera_optical: z forward, x right, y down.
/// Source:  B. D. Lucas, T. Kanade, An iterative image registration technique with an application to stereo vision
///          (1981), with the motion of a rotating camera: the derivative of a pinhole's pixel by a small turn.
///          Weights: S. Geman, D. E. McClure, Statistical methods for tomographic image reconstruction (1987).
/// Thread:  owner.   RT: no bound worth naming (some ms); allocates only in the constructor.
class ImageTurn {
 public:
  struct Turn {
    math::Vec3 rotation_rad;  // q_older_newer as a rotation vector, of the camera
    double sigma_rad = 0;     // of its least certain axis, from the pixels' disagreement and the texture
    double disagreement = 0;  // of grey levels, after the fit
  };

  /// `fov_y_rad`: from top to bottom; a pinhole with square pixels and its axis in the middle.
  explicit ImageTurn(double fov_y_rad);
  /// Takes a picture (mono8 or yuyv). Returns the turn since the last picture; nothing for the first one, after a
  /// picture of another size, for a format that it does not read, or when the two do not fit each other.
  std::optional<Turn> add(const ImageView& image);
  void reset();

 private:
  struct Level {
    Luma older, newer;
  };
  double fov_y_rad_;
  std::uint32_t width_ = 0, height_ = 0;  // of the last picture
  Level fine_, coarse_;
};

}  // namespace sinew::vision
