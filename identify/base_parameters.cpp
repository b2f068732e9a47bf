#include "identify/base_parameters.hpp"

#include <algorithm>
#include <cstdio>
#include <deque>

#include "identify/smoothing.hpp"
#include "identify/student.hpp"
#include "math/elementary.hpp"
#include "math/random.hpp"

namespace sinew::identify {
namespace {

using kinematics::Body;

constexpr double kCoulombRadps = 1e-6;  // where it does not matter
/// Of ServoModel::slow_radps: at first, and within which it is looked for.
constexpr double kSlowAtFirst_radps = 0.03, kLeastSlow_radps = 0.005, kMostSlow_radps = 0.3;
constexpr int kRounds = 5;

/// Friction first, then first moments and inertias, and masses last: what depends on others is grouped with them.
std::vector<std::size_t> order_of_choice(const Body& body) {
  const ChainColumns columns{body.joints()};
  std::vector<std::size_t> order;
  for (const auto p : {JointParameter::viscous, JointParameter::coulomb, JointParameter::offset})
    for (std::size_t j = 0; j < columns.joints; ++j) order.push_back(columns.joint(j, p));
  for (std::size_t p = 1; p < kLinkParameters; ++p)
    for (std::size_t j = 0; j < columns.joints; ++j) order.push_back(columns.link(j, static_cast<LinkParameter>(p)));
  for (std::size_t j = 0; j < columns.joints; ++j) order.push_back(columns.joint(j, JointParameter::armature));
  for (std::size_t j = 0; j < columns.joints; ++j) order.push_back(columns.link(j, LinkParameter::m));
  return order;
}

/// Adds row * row^T.
void add_outer(Dense& gram, const double* row, double weight) {
  for (std::size_t i = 0; i < gram.rows(); ++i) {
    if (row[i] == 0) continue;
    for (std::size_t j = 0; j <= i; ++j) gram(i, j) += weight * row[i] * row[j];
  }
}
void mirror(Dense& gram) {
  for (std::size_t i = 0; i < gram.rows(); ++i)
    for (std::size_t j = 0; j < i; ++j) gram(j, i) = gram(i, j);
}

/// A joint's effort at one instant, and the base parameters' columns there.
struct Row {
  std::size_t joint = 0, block = 0;
  double effort_nm = 0, time_s = 0;
  bool held_out = false;
  std::vector<double> x;
};

struct Solved {
  std::vector<double> value;
  Dense covariance;
};

double residual(const Row& row, const std::vector<double>& value) {
  double r = row.effort_nm;
  for (std::size_t i = 0; i < value.size(); ++i) r -= row.x[i] * value[i];
  return r;
}

/// Root mean squares of each joint's residuals, in the fitted part or in the one held out.
std::vector<double> residual_rms(const std::vector<Row>& rows, const std::vector<double>& value, std::size_t joints,
                                 bool held_out) {
  std::vector<double> sum(joints), count(joints);
  for (const Row& row : rows) {
    if (row.held_out != held_out) continue;
    const double r = residual(row, value);
    sum[row.joint] += r * r, count[row.joint] += 1;
  }
  for (std::size_t j = 0; j < joints; ++j) sum[j] = count[j] > 0 ? math::sqrt(sum[j] / count[j]) : math::kNan;
  return sum;
}

/// Nothing: some column is not excited at all.
std::optional<Solved> solve(const std::vector<Row>& rows, const std::vector<double>& sigma, std::size_t n,
                            std::size_t blocks) {
  Dense gram(n, n);
  std::vector<double> right(n);
  for (const Row& row : rows) {
    if (row.held_out) continue;
    const double w = 1 / (sigma[row.joint] * sigma[row.joint]);
    add_outer(gram, row.x.data(), w);
    for (std::size_t i = 0; i < n; ++i) right[i] += w * row.x[i] * row.effort_nm;
  }
  mirror(gram);
  const auto inverse = inverse_of_positive(gram);
  if (!inverse) return std::nullopt;
  Solved s{std::vector<double>(n), Dense(n, n)};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) s.value[i] += (*inverse)(i, j) * right[j];
  // inverse * (sum of g g^T over the blocks) * inverse, with g the block's gradient.
  Dense scores(blocks, n);
  for (const Row& row : rows) {
    if (row.held_out) continue;
    const double w = residual(row, s.value) / (sigma[row.joint] * sigma[row.joint]);
    for (std::size_t i = 0; i < n; ++i) scores(row.block, i) += w * row.x[i];
  }
  std::size_t used = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    std::vector<double> step(n);
    bool any = false;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) step[i] += (*inverse)(i, j) * scores(b, j);
    for (const double x : step) any = any || x != 0;
    used += any ? 1 : 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) s.covariance(i, j) += step[i] * step[j];
  }
  const double correct = used > n ? static_cast<double>(used) / static_cast<double>(used - n) : math::kInf;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) s.covariance(i, j) *= correct;
  return s;
}

/// The motion at each measurement, as far as its neighbours show it.
struct Motions {
  std::vector<std::size_t> at;               // of these measurements
  std::vector<std::vector<double>> q, v, a;  // of each of them: of all joints
};

Motions motions_of(const ChainRecord& record, double window_s) {
  Motions m;
  const std::size_t joints = record.q_rad.size(), n = record.time_s.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double t = record.time_s[i];
    std::vector<double> q(joints), v(joints), a(joints);
    bool whole = true;
    for (std::size_t j = 0; j < joints && whole; ++j) {
      LocalMotion motion;
      whole = local_motion(record.time_s, record.q_rad[j], record.effort_nm[j], t, window_s, motion) &&
              math::is_finite(record.effort_nm[j][i]);
      q[j] = motion.q, v[j] = motion.v, a[j] = motion.a;
    }
    if (!whole) continue;
    m.at.push_back(i);
    m.q.push_back(std::move(q)), m.v.push_back(std::move(v)), m.a.push_back(std::move(a));
  }
  return m;
}

/// Efforts, and what they are of, run through the same low-pass: then its errors are the same on both sides. Friction
/// that turns round within the low-pass is the case in which it matters.
class RowMaker {
 public:
  RowMaker(const Body& body, const ChainRecord& record, const BaseOptions& o, const BaseSet& set)
      : body_(body), record_(record), o_(o), set_(set) {
    const double period = (record.time_s.back() - record.time_s.front()) / static_cast<double>(record.time_s.size());
    // Noise of differences is taken away by the low-pass behind them; a cubic needs some values.
    motions_ = motions_of(record, std::max(0.5 * o.window_s, 1.2 * period));
  }

  /// Friction is v / (|v| + slow_radps) of the Coulomb torque; behind the base's columns is one for each joint, how its
  /// torque changes with that speed.
  std::vector<Row> rows(const std::vector<double>& slow_radps, std::size_t& blocks) {
    const double first = record_.time_s.front(), last = record_.time_s.back();
    rows_.clear();
    const double begin = first + kReach * o_.window_s, step = 1.5 * o_.window_s;
    for (std::size_t k = 0; begin + static_cast<double>(k) * step < last - kReach * o_.window_s; ++k)
      open_.push_back({begin + static_cast<double>(k) * step, 0, std::vector<Sum>(body_.joints())});
    for (std::size_t k = 0; k < motions_.at.size(); ++k) {
      chain_regressor(body_, {motions_.q[k], motions_.v[k], motions_.a[k]}, o_.gravity_mps2, kCoulombRadps, regressor_);
      add(motions_.at[k], motions_.v[k], slow_radps);
    }
    finish(math::kInf);
    const double hold_from = last - o_.held_out_share * (last - first);
    for (Row& row : rows_) {
      row.block = static_cast<std::size_t>((row.time_s - first) / o_.block_s);
      row.held_out = row.time_s > hold_from;
      blocks = std::max(blocks, row.block + 1);
    }
    return std::move(rows_);
  }

 private:
  static constexpr double kReach = 3;  // windows
  static constexpr double kSlowShare = 0.2;
  struct Sum {
    double effort_nm = 0, slow = 0;
    std::vector<double> x;
  };
  struct Open {
    double time_s = 0, weight = 0;
    std::vector<Sum> joint;
  };

  void add(std::size_t i, const std::vector<double>& v, const std::vector<double>& slow_radps) {
    const double t = record_.time_s[i];
    finish(t);
    const ChainColumns columns{v.size()};
    std::vector<double> with_slow(v.size());
    for (std::size_t j = 0; j < v.size(); ++j) {
      const double speed = math::fabs(v[j]) + slow_radps[j];
      regressor_(j, columns.joint(j, JointParameter::coulomb)) = v[j] / speed;
      with_slow[j] = -v[j] / (speed * speed);
    }
    for (Open& open : open_) {
      const double x = (open.time_s - t) / o_.window_s;
      if (x > kReach) break;
      const double w = math::exp(-0.5 * x * x);
      open.weight += w;
      for (std::size_t j = 0; j < open.joint.size(); ++j) {
        Sum& sum = open.joint[j];
        sum.x.resize(set_.base.size() + v.size());
        sum.effort_nm += w * record_.effort_nm[j][i];
        if (math::fabs(v[j]) < o_.least_radps) sum.slow += w;
        for (std::size_t c = 0; c < set_.base.size(); ++c) sum.x[c] += w * regressor_(j, set_.base[c].column);
        sum.x[set_.base.size() + j] += w * with_slow[j];
      }
    }
  }

  /// Rows to which nothing comes any more.
  void finish(double now_s) {
    for (; !open_.empty() && open_.front().time_s + kReach * o_.window_s < now_s; open_.pop_front()) {
      Open& open = open_.front();
      for (std::size_t j = 0; j < open.joint.size(); ++j) {
        Sum& sum = open.joint[j];
        if (!(open.weight > 0) || sum.slow > kSlowShare * open.weight) continue;
        for (double& x : sum.x) x /= open.weight;
        rows_.push_back({j, 0, sum.effort_nm / open.weight, open.time_s, false, std::move(sum.x)});
      }
    }
  }

  const Body& body_;
  const ChainRecord& record_;
  const BaseOptions& o_;
  const BaseSet& set_;
  Motions motions_;
  Dense regressor_;
  std::deque<Open> open_;  // the earliest first
  std::vector<Row> rows_;
};

/// Gauss-Newton's step of the speeds at which half of the Coulomb friction is there.
void move_slow(const BaseSet& set, const Solved& solved, std::vector<double>& slow_radps) {
  const ChainColumns columns{slow_radps.size()};
  for (std::size_t j = 0; j < slow_radps.size(); ++j)
    for (std::size_t i = 0; i < set.base.size(); ++i) {
      if (set.base[i].column != columns.joint(j, JointParameter::coulomb)) continue;
      const double coulomb_nm = solved.value[i], step = solved.value[set.base.size() + j] / coulomb_nm;
      if (!math::is_finite(step)) continue;
      slow_radps[j] = std::clamp(slow_radps[j] + std::clamp(step, -0.5 * slow_radps[j], slow_radps[j]),
                                 kLeastSlow_radps, kMostSlow_radps);
    }
}

}  // namespace

BaseSet base_set(const Body& body, const math::Vec3& gravity_mps2) {
  constexpr int kMotions = 300;
  constexpr double kDependent = 1e-10;  // of a squared column's length; rounding leaves 1e-14 of it
  const ChainColumns columns{body.joints()};
  math::Random random(1, 0x62617365);
  Dense gram(columns.size(), columns.size()), regressor;
  std::vector<double> q(columns.joints), v(columns.joints), a(columns.joints);
  for (int k = 0; k < kMotions; ++k) {
    for (std::size_t j = 0; j < columns.joints; ++j)
      q[j] = random.uniform(-3, 3), v[j] = random.uniform(-3, 3), a[j] = random.uniform(-9, 9);
    chain_regressor(body, {q, v, a}, gravity_mps2, kCoulombRadps, regressor);
    for (std::size_t r = 0; r < regressor.rows(); ++r) add_outer(gram, regressor.row(r), 1);
  }
  mirror(gram);

  // Cholesky of the Gram matrix, column by column in the order of choice; a column of which nothing is left depends.
  BaseSet set;
  std::vector<std::vector<double>> l;  // l[k]: row of the k-th base column, as long as k + 1
  for (const std::size_t column : order_of_choice(body)) {
    const double whole = gram(column, column);
    if (!(whole > 1e-12)) {
      set.without_effect.push_back(column);
      continue;
    }
    std::vector<double> row(l.size());
    double left = whole;
    for (std::size_t k = 0; k < l.size(); ++k) {
      double s = gram(column, set.base[k].column);
      for (std::size_t i = 0; i < k; ++i) s -= row[i] * l[k][i];
      row[k] = s / l[k][k];
      left -= row[k] * row[k];
    }
    if (left > kDependent * whole) {
      row.push_back(math::sqrt(left));
      l.push_back(std::move(row));
      set.base.push_back({column, {}});
      continue;
    }
    for (std::size_t k = l.size(); k-- > 0;) {  // L^T factor = row
      for (std::size_t i = k + 1; i < l.size(); ++i) row[k] -= l[i][k] * row[i];
      row[k] /= l[k][k];
    }
    for (std::size_t k = 0; k < l.size(); ++k)
      if (math::fabs(row[k]) > 1e-6) set.base[k].with.push_back({column, row[k]});
  }
  return set;
}

std::string base_name(const Body& body, const BaseColumn& base, std::size_t most) {
  std::string name = chain_column_name(body, base.column);
  for (std::size_t i = 0; i < base.with.size(); ++i) {
    if (i + 1 >= most) return name + " + ...";
    const double factor = base.with[i].factor, size = math::fabs(factor);
    char text[40] = "";
    if (math::fabs(size - 1) > 1e-6) std::snprintf(text, sizeof text, "%.4g ", size);
    name += (factor < 0 ? " - " : " + ") + std::string(text) + chain_column_name(body, base.with[i].column);
  }
  return name;
}

BaseFit fit_base_parameters(const Body& body, const ChainRecord& record, const BaseOptions& options) {
  BaseFit fit;
  const std::size_t joints = body.joints();
  fit.set = base_set(body, options.gravity_mps2);
  if (record.time_s.size() < 12 || record.q_rad.size() != joints || record.effort_nm.size() != joints) {
    fit.problem = "the record has no positions and efforts of all joints of the body";
    return fit;
  }
  const std::size_t n = fit.set.base.size(), columns = n + joints;
  std::size_t blocks = 0;
  RowMaker maker(body, record, options, fit.set);
  std::vector<double> sigma(joints, 1), slow_radps(joints, kSlowAtFirst_radps);
  std::vector<Row> rows;
  std::optional<Solved> solved;
  for (int round = 0; round < kRounds; ++round) {
    if (solved) move_slow(fit.set, *solved, slow_radps);
    rows = maker.rows(slow_radps, blocks);
    solved = solve(rows, sigma, columns, blocks);
    if (!solved) {
      fit.problem = "some joints did not move enough to tell their parameters apart";
      return fit;
    }
    fit.residual_rms_nm = residual_rms(rows, solved->value, joints, false);
    for (std::size_t j = 0; j < joints; ++j) sigma[j] = std::max(fit.residual_rms_nm[j], 1e-9);
  }
  fit.rows = rows.size();
  fit.held_out_rms_nm = residual_rms(rows, solved->value, joints, true);
  fit.effort_rms_nm = residual_rms(rows, std::vector<double>(columns), joints, false);

  const double t = student_95(blocks > columns ? static_cast<double>(blocks - columns) : 1);
  for (std::size_t i = 0; i < n; ++i) {
    BaseEstimate e{solved->value[i], t * math::sqrt(solved->covariance(i, i)), true};
    std::vector<double> column(joints), all(joints);
    for (const Row& row : rows)
      column[row.joint] += row.x[i] * row.x[i], all[row.joint] += row.effort_nm * row.effort_nm;
    double most = 0;  // share of a joint's efforts that the interval leaves open
    for (std::size_t j = 0; j < joints; ++j)
      if (all[j] > 0) most = std::max(most, e.half_width * math::sqrt(column[j] / all[j]));
    e.identified = most < 0.2;
    fit.estimates.push_back(e);
  }
  return fit;
}

}  // namespace sinew::identify
