#include "identify/iron_fit.hpp"

#include <algorithm>

#include "identify/dense.hpp"
#include "identify/robust.hpp"
#include "identify/student.hpp"

namespace sinew::identify {
namespace {

using math::Mat3;
using math::Vec3;

constexpr std::size_t kLeastReadings = 30, kLeastCells = kIronNumbers + 1;
constexpr int kIronRounds = 50, kSide = 3, kCells = 6 * kSide * kSide;
constexpr double kIronSettled = 1e-10;
constexpr double kFlat = 1e-3;  // least share of the readings' spread along an axis: less is a plane
constexpr double kDegPerRad = 180 / math::kPi;
constexpr std::size_t kBlock = 20;  // readings that are held out together: neighbours are much alike

using Numbers = std::array<double, kIronNumbers>;

double at(const Vec3& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

Mat3 soft_of(const Numbers& n) { return {n[3], n[6], n[7], n[6], n[4], n[8], n[7], n[8], n[5]}; }
Vec3 hard_of(const Numbers& n) { return {n[0], n[1], n[2]}; }

double determinant(const Mat3& m) {
  return m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
         m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
}

Dense dense_of(const Mat3& m) {
  Dense d(3, 3);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) d(i, j) = m(static_cast<int>(i), static_cast<int>(j));
  return d;
}

/// A part of the sphere: one of kSide x kSide on each side of a cube around it.
std::size_t cell_of(const Vec3& u) {
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(at(u, i)) > std::abs(at(u, axis))) axis = i;
  const double most = std::abs(at(u, axis));
  if (most == 0) return 0;  // a reading at the very middle has no direction
  const auto part = [most](double x) {
    return std::clamp(static_cast<int>((x / most + 1) * (0.5 * kSide)), 0, kSide - 1);
  };
  const int side = 2 * axis + (at(u, axis) < 0 ? 1 : 0);
  return static_cast<std::size_t>((side * kSide + part(at(u, (axis + 1) % 3))) * kSide + part(at(u, (axis + 2) % 3)));
}
Vec3 middle_of(std::size_t cell) {
  const int n = static_cast<int>(cell), side = n / (kSide * kSide), axis = side / 2;
  const auto along = [](int part) { return (2.0 * part + 1) / kSide - 1; };
  double v[3] = {};
  v[axis] = side % 2 ? -1 : 1;
  v[(axis + 1) % 3] = along(n / kSide % kSide);
  v[(axis + 2) % 3] = along(n % kSide);
  return normalized(Vec3{v[0], v[1], v[2]});
}

/// d(soft (x - hard)) by the numbers: 3 x 9.
std::array<Vec3, kIronNumbers> slopes(const Mat3& soft, const Vec3& d) {
  return {-Vec3{soft(0, 0), soft(1, 0), soft(2, 0)},
          -Vec3{soft(0, 1), soft(1, 1), soft(2, 1)},
          -Vec3{soft(0, 2), soft(1, 2), soft(2, 2)},
          {d.x, 0, 0},
          {0, d.y, 0},
          {0, 0, d.z},
          {d.y, d.x, 0},
          {d.z, 0, d.x},
          {0, d.z, d.y}};
}

/// Readings about their mean in units of their spread, and the ellipsoid through them as a sphere of radius 1.
class EllipsoidFitter {
 public:
  explicit EllipsoidFitter(std::vector<Vec3> points) : x_(std::move(points)) {}

  /// Empty, or what is wrong.
  std::string run() {
    weigh([](const Vec3& p) { return p; });
    if (std::string why = start(); !why.empty()) return why;
    for (int pass = 0; pass < 2; ++pass) {  // the cells by directions of the field, once those are known
      const Mat3 soft = soft_of(n_);
      weigh([&](const Vec3& p) { return soft * (p - hard_of(n_)); });
      if (!descend()) return "the readings lie on no ellipsoid";
    }
    const auto inverse = inverse_of_positive(normal_);
    if (!inverse) return "the readings do not show all of it: turn the vehicle about more axes";
    inverse_ = *inverse;
    return {};
  }

  const Numbers& numbers() const { return n_; }
  std::size_t cells() const { return cells_; }
  double freedom() const { return static_cast<double>(cells_) - static_cast<double>(kIronNumbers); }
  /// The larger of what the errors' size says and what the contradictions of the cells say.
  Dense covariance() const {
    const double s2 = cost_ / std::max(1.0, static_cast<double>(x_.size()) - static_cast<double>(kIronNumbers));
    const auto in_cell = by_cell();
    Dense middle(kIronNumbers, kIronNumbers);
    for (const Numbers& score : in_cell)
      for (std::size_t a = 0; a < kIronNumbers; ++a)
        for (std::size_t b = 0; b < kIronNumbers; ++b) middle(a, b) += score[a] * score[b];
    const double small = static_cast<double>(cells_) / std::max(1.0, freedom());
    Dense both(kIronNumbers, kIronNumbers), out(kIronNumbers, kIronNumbers);
    for (std::size_t a = 0; a < kIronNumbers; ++a)
      for (std::size_t b = 0; b < kIronNumbers; ++b)
        for (std::size_t k = 0; k < kIronNumbers; ++k) both(a, b) += inverse_(a, k) * middle(k, b);
    double sandwich = 0, plain = 0;
    for (std::size_t a = 0; a < kIronNumbers; ++a)
      for (std::size_t b = 0; b < kIronNumbers; ++b) {
        for (std::size_t k = 0; k < kIronNumbers; ++k) out(a, b) += small * both(a, k) * inverse_(k, b);
        if (a == b) sandwich += out(a, b) / inverse_(a, a), plain += s2;
      }
    if (sandwich >= plain) return out;
    for (std::size_t a = 0; a < kIronNumbers; ++a)
      for (std::size_t b = 0; b < kIronNumbers; ++b) out(a, b) = s2 * inverse_(a, b);
    return out;
  }

 private:
  template <class DirectionOf>
  void weigh(const DirectionOf& direction_of) {
    std::array<double, kCells> count{};
    cell_.resize(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) ++count[cell_[i] = cell_of(direction_of(x_[i]))];
    cells_ = static_cast<std::size_t>(std::count_if(count.begin(), count.end(), [](double n) { return n > 0; }));
    const double mean = static_cast<double>(x_.size()) / static_cast<double>(cells_);
    weight_.resize(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i) weight_[i] = mean / count[cell_[i]];
  }

  /// x^T A x + 2 b^T x = 1 by linear least squares; where that is no ellipsoid, a sphere.
  std::string start() {
    Dense m(kIronNumbers, kIronNumbers);
    std::vector<double> by(kIronNumbers);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const Vec3& p = x_[i];
      const Numbers row = {2 * p.x,   2 * p.y,       2 * p.z,       p.x * p.x,    p.y * p.y,
                           p.z * p.z, 2 * p.x * p.y, 2 * p.x * p.z, 2 * p.y * p.z};
      for (std::size_t a = 0; a < kIronNumbers; ++a) {
        by[a] += weight_[i] * row[a];
        for (std::size_t b = 0; b < kIronNumbers; ++b) m(a, b) += weight_[i] * row[a] * row[b];
      }
    }
    n_ = {0, 0, 0, 1, 1, 1, 0, 0, 0};
    const auto found = solve_positive(m, by);
    if (!found) return "the readings lie in a plane, or all in one place: turn the vehicle about more axes";
    Numbers quadric;
    std::copy(found->begin(), found->end(), quadric.begin());
    const Dense a = dense_of(soft_of(quadric));
    const auto centre = solve_positive(a, {-quadric[0], -quadric[1], -quadric[2]});
    if (!centre) return {};  // no ellipsoid: the sphere about their mean is a start, too
    double level = 1;        // (x - c)^T A (x - c) = 1 + c^T A c
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c) level += (*centre)[r] * a(r, c) * (*centre)[c];
    const SymmetricEigen e = symmetric_eigen(a);
    Mat3 root;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < 3; ++k)
          root(r, c) += e.vectors(static_cast<std::size_t>(r), k) * math::sqrt(e.values[k] / level) *
                        e.vectors(static_cast<std::size_t>(c), k);
    n_ = {(*centre)[0], (*centre)[1], (*centre)[2], root(0, 0), root(1, 1),
          root(2, 2),   root(0, 1),   root(0, 2),   root(1, 2)};
    return {};
  }

  double error(const Numbers& n, std::size_t i) const { return norm(soft_of(n) * (x_[i] - hard_of(n))) - 1; }

  double cost_of(const Numbers& n) const {
    double sum = 0;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double e = std::abs(error(n, i)) / sigma_;
      sum += weight_[i] * (e <= kHuber ? e * e : kHuber * (2 * e - kHuber));
    }
    return sum * sigma_ * sigma_;
  }

  Numbers row(std::size_t i) const {
    const Mat3 soft = soft_of(n_);
    const Vec3 d = x_[i] - hard_of(n_), u = normalized(soft * d);
    const auto slope = slopes(soft, d);
    Numbers r;
    for (std::size_t a = 0; a < kIronNumbers; ++a) r[a] = dot(u, slope[a]);
    return r;
  }

  /// Of its error, as far as it counts.
  double share(double e) const { return std::abs(e) <= kHuber * sigma_ ? 1 : kHuber * sigma_ / std::abs(e); }

  bool descend() {
    double damping = 1e-6;
    for (int round = 0; round < kIronRounds; ++round) {
      std::vector<double> sizes(x_.size());
      for (std::size_t i = 0; i < x_.size(); ++i) sizes[i] = std::abs(error(n_, i));
      std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
      sigma_ = std::max(1e-9, kSigmaOfMedian * sizes[sizes.size() / 2]);
      normal_ = Dense(kIronNumbers, kIronNumbers);
      std::vector<double> by(kIronNumbers);
      for (std::size_t i = 0; i < x_.size(); ++i) {
        const Numbers r = row(i);
        const double e = error(n_, i), w = weight_[i] * share(e);
        for (std::size_t a = 0; a < kIronNumbers; ++a) {
          by[a] -= w * r[a] * e;
          for (std::size_t b = 0; b < kIronNumbers; ++b) normal_(a, b) += w * r[a] * r[b];
        }
      }
      cost_ = cost_of(n_);
      if (!math::is_finite(cost_)) return false;
      bool better = false;
      double next_cost = cost_;
      for (int tries = 0; tries < 12 && !better; ++tries, damping *= 10) {
        Dense damped = normal_;
        for (std::size_t a = 0; a < kIronNumbers; ++a) damped(a, a) *= 1 + damping;
        const auto step = solve_positive(damped, by);
        if (!step) continue;
        Numbers next = n_;
        for (std::size_t a = 0; a < kIronNumbers; ++a) next[a] += (*step)[a];
        next_cost = cost_of(next);
        better = next_cost < cost_ && determinant(soft_of(next)) > 0;
        if (better) n_ = next;
      }
      damping = std::max(1e-9, damping * 1e-3);
      if (!better || cost_ - next_cost < kIronSettled * cost_) break;
    }
    return symmetric_eigen(dense_of(soft_of(n_))).values[0] > 0;
  }

  /// What pulls at the numbers, of each part of the sphere.
  std::array<Numbers, kCells> by_cell() const {
    std::array<Numbers, kCells> all{};
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double e = error(n_, i), w = weight_[i] * share(e);
      const Numbers r = row(i);
      for (std::size_t a = 0; a < kIronNumbers; ++a) all[cell_[i]][a] += w * e * r[a];
    }
    return all;
  }

  std::vector<Vec3> x_;
  std::vector<std::size_t> cell_;
  std::vector<double> weight_;
  std::size_t cells_ = 0;
  Numbers n_{};
  Dense normal_, inverse_;
  double cost_ = 0, sigma_ = 1;
};

struct Scale {
  Vec3 mean;
  double size_t = 1;
  Vec3 to_unit(const Vec3& reading) const { return (reading - mean) / size_t; }
};

/// Empty where they can be fitted at all.
std::string look_at(std::span<const Vec3> readings, Scale& scale) {
  if (readings.size() < kLeastReadings)
    return std::to_string(readings.size()) + " readings; at least " + std::to_string(kLeastReadings) + " are needed";
  for (const Vec3& r : readings) {
    if (!is_finite(r)) return "a reading is not finite";
    scale.mean += r / static_cast<double>(readings.size());
  }
  Dense spread(3, 3);
  for (const Vec3& r : readings)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        spread(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) +=
            at(r - scale.mean, i) * at(r - scale.mean, j);
  const auto values = symmetric_eigen(spread).values;
  scale.size_t = math::sqrt(values[2] / static_cast<double>(readings.size()));
  if (!(values[0] > kFlat * values[2]))
    return "the readings lie in a plane, or all in one place: turn the vehicle about more axes";
  return {};
}

/// soft as it is printed, by the numbers in units of the spread.
Numbers soft_numbers(const Numbers& n, double unit_t, double field_t) {
  const double keep = field_t > 0 ? field_t / unit_t : math::pow(determinant(soft_of(n)), -1.0 / 3);
  Numbers out = n;
  for (std::size_t a = 3; a < kIronNumbers; ++a) out[a] *= keep;
  return out;
}

double worst_direction(const Numbers& n, const Dense& covariance, Vec3& worst) {
  const Mat3 soft = soft_of(n);
  const auto inverse = math::inverse(soft);
  if (!inverse) return math::kInf;
  double most = -1;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    const Vec3 u = middle_of(cell);
    auto slope = slopes(soft, *inverse * u);
    for (Vec3& s : slope) s -= u * dot(u, s);  // across the field: its direction
    Dense of(3, 3);
    for (std::size_t a = 0; a < kIronNumbers; ++a)
      for (std::size_t b = 0; b < kIronNumbers; ++b)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            of(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) +=
                at(slope[a], r) * covariance(a, b) * at(slope[b], c);
    if (const double value = symmetric_eigen(of).values[2]; value > most) most = value, worst = u;
  }
  return math::sqrt(std::max(0.0, most));
}

double rms_of(std::span<const Vec3> readings, const Mat3& soft, const Vec3& hard, double field_t) {
  double sum = 0;
  for (const Vec3& r : readings) {
    const double e = norm(soft * (r - hard)) - field_t;
    sum += e * e;
  }
  return readings.empty() ? math::kNan : math::sqrt(sum / static_cast<double>(readings.size()));
}

}  // namespace

IronFit fit_iron(std::span<const Vec3> readings, const IronFitOptions& options) {
  IronFit fit;
  fit.readings = readings.size();
  Scale scale;
  if (fit.problem = look_at(readings, scale); !fit.problem.empty()) return fit;
  const auto fitter_of = [&](std::span<const Vec3> some) {
    std::vector<Vec3> points;
    for (const Vec3& r : some) points.push_back(scale.to_unit(r));
    return EllipsoidFitter(std::move(points));
  };
  EllipsoidFitter fitter = fitter_of(readings);
  if (fit.problem = fitter.run(); !fit.problem.empty()) return fit;

  const Numbers n = fitter.numbers(), out = soft_numbers(n, scale.size_t, options.field_t);
  fit.field_t = options.field_t > 0 ? options.field_t : scale.size_t * math::pow(determinant(soft_of(n)), -1.0 / 3);
  fit.soft = soft_of(out);
  fit.hard_t = scale.mean + hard_of(n) * scale.size_t;

  const Dense covariance = fitter.covariance();
  const double wide = student_95(fitter.freedom());
  // By differences: where the field is not known, each number of `soft` depends on all.
  for (std::size_t a = 0; a < kIronNumbers; ++a) {
    Numbers slope{};
    for (std::size_t b = 0; b < kIronNumbers; ++b) {
      Numbers more = n;
      const double step = 1e-6;
      more[b] += step;
      slope[b] = (soft_numbers(more, scale.size_t, options.field_t)[a] - out[a]) / step;
    }
    double variance = 0;
    for (std::size_t b = 0; b < kIronNumbers; ++b)
      for (std::size_t c = 0; c < kIronNumbers; ++c) variance += slope[b] * covariance(b, c) * slope[c];
    fit.estimates[a] = {a < 3 ? at(fit.hard_t, static_cast<int>(a)) : out[a],
                        wide * math::sqrt(std::max(0.0, variance)) * (a < 3 ? scale.size_t : 1)};
  }
  fit.worst_deg = wide * worst_direction(n, covariance, fit.worst) * kDegPerRad;
  fit.shown = fit.worst_deg <= options.open_deg && fitter.cells() >= kLeastCells;
  fit.rms_before_t = rms_of(readings, Mat3::identity(), {}, fit.field_t);
  fit.rms_t = rms_of(readings, fit.soft, fit.hard_t, fit.field_t);

  std::vector<Vec3> kept, held;
  for (std::size_t i = 0; i < readings.size(); ++i)
    (options.held_out_each && i / kBlock % options.held_out_each == options.held_out_each - 1 ? held : kept)
        .push_back(readings[i]);
  fit.held_out_rms_t = math::kNan;
  if (EllipsoidFitter others = fitter_of(kept); kept.size() >= kLeastReadings && others.run().empty()) {
    const Numbers of = soft_numbers(others.numbers(), scale.size_t, fit.field_t);
    fit.held_out_rms_t = rms_of(held, soft_of(of), scale.mean + hard_of(others.numbers()) * scale.size_t, fit.field_t);
  }
  return fit;
}

}  // namespace sinew::identify
