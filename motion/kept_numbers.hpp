#pragma once
// The state of motions as a row of numbers: a module keeps it in a record, and goes on from it elsewhere.
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "math/linear.hpp"
#include "motion/pendulum.hpp"
#include "motion/planar.hpp"

namespace sinew::motion {

/// Calls `visit` with each number, flag and enumeration that is in the given values, in their order.
template <class Visit, class T>
void each_number(Visit& visit, T& value) {
  if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
    visit(value);
  else
    value.each_part([&](auto&... parts) { (each_number(visit, parts), ...); });
}
template <class Visit>
void each_number(Visit& visit, math::Vec3& v) {
  visit(v.x), visit(v.y), visit(v.z);
}
template <class Visit>
void each_number(Visit& visit, math::Quat& q) {
  visit(q.w), visit(q.x), visit(q.y), visit(q.z);
}
template <class Visit>
void each_number(Visit& visit, Vec2& v) {
  visit(v.x), visit(v.y);
}
template <class Visit>
void each_number(Visit& visit, Planar& p) {
  each_number(visit, p.at_m), visit(p.yaw_rad);
}
template <class Visit>
void each_number(Visit& visit, Pendulum& p) {
  visit(p.com_m), visit(p.dcm_m);
}
template <class Visit, class T, std::size_t N>
void each_number(Visit& visit, std::array<T, N>& all) {
  for (T& one : all) each_number(visit, one);
}

/// How many numbers `state` has.
template <class T>
std::size_t count_numbers(T& state) {
  std::size_t count = 0;
  const auto visit = [&](auto&) { ++count; };
  each_number(visit, state);
  return count;
}

/// From a state to numbers, which hold integers up to 2^53, and back; answers how many there were. RT: yes.
template <class T>
std::size_t write_numbers(T& state, std::span<double> out) {
  std::size_t next = 0;
  const auto visit = [&](auto& value) { out[next++] = static_cast<double>(value); };
  each_number(visit, state);
  return next;
}
template <class T>
std::size_t read_numbers(T& state, std::span<const double> in) {
  std::size_t next = 0;
  const auto visit = [&]<class V>(V& value) {
    if constexpr (std::is_same_v<V, bool>)
      value = in[next++] != 0;
    else if constexpr (std::is_enum_v<V>)
      value = static_cast<V>(static_cast<std::underlying_type_t<V>>(in[next++]));
    else
      value = static_cast<V>(in[next++]);
  };
  each_number(visit, state);
  return next;
}

}  // namespace sinew::motion
