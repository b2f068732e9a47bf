#include "identify/stand_fit.hpp"

#include <algorithm>

#include "identify/output_error.hpp"

namespace sinew::identify {
namespace {

using kinematics::Body;
using kinematics::BodyPose;
using kinematics::Place;
using kinematics::Pose;
using math::Quat;
using math::Vec3;

constexpr std::size_t kFewestPoses = 26;  // two more than there are numbers: intervals come from poses
constexpr std::size_t kRows = 14;         // of a pose: camera 6, right sole 6, gravity 2
constexpr double kMostZero_rad = 0.35, kMostSole_m = 0.03;
constexpr double kDifference_rad = 1e-5;
constexpr Quat kQOptical{0.5, -0.5, 0.5, -0.5};  // x ahead, y left, z up to x right, y down, z ahead
constexpr Quat kUpOfBoard{0, 1, 0, 0};           // half a turn about x: z up

using Rows = std::array<double, kRows>;

/// Everything that is found: first zeros, then soles, then where the feet are (x, y, heading each), then the IMU's
/// tilt.
struct Layout {
  std::vector<std::size_t> joint;  // of the body
  std::size_t soles() const { return joint.size(); }
  std::size_t feet() const { return soles() + 2; }
  std::size_t imu() const { return feet() + 6; }
  std::size_t size() const { return imu() + 2; }
};

/// A lower triangular L with L L^T = a, written over a. False: not positive definite.
bool cholesky(std::array<Rows, kRows>& a) {
  for (std::size_t i = 0; i < kRows; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = a[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      if (i == j && !(sum > 0)) return false;
      a[i][j] = i == j ? math::sqrt(sum) : sum / a[j][j];
    }
  return true;
}

class StandFitting {
 public:
  StandFitting(const StandRecord& record, const StandFitOptions& options)
      : r_(record), o_(options), body_(*record.body), pose_(body_) {}

  StandFit run() {
    fit_.problem = prepare();
    if (!fit_.problem.empty()) return fit_;
    std::vector<double> value = start();
    OutputFit found;
    for (int round = 0; round < 2; ++round) {  // the weights belong to angles; once more with better ones
      if (!weigh(value)) {
        fit_.problem = "a pose says nothing: its errors have no finite size";
        return fit_;
      }
      found = fit(value);
      value = found.value;
    }
    tell(found);
    return fit_;
  }

 private:
  std::string prepare() {
    left_ = body_.find_place("l_sole"), right_ = body_.find_place("r_sole"), imu_ = body_.find_place("imu");
    if (!left_ || !right_) return "the body has no places l_sole and r_sole";
    if (r_.poses.size() < kFewestPoses)
      return "only " + std::to_string(r_.poses.size()) + " poses, at least " + std::to_string(kFewestPoses) +
             " are needed";
    std::vector<bool> used(body_.links.size());
    for (const std::size_t end : {left_->link, right_->link, r_.camera_place.link})
      for (std::size_t l = end; l != 0; l = body_.links[l].parent) used[l] = true;
    for (std::size_t l = 1; l < used.size(); ++l)
      if (used[l]) layout_.joint.push_back(l - 1);
    for (std::size_t i = 0; i < r_.poses.size(); ++i) {
      const StandPose& p = r_.poses[i];
      if (p.joints_rad.size() != body_.joints()) return "pose " + std::to_string(i) + " has not all joints";
      const auto board = plane_pose(r_.camera, p.view);
      if (!board) return "pose " + std::to_string(i) + " does not show where the board is";
      camera_.push_back(board->inverse());
      has_accel_.push_back(imu_ && squared_norm(p.accel_mps2) > 1);
    }
    return {};
  }

  /// A sole on the ground, in the board's frame.
  Pose on_ground(const double* xyh) const {
    return {{xyh[0], xyh[1], 0}, kUpOfBoard * Quat::from_axis_angle({0, 0, 1}, xyh[2])};
  }
  /// The underside in link 0's frame; thicker soles are lower.
  Pose sole(const Place& place, double thicker_m) const { return pose_.place(place) * Pose{{0, 0, -thicker_m}, {}}; }

  /// What a pose's measurements are off by, for these values; `left_off`: of the left sole from where it is.
  Rows rows(std::size_t i, std::span<const double> v, std::span<const double> more_rad = {},
            const Pose& left_off = {}) {
    rad_ = r_.poses[i].joints_rad;
    for (std::size_t k = 0; k < layout_.joint.size(); ++k) rad_[layout_.joint[k]] -= v[k];
    for (std::size_t j = 0; j < more_rad.size(); ++j) rad_[j] += more_rad[j];
    pose_.set(rad_);
    const double* const feet = v.data() + layout_.feet();
    const Pose torso = on_ground(feet) * left_off * sole(*left_, v[layout_.soles()]).inverse();  // in the board's frame
    Rows out{};
    const auto put = [&](std::size_t at, const Pose& predicted, const Pose& measured) {
      const Vec3 p = predicted.q.conjugate().rotate(measured.p_m - predicted.p_m);
      const Vec3 turn = (predicted.q.conjugate() * measured.q).log();
      for (int a = 0; a < 3; ++a)
        out[at + static_cast<std::size_t>(a)] = p[a], out[at + 3 + static_cast<std::size_t>(a)] = turn[a];
    };
    const Pose camera = pose_.place(r_.camera_place);
    put(0, torso * Pose{camera.p_m, camera.q * kQOptical}, camera_[i]);
    put(6, torso * sole(*right_, v[layout_.soles() + 1]), on_ground(feet + 3));
    if (has_accel_[i]) {
      // Up in the IMU's axes, by the chain and the IMU's tilt against it.
      const Quat q = torso.q * pose_.place(*imu_).q * Quat::exp({v[layout_.imu()], v[layout_.imu() + 1], 0});
      const Vec3 up = q.conjugate().rotate({0, 0, -1}), seen = math::normalized(r_.poses[i].accel_mps2);
      const Vec3 off = cross(up, seen);
      out[12] = off.x, out[13] = off.y;
    }
    return out;
  }

  /// No zeros; the feet where the first pose has them.
  std::vector<double> start() {
    std::vector<double> v(layout_.size());
    pose_.set(r_.poses[0].joints_rad);
    const Pose camera = pose_.place(r_.camera_place);
    const Pose torso = camera_[0] * Pose{camera.p_m, camera.q * kQOptical}.inverse();
    for (std::size_t side = 0; side < 2; ++side) {
      const Pose at = torso * pose_.place(side == 0 ? *left_ : *right_);
      double* const xyh = v.data() + layout_.feet() + 3 * side;
      xyh[0] = at.p_m.x, xyh[1] = at.p_m.y, xyh[2] = (kUpOfBoard.conjugate() * at.q).yaw();
    }
    return v;
  }

  /// Of each pose: what its rows are uncertain by, as a Cholesky factor.
  bool weigh(std::span<const double> v) {
    factor_.clear();
    for (std::size_t i = 0; i < r_.poses.size(); ++i) {
      std::array<Rows, kRows> c{};
      const Rows here = rows(i, v);
      std::vector<double> more(body_.joints());
      for (const std::size_t j : layout_.joint) {
        more[j] = kDifference_rad;
        const Rows there = rows(i, v, more);
        more[j] = 0;
        for (std::size_t a = 0; a < kRows; ++a)
          for (std::size_t b = 0; b < kRows; ++b)
            c[a][b] += o_.joint_sigma_rad * o_.joint_sigma_rad * (there[a] - here[a]) * (there[b] - here[b]) /
                       (kDifference_rad * kDifference_rad);
      }
      add_pixels(i, c);
      for (std::size_t a = 0; a < 6; ++a) {
        // x, y, z, then turns about them: within the ground's plane it slips.
        const bool slips = a == 0 || a == 1 || a == 5;
        const double s =
            a < 3 ? (slips ? o_.slip_sigma_m : o_.flat_sigma_m) : (slips ? o_.slip_sigma_rad : o_.flat_sigma_rad);
        c[6 + a][6 + a] += s * s;
        Vec3 shift, turn;
        (a < 3 ? shift : turn)[static_cast<int>(a % 3)] = kDifference_rad;
        const Rows there = rows(i, v, {}, {shift, Quat::exp(turn)});
        for (std::size_t k = 0; k < kRows; ++k)
          for (std::size_t l = 0; l < kRows; ++l)
            c[k][l] += s * s * (there[k] - here[k]) * (there[l] - here[l]) / (kDifference_rad * kDifference_rad);
      }
      for (std::size_t a = 12; a < kRows; ++a) c[a][a] += has_accel_[i] ? o_.accel_sigma * o_.accel_sigma : 1;
      if (!cholesky(c)) return false;
      factor_.push_back(c);
    }
    return true;
  }

  /// How uncertain the camera's pose is by the corners: small turns and shifts of the camera in its own axes.
  void add_pixels(std::size_t i, std::array<Rows, kRows>& c) const {
    Dense normal(6, 6);
    const Pose board = camera_[i].inverse();
    for (const PlanePoint& p : r_.poses[i].view) {
      const Vec3 at = board.of({p.x_m, p.y_m, 0});
      if (!(at.z > 0)) continue;
      const double f = r_.camera.fx_px, x = at.x / at.z, y = at.y / at.z;
      const Vec3 by[2] = {{f / at.z, 0, -f * x / at.z}, {0, f / at.z, -f * y / at.z}};
      for (const Vec3& d : by) {
        const Vec3 turn = cross(d, at);  // of the camera: the point turns the other way
        const std::array<double, 6> row{-d.x, -d.y, -d.z, turn.x, turn.y, turn.z};
        for (std::size_t a = 0; a < 6; ++a)
          for (std::size_t b = 0; b < 6; ++b) normal(a, b) += row[a] * row[b] / (o_.pixel_sigma_px * o_.pixel_sigma_px);
      }
    }
    const auto inverse = inverse_of_positive(normal);
    for (std::size_t a = 0; a < 6; ++a)
      for (std::size_t b = 0; b < 6; ++b) c[a][b] += inverse ? (*inverse)(a, b) : (a == b ? 1.0 : 0.0);
  }

  OutputFit fit(const std::vector<double>& value) {
    const std::size_t n = r_.poses.size();
    OutputProblem problem;
    problem.channels = 1, problem.blocks = n;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t a = 0; a < kRows; ++a) {
        problem.measured.push_back(a < 12 || has_accel_[i] ? 0 : math::kNan);
        problem.channel.push_back(0);
        problem.block.push_back(static_cast<std::uint32_t>(i));
      }
    problem.run = [&](std::span<const double> v, std::span<double> out) {
      for (std::size_t i = 0; i < n; ++i) {
        Rows e = rows(i, v);
        for (std::size_t a = 0; a < kRows; ++a) {  // L x = e
          for (std::size_t b = 0; b < a; ++b) e[a] -= factor_[i][a][b] * e[b];
          e[a] /= factor_[i][a][a];
          out[i * kRows + a] = e[a];
        }
      }
    };
    std::vector<FreeParameter> free;
    for (std::size_t k = 0; k < layout_.size(); ++k) {
      const bool is_sole = k >= layout_.soles() && k < layout_.feet();
      const bool is_foot = k >= layout_.feet() && k < layout_.imu();
      FreeParameter p;
      p.value = value[k];
      const double most = is_sole ? kMostSole_m : is_foot ? 20 : kMostZero_rad;
      p.least = -most, p.most = most;
      p.step = is_sole ? 1e-5 : 1e-5;
      p.scale = is_sole ? o_.open_m : is_foot ? 0.1 : o_.open_rad;
      free.push_back(p);
    }
    return fit_outputs(problem, free, {.most_rounds = 40, .settled = 1e-8});
  }

  void tell(const OutputFit& found) {
    fit_.poses = r_.poses.size();
    for (std::size_t k = 0; k < layout_.feet(); ++k) {
      StandEstimate e;
      const bool is_sole = k >= layout_.soles();
      e.name = is_sole ? (k == layout_.soles() ? "l_sole" : "r_sole") : body_.links[layout_.joint[k] + 1].name;
      e.value = found.value[k];
      e.half_width = math::hypot(found.quantile * math::sqrt(found.covariance(k, k)), is_sole ? 0 : o_.common_rad);
      e.shown = e.half_width < (is_sole ? o_.open_m : o_.open_rad);
      if (!e.shown) fit_.unknown.push_back(e.name + ": open by more than " + (is_sole ? "5 mm" : "1 degree"));
      fit_.estimates.push_back(e);
    }
    fit_.after_rad = camera_off(found.value);
    std::vector<double> none = found.value;
    std::fill_n(none.begin(), layout_.feet(), 0.0);
    fit_.before_rad = camera_off_of_best_feet(none);
  }

  /// Of the camera's attitude.
  double camera_off(std::span<const double> v) {
    double sum = 0;
    for (std::size_t i = 0; i < r_.poses.size(); ++i) {
      const Rows e = rows(i, v);
      sum += e[3] * e[3] + e[4] * e[4] + e[5] * e[5];
    }
    return math::sqrt(sum / static_cast<double>(r_.poses.size()));
  }
  /// With the left foot's heading that suits the camera best.
  double camera_off_of_best_feet(std::vector<double> v) {
    double best = math::kInf;
    const double middle = v[layout_.feet() + 2];
    for (int i = -100; i <= 100; ++i) {
      v[layout_.feet() + 2] = middle + 0.002 * i;
      best = std::min(best, camera_off(v));
    }
    return best;
  }

  const StandRecord& r_;
  StandFitOptions o_;
  const Body& body_;
  BodyPose pose_;
  const Place *left_ = nullptr, *right_ = nullptr, *imu_ = nullptr;
  Layout layout_;
  std::vector<Pose> camera_;  // in the board's frame, by the corners
  std::vector<bool> has_accel_;
  std::vector<std::array<Rows, kRows>> factor_;
  std::vector<double> rad_;
  StandFit fit_;
};

}  // namespace

StandFit fit_stand(const StandRecord& record, const StandFitOptions& options) {
  if (!record.body || record.body->links.empty()) {
    StandFit none;
    none.problem = "no body is given";
    return none;
  }
  return StandFitting(record, options).run();
}

std::vector<double> corrected(const StandFit& fit, const Body& body, std::span<const double> measured_rad) {
  std::vector<double> rad(measured_rad.begin(), measured_rad.end());
  for (const StandEstimate& e : fit.estimates)
    if (const auto link = body.find_link(e.name); link && *link > 0 && *link - 1 < rad.size())
      rad[*link - 1] -= e.value;
  return rad;
}

}  // namespace sinew::identify
