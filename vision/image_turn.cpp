#include "vision/image_turn.hpp"

#include <algorithm>
#include <array>

namespace sinew::vision {
namespace {

using math::Mat;
using math::Quat;
using math::Vec3;

constexpr std::uint32_t kFineWidth = 200;  // pixels, at most: bins are chosen for it
constexpr int kIterations = 12;
constexpr double kSame = 12;         // grey levels; points that differ by more are hardly the same
constexpr double kDone_rad = 1e-5;   // a step below it is no step
constexpr double kMost_rad = 0.35;   // between two pictures
constexpr double kLeastShare = 0.4;  // of the picture, seen in both
constexpr double kCertain_rad = 0.003;

/// Grey value between pixels, and how it changes to the right and down. False: outside.
bool grey(const ImageView& image, double u, double v, double& value, double& du, double& dv) {
  if (!(u >= 1) || !(v >= 1) || u >= image.width - 2.0 || v >= image.height - 2.0) return false;
  const auto x = static_cast<std::uint32_t>(u), y = static_cast<std::uint32_t>(v);
  const double a = u - x, b = v - y;
  const std::uint8_t *r0 = image.row(y) + x, *r1 = image.row(y + 1) + x;
  const std::uint8_t *up = image.row(y - 1) + x, *down = image.row(y + 2) + x;
  const auto mix = [](double p, double q, double t) { return p + t * (q - p); };
  value = mix(mix(r0[0], r0[1], a), mix(r1[0], r1[1], a), b);
  // Central differences, as smooth as the value.
  du = 0.5 * mix(mix(r0[1] - r0[-1], r0[2] - r0[0], a), mix(r1[1] - r1[-1], r1[2] - r1[0], a), b);
  dv = 0.5 * mix(mix(r1[0] - up[0], r1[1] - up[1], a), mix(down[0] - r0[0], down[1] - r0[1], a), b);
  return true;
}

/// The weight of a difference. First Huber's weights, which converge from far; at last those of Geman and McClure,
/// which nearly ignore what does not fit.
enum class Weights : std::uint8_t { wide, strict };
double weight(Weights which, double residual) {
  const double r = math::fabs(residual) / kSame;
  if (which == Weights::wide) return r > 1 ? 1 / r : 1;
  const double share = 1 / (1 + r * r);
  return share * share;
}

/// Sums of one iteration: least squares for a turn and one common change of brightness.
struct Sums {
  Mat<4, 4> normal;
  Mat<4, 1> right;
  double weights = 0, squares = 0;

  void add(const std::array<double, 4>& row, double residual, double w) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) normal(i, j) += w * row[i] * row[j];
      right(i) += w * row[i] * residual;
    }
    weights += w;
    squares += w * residual * residual;
  }
};

Sums compare(const ImageView& older, const ImageView& newer, const Pinhole& camera, const Quat& q_older_newer,
             double brighter, Weights which) {
  Sums sums;
  const math::Mat3 r = q_older_newer.matrix();
  const std::uint32_t step = which == Weights::wide ? 2 : 1;  // `wide` needs only a quarter of the pixels
  for (std::uint32_t v = 0; v < newer.height; v += step)
    for (std::uint32_t u = 0; u < newer.width; u += step) {
      const Vec3 d = r * Vec3{(u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px, 1};
      if (d.z < 0.1) continue;
      const double x = d.x / d.z, y = d.y / d.z;
      double value = 0, du = 0, dv = 0;
      if (!grey(older, camera.cx_px + camera.fx_px * x, camera.cy_px + camera.fy_px * y, value, du, dv)) continue;
      du *= camera.fx_px, dv *= camera.fy_px;
      const double residual = newer.row(v)[u] - value - brighter;
      sums.add({-x * y * du - (1 + y * y) * dv, (1 + x * x) * du + x * y * dv, -y * du + x * dv, 1}, residual,
               weight(which, residual));
    }
  return sums;
}

/// The state of the search.
struct Guess {
  Quat q_older_newer;
  double brighter = 0;
};

/// Turns the guess until the pictures agree. False: they do not.
bool align(const ImageView& older, const ImageView& newer, double fov_y_rad, Weights which, Guess& guess,
           ImageTurn::Turn& turn) {
  const Pinhole camera = Pinhole::from_fov(fov_y_rad, newer.width, newer.height);
  const double least = kLeastShare * newer.width * newer.height / (which == Weights::wide ? 4 : 1);
  for (int i = 1;; ++i) {
    const Sums sums = compare(older, newer, camera, guess.q_older_newer, guess.brighter, which);
    const auto step = math::solve(sums.normal, sums.right);
    if (!step || sums.weights < least) return false;
    const Vec3 by{(*step)(0), (*step)(1), (*step)(2)};
    guess.q_older_newer = (Quat::exp(by) * guess.q_older_newer).normalized();
    guess.brighter += (*step)(3);
    if (!math::is_finite(by) || norm(guess.q_older_newer.log()) > kMost_rad) return false;
    if (norm(by) > kDone_rad && i < kIterations) continue;
    const auto spread = math::inverse(sums.normal);
    if (!spread) return false;
    const double variance = sums.squares / sums.weights;
    turn.disagreement = math::sqrt(variance);
    turn.sigma_rad = math::sqrt(variance * std::max({(*spread)(0, 0), (*spread)(1, 1), (*spread)(2, 2)}));
    return true;
  }
}

}  // namespace

ImageTurn::ImageTurn(double fov_y_rad) : fov_y_rad_(fov_y_rad) {
  constexpr std::size_t kMost = std::size_t{msg::kMaxImageWidth} * msg::kMaxImageHeight;
  for (Level* level : {&fine_, &coarse_}) level->older = level->newer = Luma(kMost);
}

void ImageTurn::reset() {
  for (Level* level : {&fine_, &coarse_}) level->older.clear(), level->newer.clear();
}

std::optional<ImageTurn::Turn> ImageTurn::add(const ImageView& image) {
  const bool same_size = image.width == width_ && image.height == height_;
  width_ = image.width, height_ = image.height;
  const std::uint32_t bin = image.width > 2 * kFineWidth ? 4 : image.width > kFineWidth ? 2 : 1;
  for (Level* level : {&fine_, &coarse_}) level->older.swap(level->newer);
  if (!fine_.newer.take(image, bin) || !coarse_.newer.take(fine_.newer.view(), 2)) {
    reset();
    return std::nullopt;
  }
  const ImageView before = fine_.older.view(), now = fine_.newer.view();
  if (!before || !same_size) return std::nullopt;
  Guess guess;
  Turn turn;
  if (!align(coarse_.older.view(), coarse_.newer.view(), fov_y_rad_, Weights::wide, guess, turn) ||
      !align(before, now, fov_y_rad_, Weights::wide, guess, turn) ||
      !align(before, now, fov_y_rad_, Weights::strict, guess, turn) || turn.sigma_rad > kCertain_rad)
    return std::nullopt;
  turn.rotation_rad = guess.q_older_newer.log();
  return turn;
}

}  // namespace sinew::vision
