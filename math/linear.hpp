#pragma once
// Vectors, quaternions and small matrices. Sums run in the order written, so the bits are the same everywhere.
// Frames:  right-handed; quaternions are Hamilton, w x y z; q_a_b (and its matrix) takes b coordinates to a.
// Thread:  any.   RT: yes.
#include "math/matrix.hpp"

namespace sinew::math {

template <class T>
concept HasXyz = requires(const T& v) {
  static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z);
};
template <class T>
concept HasWxyz = HasXyz<T> && requires(const T& q) {
  static_cast<double>(q.w);
};

struct Vec3 {
  double x = 0, y = 0, z = 0;

  constexpr Vec3() = default;
  constexpr Vec3(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  template <HasXyz T>
  requires(!HasWxyz<T>) constexpr explicit Vec3(const T& v) : x(v.x), y(v.y), z(v.z) {}
  constexpr explicit Vec3(const Mat<3, 1>& v) : x(v(0)), y(v(1)), z(v(2)) {}

  /// As another type with x, y, z (msg::Vec3).
  template <class T>
  constexpr T to() const {
    T out{};
    out.x = x, out.y = y, out.z = z;
    return out;
  }
  constexpr Mat<3, 1> column() const { return {x, y, z}; }
  constexpr double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  constexpr double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }

  constexpr Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
  constexpr Vec3& operator-=(const Vec3& b) { return *this = *this - b; }
  constexpr Vec3& operator*=(double s) { return *this = *this * s; }
  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(const Vec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(double s, const Vec3& a) { return a * s; }
  friend constexpr Vec3 operator/(const Vec3& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double squared_norm(const Vec3& a) { return dot(a, a); }
inline double norm(const Vec3& a) { return sqrt(dot(a, a)); }
/// Unit vector; the zero vector stays zero.
inline Vec3 normalized(const Vec3& a) {
  const double n = norm(a);
  return n > 0 ? a / n : Vec3{};
}
constexpr bool is_finite(const Vec3& a) { return is_finite(a.x) && is_finite(a.y) && is_finite(a.z); }

using Mat3 = Mat<3, 3>;
constexpr Vec3 operator*(const Mat3& m, const Vec3& v) { return Vec3(m * v.column()); }
/// skew(a) * b = cross(a, b).
constexpr Mat3 skew(const Vec3& a) { return {0, -a.z, a.y, a.z, 0, -a.x, -a.y, a.x, 0}; }
constexpr Mat3 outer(const Vec3& a, const Vec3& b) { return a.column() * b.column().transpose(); }

/// Roll about x, then pitch about y, then yaw about z, all fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll).
struct YawPitchRoll {
  double yaw = 0, pitch = 0, roll = 0;
};

struct Quat {
  double w = 1, x = 0, y = 0, z = 0;

  constexpr Quat() = default;
  constexpr Quat(double w_, double x_, double y_, double z_) : w(w_), x(x_), y(y_), z(z_) {}
  template <HasWxyz T>
  constexpr explicit Quat(const T& q) : w(q.w), x(q.x), y(q.y), z(q.z) {}

  /// Axis of unit length.
  static Quat from_axis_angle(const Vec3& axis, double angle_rad) {
    const SinCos h = sincos(0.5 * angle_rad);
    return {h.cos, axis.x * h.sin, axis.y * h.sin, axis.z * h.sin};
  }
  /// Exponential map: rotation about v by |v| rad.
  static Quat exp(const Vec3& v);
  static Quat from_yaw_pitch_roll(const YawPitchRoll& a);
  /// The quaternion of a rotation matrix.
  static Quat from_matrix(const Mat3& r);
  /// The shortest rotation that takes direction a to direction b; for opposite ones about some axis normal to a.
  static Quat between(const Vec3& a, const Vec3& b);

  template <class T>
  constexpr T to() const {
    T out{};
    out.w = w, out.x = x, out.y = y, out.z = z;
    return out;
  }
  constexpr Vec3 vec() const { return {x, y, z}; }
  constexpr Quat conjugate() const { return {w, -x, -y, -z}; }  // the inverse of a unit quaternion
  constexpr Vec3 rotate(const Vec3& v) const {
    const Vec3 t = 2 * cross(vec(), v);
    return v + w * t + cross(vec(), t);
  }
  /// Unit length; identity where the length is 0 or not finite.
  Quat normalized() const;
  /// Logarithmic map: rotation vector, |v| <= pi.
  Vec3 log() const;
  constexpr Mat3 matrix() const;
  /// Pitch in -pi/2..pi/2; at the poles roll and yaw share one angle and are not unique.
  YawPitchRoll yaw_pitch_roll() const;
  double yaw() const { return atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)); }

  friend constexpr Quat operator*(const Quat& a, const Quat& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  friend constexpr Quat operator-(const Quat& a) { return {-a.w, -a.x, -a.y, -a.z}; }
  friend constexpr bool operator==(const Quat&, const Quat&) = default;
};

/// Angle of the rotation between two attitudes, 0..pi.
inline double angle_between(const Quat& a, const Quat& b) { return norm((a.conjugate() * b).log()); }
constexpr bool is_finite(const Quat& q) { return is_finite(q.w) && is_finite(q.x) && is_finite(q.y) && is_finite(q.z); }

inline Quat Quat::exp(const Vec3& v) {
  const double n2 = squared_norm(v);
  // sin(n/2)/n by its series where n is small: the next term is below 2^-60.
  if (n2 < 0x1p-20) {
    const double s = 0.5 - n2 * (1.0 / 48) + n2 * n2 * (1.0 / 3840);
    const double c = 1 - n2 * 0.125 + n2 * n2 * (1.0 / 384);
    return {c, v.x * s, v.y * s, v.z * s};
  }
  const double n = sqrt(n2);
  const SinCos h = sincos(0.5 * n);
  const double s = h.sin / n;
  return {h.cos, v.x * s, v.y * s, v.z * s};
}

inline Quat Quat::normalized() const {
  const double n = sqrt(w * w + x * x + y * y + z * z);
  if (!(n > 0) || !is_finite(n)) return {};
  return {w / n, x / n, y / n, z / n};
}

inline Vec3 Quat::log() const {
  const double n = norm(vec()), sign = w < 0 ? -1 : 1;  // q and -q are one rotation: take the shorter way
  if (n < 0x1p-30) return vec() * (2 * sign / fabs(w));
  return vec() * (2 * sign * atan2(n, fabs(w)) / n);
}

constexpr Mat3 Quat::matrix() const {
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

inline Quat Quat::from_matrix(const Mat3& r) {
  // The largest of the four components is found first, so that no division is by something small.
  // Source:  S. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978).
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  const int i = r(0, 0) > r(1, 1) ? (r(0, 0) > r(2, 2) ? 0 : 2) : (r(1, 1) > r(2, 2) ? 1 : 2);
  Quat q;
  if (trace >= r(i, i)) {
    q = {1 + trace, r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};
  } else {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    Vec3 v;
    v[i] = 1 + r(i, i) - r(j, j) - r(k, k);
    v[j] = r(j, i) + r(i, j);
    v[k] = r(k, i) + r(i, k);
    q = {r(k, j) - r(j, k), v.x, v.y, v.z};
  }
  return q.normalized();
}

inline Quat Quat::from_yaw_pitch_roll(const YawPitchRoll& a) {
  const SinCos y = sincos(0.5 * a.yaw), p = sincos(0.5 * a.pitch), r = sincos(0.5 * a.roll);
  return Quat{y.cos, 0, 0, y.sin} * Quat{p.cos, 0, p.sin, 0} * Quat{r.cos, r.sin, 0, 0};
}

inline YawPitchRoll Quat::yaw_pitch_roll() const {
  const double s = 2 * (w * y - x * z);
  return {yaw(), asin(s > 1 ? 1 : s < -1 ? -1 : s), atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))};
}

inline Quat Quat::between(const Vec3& a, const Vec3& b) {
  const Vec3 ua = math::normalized(a), ub = math::normalized(b);
  const double c = dot(ua, ub);
  if (c < -1 + 1e-12) {
    const Vec3 least = fabs(ua.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 axis = math::normalized(cross(ua, least));
    return {0, axis.x, axis.y, axis.z};
  }
  const Vec3 n = cross(ua, ub);
  return Quat{1 + c, n.x, n.y, n.z}.normalized();
}

}  // namespace sinew::math
