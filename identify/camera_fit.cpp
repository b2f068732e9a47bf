#include "identify/camera_fit.hpp"

#include <algorithm>

#include "identify/homography.hpp"
#include "identify/plane_slopes.hpp"
#include "identify/robust.hpp"
#include "identify/student.hpp"

namespace sinew::identify {
namespace {

using kinematics::Pose;
using math::Quat;
using math::Vec3;

constexpr double kLeastSigma_px = 1e-4;  // no picture is as exact as this
constexpr int kMostRounds = 60;
constexpr double kSettled = 1e-9;    // the cost falls by a smaller share: done
constexpr double kFocalOpen = 0.05;  // a 95 % interval of more than this share says nothing
constexpr double kCentreOpen = 0.1;  // of the picture's width
constexpr double kReached = 0.75;
constexpr double kDeg = 180 / math::kPi;
constexpr std::size_t kFirstOfLens = 4;

std::array<double, kCameraNumbers> values_of(const LensCamera& c) {
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.lens.k1, c.lens.k2, c.lens.p1, c.lens.p2};
}

LensCamera camera_of(const std::array<double, kCameraNumbers>& v) {
  return {v[0], v[1], v[2], v[3], {v[4], v[5], v[6], v[7], 0}};
}

/// Sums of one view: camera, pose, and between them.
struct ViewSums {
  Dense camera, both, pose;  // n x n, n x 6, 6 x 6
  std::vector<double> camera_by, pose_by;
};

class ViewFitter {
 public:
  ViewFitter(std::span<const PlaneView> views, const CameraFitOptions& options) : views_(views), o_(options) {}

  /// From the closed form (0), or from a camera with this many widths of focal length. False: no start.
  bool start(double widths) {
    std::vector<math::Mat3> all;
    for (const PlaneView& view : views_) {
      const auto h = homography(view);
      if (!h) return false;
      all.push_back(*h);
    }
    const double f = widths * o_.width_px;
    camera_ = {f, f, 0.5 * (o_.width_px - 1), 0.5 * (o_.height_px - 1), {}};
    if (widths == 0) {
      const auto closed = closed_form_camera(all, o_.width_px, o_.height_px);
      if (!closed) return false;
      camera_ = *closed;
    }
    pose_.clear();
    for (const math::Mat3& h : all) {
      const auto pose = pose_of(h, camera_);
      if (!pose) return false;
      pose_.push_back(*pose);
    }
    return true;
  }

  /// With these numbers free, the best of several starts. False: none leads to a camera.
  bool search(const std::vector<std::size_t>& free) {
    double least = math::kInf;
    ViewFitter best = *this;
    for (const double widths : {0.0, 0.7, 1.2, 2.5}) {
      // First the lens' largest part alone: the others want to explain what only it can.
      ViewFitter next(views_, o_);
      std::vector<std::size_t> first{0, 1};
      if (!next.start(widths) || !next.run(first)) continue;
      if (std::find(free.begin(), free.end(), kFirstOfLens) != free.end()) first.push_back(kFirstOfLens);
      if (!next.run(first) || !next.run(free)) continue;
      double sum = 0;
      for (const double e : next.error_) sum += e * e;
      if (sum < least) least = sum, best = std::move(next);
    }
    if (!math::is_finite(least)) return false;
    camera_ = best.camera_, pose_ = std::move(best.pose_);
    return run(free);
  }

  /// With these numbers free. False: it went nowhere.
  bool run(std::vector<std::size_t> free) {
    free_ = std::move(free);
    sigma_ = 0;
    double cost = 0;
    if (!errors(camera_, pose_, nullptr)) return false;
    double lambda = 1e-3;
    for (int round = 0; round < kMostRounds; ++round) {
      errors(camera_, pose_, &error_);
      sigma_ = sigma_of(error_);
      cost = cost_of(error_);
      collect();
      bool better = false;
      double there = cost;
      for (int tries = 0; tries < 10 && !better; ++tries) {
        LensCamera camera;
        std::vector<Pose> pose;
        better = stepped(lambda, camera, pose);
        std::vector<double> error;
        better = better && errors(camera, pose, &error) && (there = cost_of(error)) < cost;
        if (better) {
          camera_ = camera, pose_ = std::move(pose);
          lambda = std::max(0.1 * lambda, 1e-12);
        } else {
          lambda *= 10;
        }
      }
      if (!better || cost - there < kSettled * cost) break;
    }
    errors(camera_, pose_, &error_);
    sigma_ = sigma_of(error_);
    collect();
    return true;
  }

  /// Half-widths of the free numbers; infinite where nothing is shown.
  std::array<double, kCameraNumbers> half_widths() const;

  const LensCamera& camera() const { return camera_; }
  const std::vector<Pose>& pose() const { return pose_; }
  const std::vector<double>& error() const { return error_; }
  double sigma() const { return sigma_; }

 private:
  bool errors(const LensCamera& camera, const std::vector<Pose>& pose, std::vector<double>* out) const {
    if (out) out->clear();
    for (std::size_t i = 0; i < views_.size(); ++i)
      for (const PlanePoint& p : views_[i]) {
        LensCamera::Pixel at;
        if (!predict(camera, pose[i], p, at, nullptr)) return false;
        if (out) out->push_back(p.u_px - at.u_px), out->push_back(p.v_px - at.v_px);
      }
    return true;
  }
  double sigma_of(const std::vector<double>& error) const {
    std::vector<double> size;
    for (const double e : error) size.push_back(math::fabs(e));
    const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
    std::nth_element(size.begin(), middle, size.end());
    const double used = static_cast<double>(size.size()),
                 freedom = used - static_cast<double>(free_.size() + 6 * views_.size());
    return std::max(kSigmaOfMedian * *middle * math::sqrt(used / std::max(1.0, freedom)), kLeastSigma_px);
  }
  double cost_of(const std::vector<double>& error) const {
    double sum = 0;
    for (const double x : error) {
      const double e = math::fabs(x) / sigma_;
      sum += e < kHuber ? e * e : kHuber * (2 * e - kHuber);
    }
    return sum;
  }
  double weight(double error) const {
    const double e = math::fabs(error) / sigma_;
    return (e > kHuber ? kHuber / e : 1) / (sigma_ * sigma_);
  }
  /// A change of a number that is worth 1.
  double scale(std::size_t number) const { return number < kFirstOfLens ? o_.width_px : 1.0; }

  void collect();
  bool stepped(double lambda, LensCamera& camera, std::vector<Pose>& pose) const;
  /// Of the free numbers, the poses taken out.
  void reduce(double lambda, Dense& normal, std::vector<double>& by, Dense* of_views) const;

  std::span<const PlaneView> views_;
  CameraFitOptions o_;
  std::vector<std::size_t> free_;
  LensCamera camera_;
  std::vector<Pose> pose_;
  std::vector<double> error_;
  double sigma_ = 0;
  std::vector<ViewSums> sums_;
};

void ViewFitter::collect() {
  const std::size_t n = free_.size();
  sums_.clear();
  std::size_t next = 0;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    ViewSums s{Dense(n, n), Dense(n, 6), Dense(6, 6), std::vector<double>(n), std::vector<double>(6)};
    for (const PlanePoint& p : views_[i]) {
      LensCamera::Pixel at;
      Slopes slopes;
      predict(camera_, pose_[i], p, at, &slopes);
      for (int k = 0; k < 2; ++k) {
        const double e = error_[next++], w = weight(e);
        for (std::size_t a = 0; a < n; ++a) {
          const double of_a = slopes.camera[k][free_[a]] * scale(free_[a]);
          s.camera_by[a] += w * of_a * e;
          for (std::size_t b = 0; b < n; ++b) s.camera(a, b) += w * of_a * slopes.camera[k][free_[b]] * scale(free_[b]);
          for (std::size_t b = 0; b < 6; ++b) s.both(a, b) += w * of_a * slopes.pose[k][b];
        }
        for (std::size_t a = 0; a < 6; ++a) {
          s.pose_by[a] += w * slopes.pose[k][a] * e;
          for (std::size_t b = 0; b < 6; ++b) s.pose(a, b) += w * slopes.pose[k][a] * slopes.pose[k][b];
        }
      }
    }
    sums_.push_back(std::move(s));
  }
}

void ViewFitter::reduce(double lambda, Dense& normal, std::vector<double>& by, Dense* of_views) const {
  const std::size_t n = free_.size();
  normal = Dense(n, n);
  by.assign(n, 0);
  if (of_views) *of_views = Dense(n, n);
  for (const ViewSums& s : sums_) {
    Dense pose = s.pose;
    for (std::size_t a = 0; a < 6; ++a) pose(a, a) *= 1 + lambda;
    const auto inverse = inverse_of_positive(pose);
    if (!inverse) continue;  // a view that does not show its own pose shows nothing else
    std::vector<double> own = s.camera_by;
    for (std::size_t a = 0; a < n; ++a) {
      std::array<double, 6> through{};  // both * inverse
      for (std::size_t b = 0; b < 6; ++b)
        for (std::size_t c = 0; c < 6; ++c) through[b] += s.both(a, c) * (*inverse)(c, b);
      for (std::size_t b = 0; b < 6; ++b) own[a] -= through[b] * s.pose_by[b];
      for (std::size_t b = 0; b < n; ++b) {
        double less = 0;
        for (std::size_t c = 0; c < 6; ++c) less += through[c] * s.both(b, c);
        normal(a, b) += s.camera(a, b) * (a == b ? 1 + lambda : 1) - less;
      }
      by[a] += own[a];
    }
    if (of_views)
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) (*of_views)(a, b) += own[a] * own[b];
  }
}

bool ViewFitter::stepped(double lambda, LensCamera& camera, std::vector<Pose>& pose) const {
  Dense normal;
  std::vector<double> by;
  reduce(lambda, normal, by, nullptr);
  const auto step = solve_positive(normal, by);
  if (!step) return false;
  auto v = values_of(camera_);
  for (std::size_t a = 0; a < free_.size(); ++a) v[free_[a]] += (*step)[a] * scale(free_[a]);
  for (std::size_t k = 0; k < 2; ++k)
    if (!(v[k] > 0.1 * o_.width_px) || !(v[k] < 50 * o_.width_px)) return false;
  for (std::size_t k = kFirstOfLens; k < kCameraNumbers; ++k)
    if (!(math::fabs(v[k]) < 50)) return false;
  camera = camera_of(v);
  pose.clear();
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const ViewSums& s = sums_[i];
    Dense own = s.pose;
    std::vector<double> right = s.pose_by;
    for (std::size_t a = 0; a < 6; ++a) {
      own(a, a) *= 1 + lambda;
      for (std::size_t b = 0; b < free_.size(); ++b) right[a] -= s.both(b, a) * (*step)[b];
    }
    const auto turn = solve_positive(own, right);
    if (!turn) return false;
    pose.push_back(moved(pose_[i], turn->data()));
  }
  return true;
}

std::array<double, kCameraNumbers> ViewFitter::half_widths() const {
  std::array<double, kCameraNumbers> out{};
  for (const std::size_t number : free_) out[number] = math::kInf;
  Dense normal, of_views;
  std::vector<double> by;
  reduce(0, normal, by, &of_views);
  const auto inverse = inverse_of_positive(normal);
  const auto views = static_cast<double>(views_.size());
  if (!inverse) return out;
  const std::size_t n = free_.size();
  for (std::size_t a = 0; a < n; ++a) {
    // By the size of the errors alone, and by how much the views contradict each other.
    double together = 0;
    for (std::size_t b = 0; b < n; ++b)
      for (std::size_t c = 0; c < n; ++c) together += (*inverse)(a, b) * of_views(b, c) * (*inverse)(c, a);
    together *= views / std::max(1.0, views - 1);
    const double variance = std::max((*inverse)(a, a), together);
    if (variance > 0 && math::is_finite(variance))
      out[free_[a]] = student_95(views - 1) * math::sqrt(variance) * scale(free_[a]);
  }
  return out;
}

/// Of plane normals as the camera saw them.
double largest_tilt_deg(const std::vector<Pose>& planes) {
  double least = 1;
  for (std::size_t i = 0; i < planes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, dot(planes[i].q.rotate({0, 0, 1}), planes[j].q.rotate({0, 0, 1})));
  return math::acos(std::clamp(least, -1.0, 1.0)) * kDeg;
}

double rms(const std::vector<double>& errors, std::size_t from, std::size_t until) {
  double sum = 0;
  for (std::size_t i = from; i < until; ++i) sum += errors[i] * errors[i];
  return until > from ? math::sqrt(2 * sum / static_cast<double>(until - from)) : math::kNan;
}

std::string whole(double x) { return std::to_string(static_cast<int>(x + 0.5)); }

std::string problem_of(std::span<const PlaneView> views, const CameraFitOptions& o) {
  if (!(o.width_px > 0) || !(o.height_px > 0)) return "the picture's size is not known";
  if (views.size() < 3) return "only " + std::to_string(views.size()) + " views, at least 3 are needed";
  std::size_t points = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const PlanePoint& p : views[i])
      if (!math::is_finite(p.x_m + p.y_m + p.u_px + p.v_px))
        return "view " + std::to_string(i) + " has a number that is not finite";
    if (!homography(views[i]))
      return "view " + std::to_string(i) + " has fewer than 4 points, or all in a line: nothing can be said from it";
    points += views[i].size();
  }
  if (2 * points < kCameraNumbers + 6 * views.size() + 4) return "too few points in all views together";
  return {};
}

class CameraFitting {
 public:
  CameraFitting(std::span<const PlaneView> views, const CameraFitOptions& o) : views_(views), o_(o) {}

  CameraFit run() {
    fit_.problem = problem_of(views_, o_);
    if (!fit_.problem.empty()) return fit_;
    std::vector<std::size_t> free{0, 1, 2, 3, 4, 5, 6, 7};
    ViewFitter fitter(views_, o_);
    if (!fitter.search(free))
      return failed("no camera could have seen these views: are the points in the right order?");
    radius_ = radius_of(fitter);
    std::array<double, kCameraNumbers> half = fitter.half_widths();
    // Coefficients that are left open, and may be 0, are held there, the weakest first.
    while (true) {
      std::size_t worst = kCameraNumbers;
      double most = o_.open_px;
      for (const std::size_t number : free)
        if (number >= kFirstOfLens && math::fabs(values_of(fitter.camera())[number]) < half[number] &&
            effect_px(fitter.camera(), number, half[number]) > most)
          worst = number, most = effect_px(fitter.camera(), number, half[number]);
      if (worst == kCameraNumbers) break;
      std::erase(free, worst);
      if (!fitter.search(free)) return failed("a view is of something behind the camera");
      half = fitter.half_widths();
    }
    tell(fitter, free, half);
    predict_others(free);
    return fit_;
  }

 private:
  CameraFit failed(std::string why) {
    fit_.problem = std::move(why);
    return fit_;
  }

  double radius_of(const ViewFitter& fitter) const {
    double most = 0;
    for (std::size_t i = 0; i < views_.size(); ++i)
      for (const PlanePoint& p : views_[i]) {
        const Vec3 at = fitter.pose()[i].of({p.x_m, p.y_m, 0});
        most = std::max(most, math::hypot(at.x, at.y) / at.z);
      }
    return most;
  }

  /// How many pixels such a change of a coefficient moves the outermost point.
  double effect_px(const LensCamera& c, std::size_t number, double change) const {
    const double r = radius_, f = std::max(c.fx_px, c.fy_px);
    switch (static_cast<CameraNumber>(number)) {
      case CameraNumber::k1:
        return f * r * r * r * change;
      case CameraNumber::k2:
        return f * r * r * r * r * r * change;
      default:
        return f * 3 * r * r * change;
    }
  }

  void tell(const ViewFitter& fitter, const std::vector<std::size_t>& free,
            const std::array<double, kCameraNumbers>& half) {
    fit_.camera = fitter.camera();
    fit_.plane = fitter.pose();
    fit_.views = views_.size();
    std::size_t next = 0;
    for (const PlaneView& view : views_) {
      fit_.points += view.size();
      fit_.view_rms_px.push_back(rms(fitter.error(), next, next + 2 * view.size()));
      next += 2 * view.size();
    }
    fit_.rms_px = rms(fitter.error(), 0, next);
    fit_.sigma_px = fitter.sigma();
    fit_.tilt_deg = largest_tilt_deg(fit_.plane);
    const auto values = values_of(fit_.camera);
    for (std::size_t i = 0; i < kCameraNumbers; ++i) {
      CameraEstimate& e = fit_.estimates[i];
      const bool is_free = std::find(free.begin(), free.end(), i) != free.end();
      const double open = i < 2 ? kFocalOpen * values[i] : kCentreOpen * o_.width_px;
      e = {values[i], is_free ? half[i] : math::kInf, is_free && (i >= kFirstOfLens || half[i] < open)};
    }
    double outer = 0, corner = 0;
    for (const PlaneView& view : views_)
      for (const PlanePoint& p : view)
        outer = std::max(outer, math::hypot(p.u_px - fit_.camera.cx_px, p.v_px - fit_.camera.cy_px));
    for (const double u : {0.0, o_.width_px - 1})
      for (const double v : {0.0, o_.height_px - 1})
        corner = std::max(corner, math::hypot(u - fit_.camera.cx_px, v - fit_.camera.cy_px));
    fit_.reach = outer / corner;
    name_unknown();
  }

  void name_unknown() {
    const auto names = [&](std::size_t from, std::size_t until) {
      std::string text;
      for (std::size_t i = from; i < until; ++i)
        if (!fit_.estimates[i].shown) text += (text.empty() ? "" : ", ") + std::string(camera_numbers()[i].name);
      return text;
    };
    const std::string from_where = "tilt it by 20 degrees and more about both of its axes, and record more views";
    if (const std::string f = names(0, 2); !f.empty())
      fit_.unknown.push_back(f + ": a focal length and the distance stand for each other; " + from_where);
    if (const std::string c = names(2, 4); !c.empty())
      fit_.unknown.push_back(c + ": the axis' place and a turn stand for each other; " + from_where);
    const std::string reach =
        "the outermost point is " + whole(100 * fit_.reach) + " % of the way from the axis to the picture's corner";
    if (const std::string l = names(4, kCameraNumbers); !l.empty())
      fit_.unknown.push_back(l + ": held at 0; " + reach + ", and there they would be open by more than " +
                             whole(o_.open_px) + " pixels");
    if (fit_.reach < kReached) fit_.unknown.push_back("the lens beyond what was seen: " + reach);
  }

  void predict_others(const std::vector<std::size_t>& free) {
    fit_.held_out_rms_px = math::kNan;
    if (o_.held_out_each < 2) return;
    std::vector<PlaneView> kept, out;
    for (std::size_t i = 0; i < views_.size(); ++i)
      (i % o_.held_out_each == o_.held_out_each - 1 ? out : kept).push_back(views_[i]);
    if (out.empty() || kept.size() < 3) return;
    ViewFitter fitter(kept, o_);
    if (!fitter.search(free)) return;
    double sum = 0;
    std::size_t points = 0;
    for (const PlaneView& view : out) {
      const auto pose = plane_pose(fitter.camera(), view);
      if (!pose) continue;
      for (const PlanePoint& p : view) {
        LensCamera::Pixel at;
        if (!predict(fitter.camera(), *pose, p, at, nullptr)) continue;
        sum += (p.u_px - at.u_px) * (p.u_px - at.u_px) + (p.v_px - at.v_px) * (p.v_px - at.v_px);
        ++points;
      }
    }
    if (points > 0) fit_.held_out_rms_px = math::sqrt(sum / static_cast<double>(points));
  }

  std::span<const PlaneView> views_;
  CameraFitOptions o_;
  CameraFit fit_;
  double radius_ = 0;  // of the outermost point, divided by its depth
};

}  // namespace

const std::array<CameraNumberText, kCameraNumbers>& camera_numbers() {
  static constexpr std::array<CameraNumberText, kCameraNumbers> all{{
      {"fx", "px", "focal length across"},
      {"fy", "px", "focal length down"},
      {"cx", "px", "where the axis meets the picture, across"},
      {"cy", "px", "and down"},
      {"k1", "1", "radial, by the radius squared"},
      {"k2", "1", "radial, by its fourth power"},
      {"p1", "1", "tangential, down"},
      {"p2", "1", "tangential, across"},
  }};
  return all;
}

CameraFit fit_camera(std::span<const PlaneView> views, const CameraFitOptions& options) {
  return CameraFitting(views, options).run();
}

}  // namespace sinew::identify
