#include "control/covariance.hpp"

#include <cstring>

namespace sinew::control {
namespace {

/// 3 x 3 of plain doubles: small enough to live in registers, and every sum in the order written.
struct Block {
  double a[3][3];
};

using Storage = double[kErrStates][24];

inline Block load(const Storage& p, int r, int c) {
  Block b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b.a[i][j] = p[r + i][c + j];
  return b;
}
/// A block on the diagonal, whose lower half is not kept.
inline Block load_symmetric(const Storage& p, int r) {
  return {{{p[r][r], p[r][r + 1], p[r][r + 2]},
           {p[r][r + 1], p[r + 1][r + 1], p[r + 1][r + 2]},
           {p[r][r + 2], p[r + 1][r + 2], p[r + 2][r + 2]}}};
}
inline Block transposed(const Block& b) {
  return {{{b.a[0][0], b.a[1][0], b.a[2][0]}, {b.a[0][1], b.a[1][1], b.a[2][1]}, {b.a[0][2], b.a[1][2], b.a[2][2]}}};
}
inline void store(Storage& p, int r, int c, const Block& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) p[r + i][c + j] = b.a[i][j];
}
inline void store_upper(Storage& p, int r, const Block& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) p[r + i][r + j] = b.a[i][j];
}
/// y += a x
inline void add_product(Block& y, const Block& a, const Block& x) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) y.a[i][j] += a.a[i][0] * x.a[0][j] + a.a[i][1] * x.a[1][j] + a.a[i][2] * x.a[2][j];
}
/// y += x a^T
inline void add_product_transposed(Block& y, const Block& x, const Block& a) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) y.a[i][j] += x.a[i][0] * a.a[j][0] + x.a[i][1] * a.a[j][1] + x.a[i][2] * a.a[j][2];
}
/// y -= f x (cross product with each column)
inline void subtract_cross(Block& y, const double* f, const Block& x) {
  for (int j = 0; j < 3; ++j) {
    y.a[0][j] += f[2] * x.a[1][j] - f[1] * x.a[2][j];
    y.a[1][j] += f[0] * x.a[2][j] - f[2] * x.a[0][j];
    y.a[2][j] += f[1] * x.a[0][j] - f[0] * x.a[1][j];
  }
}
/// y -= (f x (x^T))^T
inline void subtract_cross_transposed(Block& y, const double* f, const Block& x) {
  for (int i = 0; i < 3; ++i) {
    y.a[i][0] += f[2] * x.a[i][1] - f[1] * x.a[i][2];
    y.a[i][1] += f[0] * x.a[i][2] - f[2] * x.a[i][0];
    y.a[i][2] += f[1] * x.a[i][0] - f[0] * x.a[i][1];
  }
}
/// y += s x
inline void add_scaled(Block& y, double s, const Block& x) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) y.a[i][j] += s * x.a[i][j];
}

/// Two lanes at a time where the target has them; element by element the same operations, so the same bits.
using Lanes = double __attribute__((vector_size(16)));

}  // namespace

void Covariance::set_diagonal(const ErrorVector& variance) {
  std::memset(p_, 0, sizeof p_);
  for (int i = 0; i < kErrInertial; ++i) p_[i][i] = variance[static_cast<std::size_t>(i)];
  states_ = kErrInertial;
}

void Covariance::open_surroundings(double earth_field, double body_field, double wind) {
  states_ = kErrStates;
  for (int i = kErrInertial; i < kErrStates; ++i)
    reopen(i, i < kErrBodyField ? earth_field : i < kErrWind ? body_field : wind);
}

void Covariance::propagate(const math::Mat3& r_world_base, const math::Vec3& f_world_mps2, double dt_s,
                           const Noise& q) {
  Block a;  // -R dt
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a.a[i][j] = -(r_world_base(i, j) * dt_s);
  const double f[3] = {f_world_mps2.x * dt_s, f_world_mps2.y * dt_s, f_world_mps2.z * dt_s};
  if (has_surroundings()) propagate_surroundings(r_world_base, f, dt_s, q);

  const Block pv = load(p_, kErrP, kErrV), pt = load(p_, kErrP, kErrTheta), pg = load(p_, kErrP, kErrGyroBias),
              pa = load(p_, kErrP, kErrAccelBias);
  const Block vv = load_symmetric(p_, kErrV), vt = load(p_, kErrV, kErrTheta), vg = load(p_, kErrV, kErrGyroBias),
              va = load(p_, kErrV, kErrAccelBias);
  const Block tt = load_symmetric(p_, kErrTheta), tg = load(p_, kErrTheta, kErrGyroBias),
              ta = load(p_, kErrTheta, kErrAccelBias);
  const Block gg = load_symmetric(p_, kErrGyroBias), ga = load(p_, kErrGyroBias, kErrAccelBias);
  const Block aa = load_symmetric(p_, kErrAccelBias);

  // Y = F P, block row by block row; the columns of the biases are final.
  Block y_pv = pv, y_pt = pt, y_pg = pg, y_pa = pa;
  add_scaled(y_pv, dt_s, vv);
  add_scaled(y_pt, dt_s, vt);
  add_scaled(y_pg, dt_s, vg);
  add_scaled(y_pa, dt_s, va);

  Block y_vv = vv, y_vt = vt, y_vg = vg, y_va = va;
  subtract_cross(y_vv, f, transposed(vt));
  add_product(y_vv, a, transposed(va));
  subtract_cross(y_vt, f, tt);
  add_product(y_vt, a, transposed(ta));
  subtract_cross(y_vg, f, tg);
  add_product(y_vg, a, transposed(ga));
  subtract_cross(y_va, f, ta);
  add_product(y_va, a, aa);

  Block y_tt = tt, y_tg = tg, y_ta = ta;
  add_product(y_tt, a, transposed(tg));
  add_product(y_tg, a, gg);
  add_product(y_ta, a, ga);

  // P' = Y F^T, the columns of position, velocity and attitude.
  Block pp = load_symmetric(p_, kErrP);
  add_scaled(pp, dt_s, transposed(pv));
  add_scaled(pp, dt_s, y_pv);
  subtract_cross_transposed(y_pv, f, y_pt);
  add_product_transposed(y_pv, y_pa, a);
  add_product_transposed(y_pt, y_pg, a);
  subtract_cross_transposed(y_vv, f, y_vt);
  add_product_transposed(y_vv, y_va, a);
  add_product_transposed(y_vt, y_vg, a);
  add_product_transposed(y_tt, y_tg, a);

  store_upper(p_, kErrP, pp);
  store(p_, kErrP, kErrV, y_pv);
  store(p_, kErrP, kErrTheta, y_pt);
  store(p_, kErrP, kErrGyroBias, y_pg);
  store(p_, kErrP, kErrAccelBias, y_pa);
  store_upper(p_, kErrV, y_vv);
  store(p_, kErrV, kErrTheta, y_vt);
  store(p_, kErrV, kErrGyroBias, y_vg);
  store(p_, kErrV, kErrAccelBias, y_va);
  store_upper(p_, kErrTheta, y_tt);
  store(p_, kErrTheta, kErrGyroBias, y_tg);
  store(p_, kErrTheta, kErrAccelBias, y_ta);
  for (int i = 0; i < 3; ++i) {
    p_[kErrV + i][kErrV + i] += q.velocity;
    p_[kErrTheta + i][kErrTheta + i] += q.attitude;
    p_[kErrGyroBias + i][kErrGyroBias + i] += q.gyro_bias;
    p_[kErrAccelBias + i][kErrAccelBias + i] += q.accel_bias;
  }
}

/// The columns of the states that only wait: F from the left, nothing from the right. In the order position, velocity,
/// attitude each block uses the old values of the ones behind it.
void Covariance::propagate_surroundings(const math::Mat3& r, const double (&f)[3], double dt_s, const Noise& q) {
  constexpr int kFirst = kErrInertial, kCount = kErrStates - kErrInertial;
  double a[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[i][j] = -(r(i, j) * dt_s);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < kCount; ++j) p_[kErrP + i][kFirst + j] += dt_s * p_[kErrV + i][kFirst + j];
  const double* t[3] = {&p_[kErrTheta][kFirst], &p_[kErrTheta + 1][kFirst], &p_[kErrTheta + 2][kFirst]};
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3, last = (i + 2) % 3;
    double* v = &p_[kErrV + i][kFirst];
    for (int j = 0; j < kCount; ++j) {
      v[j] += f[last] * t[next][j] - f[next] * t[last][j] + a[i][0] * p_[kErrAccelBias][kFirst + j] +
              a[i][1] * p_[kErrAccelBias + 1][kFirst + j] + a[i][2] * p_[kErrAccelBias + 2][kFirst + j];
    }
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < kCount; ++j)
      p_[kErrTheta + i][kFirst + j] += a[i][0] * p_[kErrGyroBias][kFirst + j] +
                                       a[i][1] * p_[kErrGyroBias + 1][kFirst + j] +
                                       a[i][2] * p_[kErrGyroBias + 2][kFirst + j];
  for (int i = 0; i < 3; ++i) {
    p_[kErrEarthField + i][kErrEarthField + i] += q.earth_field;
    p_[kErrBodyField + i][kErrBodyField + i] += q.body_field;
  }
  for (int i = kErrWind; i < kErrStates; ++i) p_[i][i] += q.wind;
}

double Covariance::innovation(const Measurement& m, ErrorVector& gain) const {
  return has_surroundings() ? innovation_of<kErrStates>(m, gain) : innovation_of<kErrInertial>(m, gain);
}

template <int kTo>
double Covariance::innovation_of(const Measurement& m, ErrorVector& gain) const {
  double g[kTo] = {};
  for (std::uint32_t t = 0; t < m.terms; ++t) {
    const int k = m.index[t];
    const double c = m.coefficient[t];
    for (int j = 0; j < k; ++j) g[j] += c * p_[j][k];
    for (int j = k; j < kTo; ++j) g[j] += c * p_[k][j];
  }
  double s = m.variance;
  for (std::uint32_t t = 0; t < m.terms; ++t) s += m.coefficient[t] * g[m.index[t]];
  std::memcpy(gain.data(), g, sizeof g);
  return s;
}

void Covariance::correct(const ErrorVector& gain, double s) {
  alignas(16) double g[kColumns];
  if (has_surroundings()) {
    std::memcpy(g, gain.data(), kErrStates * sizeof(double));
    g[kErrStates] = 0;
    subtract_outer<kErrStates + 1>(g, 1.0 / s);
  } else {
    std::memcpy(g, gain.data(), kErrInertial * sizeof(double));
    g[kErrInertial] = 0;
    subtract_outer<kErrInertial + 1>(g, 1.0 / s);
  }
}

/// An odd number of states and one column more, which stays 0.
template <int kTo>
void Covariance::subtract_outer(const double* g, double inverse) {
  for (int i = 0; i < kTo - 1; ++i) {
    const double k = g[i] * inverse;
    const Lanes kk = {k, k};
    for (int j = i & ~1; j < kTo; j += 2) {  // an even start may write one unused element below the diagonal
      Lanes row, column;
      std::memcpy(&row, &p_[i][j], sizeof row);
      std::memcpy(&column, &g[j], sizeof column);
      row -= kk * column;
      std::memcpy(&p_[i][j], &row, sizeof row);
    }
  }
}

void Covariance::reopen(int i, double variance) {
  for (int j = 0; j < kErrStates; ++j) (j < i ? p_[j][i] : p_[i][j]) = 0;
  p_[i][i] = variance;
}

void Covariance::turn_pair(int i, double c, double s) {
  for (int j = 0; j < kErrStates; ++j) {
    if (j == i || j == i + 1) continue;
    double& x = j < i ? p_[j][i] : p_[i][j];
    double& y = j < i ? p_[j][i + 1] : p_[i + 1][j];
    const double old = x;
    x = c * old - s * y;
    y = s * old + c * y;
  }
  const double xx = p_[i][i], xy = p_[i][i + 1], yy = p_[i + 1][i + 1];
  p_[i][i] = c * c * xx - 2 * c * s * xy + s * s * yy;
  p_[i][i + 1] = c * s * (xx - yy) + (c * c - s * s) * xy;
  p_[i + 1][i + 1] = s * s * xx + 2 * c * s * xy + c * c * yy;
}

}  // namespace sinew::control
