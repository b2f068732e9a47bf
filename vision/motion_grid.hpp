#pragma once
#include <array>

#include "msg/flight.hpp"
#include "vision/elementary_motion.hpp"

namespace sinew::vision {

struct MotionOptions {
  double noise_grey = 2.0;        // standard deviation of a pixel between two frames of a still scene, grey levels
  double significance = 6.0;      // a cell moves when its speed is this many standard deviations of noise, and
  double min_speed_px = 0.15;     // at least this fast, pixels per frame
  double moving_fraction = 0.25;  // the image moves when this share of the cells with texture does
};

/// Tells travelling from shaking: running motors shake a camera by most of a pixel from frame to frame, to and fro. The
/// image travels when its speed, smoothed over a few frames, is large enough; a fast image travels at once.
/// Thread:  owner.   RT: yes.
class TravelDetector {
 public:
  struct Options {
    double smoothing = 0.25;  // weight of the newest frame
    double speed_px = 0.5;    // per frame, smoothed
  };
  /// `field`: of every frame, in order. Answers whether the image travels.
  bool update(const msg::MotionField& field, const Options& options);
  void reset() { x_px_ = y_px_ = 0; }

 private:
  double x_px_ = 0, y_px_ = 0;
};

/// One cell's sums without the terms that are not motion.
struct CellMotion {
  double tx = 0, ty = 0;             // sum of (newer - older) * g: the correlator without its boundary terms
  double gxx = 0, gxy = 0, gyy = 0;  // sums of products of g, the gradient of both frames' sum over two pixels
  std::uint32_t pixels = 0;
};

/// How a pattern moved between two frames, from the correlators of elementary_motion.hpp, pooled to the message's grid.
///
/// Inside of a cell, 2 sum(Mx) and sum((newer - older) * g) differ only by terms on the cell's border. These depend on
/// the pixels at the border, not on motion, and are taken off exactly. Then, for a shift by d = (dx, dy):
///     -4 sum((newer - older) * g) = G d,   G = sums of g * g^T,
/// solved per cell for the grid and over all textured cells for the speed. A uniform change of brightness is taken out
/// as well (means of newer - older and of g).
///
/// It can:    tell motion from none, its direction, and speeds up to about a quarter of the texture's period per frame.
/// It cannot: follow faster patterns (they look slower, then reversed; use bins of pixels), see motion along a lone
///            edge (aperture), or tell the camera's turning from its travelling. Noise in a dim or plain picture makes
///            it slow: noise adds to G and nothing to the correlator.
/// Source:  W. Reichardt, "Evaluation of optical motion information by movement detectors", J. Comp. Physiol. A 161
///          (1987) 533 (pooled correlators; dependence on texture); B. Lucas, T. Kanade, IJCAI 1981 (the quotient).
/// `moving` says that the two frames differ by more than noise; see TravelDetector for more than two.
/// Thread:  any.   RT: yes.
/// Errors:  false when the frames differ in size or have less than 8 pixels a cell; `out` is then untouched.
bool estimate_motion(const ImageView& older, const ImageView& newer, const MotionOptions& options,
                     msg::MotionField& out, Simd simd = best_simd());

namespace detail {
CellMotion cell_motion(const ImageView& older, const ImageView& newer, const PixelRect& cell, Simd simd);
}

}  // namespace sinew::vision
