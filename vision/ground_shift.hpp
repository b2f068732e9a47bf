#pragma once
#include <optional>
#include <span>
#include <string_view>

#include "math/linear.hpp"
#include "vision/image_view.hpp"

namespace sinew::vision {

/// Three ways to say how far a whole picture moved between two frames, by elementary motion detection.
enum class ShiftBy : std::uint32_t {
  raw,       // equations 1 and 2 as they were published, averaged over the picture; grey levels squared
  contrast,  // the same without the mean brightness, divided by the variance of the grey values
  gradient,  // the pooled correlators divided by the texture's gradient: motion_grid.hpp; pixels
};
std::optional<ShiftBy> shift_by(std::string_view name);

/// One reading. `x`, `y`: > 0 where the picture moves right and down, in the detector's own unit.
///
/// The readings of `raw` and `contrast` rise with the shift up to a pixel or two and fall beyond (fast patterns look
/// slow); they need a gain, found on some texture, and are right only on texture like that: `raw` depends on contrast,
/// brightness of the scene and how fine the texture is, `contrast` on the last only. `gradient` depends on neither,
/// up to about a quarter of the texture's period a frame.
struct ShiftReading {
  double x = 0, y = 0;
  double contrast_grey = 0;  // standard deviation of the older picture
  bool seen = false;         // the gradient is more than noise
};

/// Both mono8, of one size, at least 8 pixels a side; otherwise nothing.
/// `noise_grey`: standard deviation of a pixel between two frames of a still scene.
/// `scratch`: room for both pictures. With it `gradient` moves both pictures by half of the shift so far, towards each
/// other, and measures what is left, five times: one quotient alone reads up to twice too much on texture as fine as
/// the pixels, since a difference over two pixels is less than the gradient there. What is left is the median of 12
/// parts of the picture: a joint along the way, or an edge of the ground, does not decide it.
/// Thread:  any.   RT: yes.
/// Source:  as elementary_motion.hpp and motion_grid.hpp.
std::optional<ShiftReading> read_shift(const ImageView& older, const ImageView& newer, ShiftBy by, double noise_grey,
                                       std::span<std::uint8_t> scratch = {});

/// The mean shift of a picture of a camera that only turns: pixels to the right and down.
/// `turn_rad`: rotation vector of the camera, optical frame (x right, y down, z along the view), small.
/// `focal_px`: of the same picture. The mean over the picture of the motion of a pinhole's pixels by a turn is
///     dx = -f wy (1 + w^2 / 12 f^2),   dy = f wx (1 + h^2 / 12 f^2).
/// Source:  H. C. Longuet-Higgins, K. Prazdny, "The interpretation of a moving retinal image", Proc. R. Soc. B 208
/// (1980)
///          385, with the squares averaged.
struct PixelShift {
  double x_px = 0, y_px = 0;
};
PixelShift shift_of_turn(const math::Vec3& turn_rad, double width_px, double height_px, double focal_px);

/// The bin (1, 2, 4 or 8) at which the wanted motion is at most `most_px` bins a frame; 8 where no bin is large enough.
/// With altURI's numbers (1 rad/s, 30 Hz, 90 degrees over 320 pixels: 5.3 pixels a frame) that is 8.
std::uint32_t bin_for(double motion_radps, double frame_s, double focal_px, double most_px);

}  // namespace sinew::vision
