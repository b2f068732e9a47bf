#include "identify/base_parameters.hpp"

#include <algorithm>
#include <cstdio>

#include "identify/smoothing.hpp"
#include "identify/student.hpp"
#include "math/elementary.hpp"
#include "math/random.hpp"

namespace sinew::identify {
namespace {

using kinematics::Body;

constexpr double kCoulombRadps = 1e-6;  // rows below BaseOptions::least_radps are left out: it is a sign

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

/// Positions, their derivatives and efforts of all joints at one instant.
struct Smoothed {
  std::vector<double> q, v, a, effort;
};

bool smooth(const ChainRecord& record, double t, double window_s, Smoothed& s) {
  const std::size_t joints = record.q_rad.size();
  s.q.resize(joints), s.v.resize(joints), s.a.resize(joints), s.effort.resize(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    LocalMotion m;
    if (!local_motion(record.time_s, record.q_rad[j], record.effort_nm[j], t, window_s, m)) return false;
    s.q[j] = m.q, s.v[j] = m.v, s.a[j] = m.a, s.effort[j] = m.other;
  }
  return true;
}

/// A joint's effort at one instant, and the base parameters' columns there.
struct Row {
  std::size_t joint = 0, block = 0;
  double effort_nm = 0;
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

std::vector<Row> rows_of(const Body& body, const ChainRecord& record, const BaseOptions& o, const BaseSet& set,
                         std::size_t& blocks) {
  std::vector<Row> rows;
  const double first = record.time_s.front(), last = record.time_s.back();
  const double hold_from = last - o.held_out_share * (last - first);
  Dense regressor;
  Smoothed s;
  for (double t = first + 3 * o.window_s; t < last - 3 * o.window_s; t += 1.5 * o.window_s) {
    if (!smooth(record, t, o.window_s, s)) continue;
    chain_regressor(body, {s.q, s.v, s.a}, o.gravity_mps2, kCoulombRadps, regressor);
    for (std::size_t j = 0; j < body.joints(); ++j) {
      if (math::fabs(s.v[j]) < o.least_radps) continue;
      Row row{j, static_cast<std::size_t>((t - first) / o.block_s), s.effort[j], t > hold_from, {}};
      for (const BaseColumn& base : set.base) row.x.push_back(regressor(j, base.column));
      blocks = std::max(blocks, row.block + 1);
      rows.push_back(std::move(row));
    }
  }
  return rows;
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
  const std::size_t n = fit.set.base.size();
  std::size_t blocks = 0;
  const std::vector<Row> rows = rows_of(body, record, options, fit.set, blocks);
  fit.rows = rows.size();
  std::vector<double> sigma(joints, 1);
  std::optional<Solved> solved;
  for (int round = 0; round < 3; ++round) {
    solved = solve(rows, sigma, n, blocks);
    if (!solved) {
      fit.problem = "some joints did not move enough to tell their parameters apart";
      return fit;
    }
    fit.residual_rms_nm = residual_rms(rows, solved->value, joints, false);
    for (std::size_t j = 0; j < joints; ++j) sigma[j] = std::max(fit.residual_rms_nm[j], 1e-9);
  }
  fit.held_out_rms_nm = residual_rms(rows, solved->value, joints, true);
  fit.effort_rms_nm = residual_rms(rows, std::vector<double>(n), joints, false);

  const double t = student_95(blocks > n ? static_cast<double>(blocks - n) : 1);
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
