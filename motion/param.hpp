#pragma once
// Numbers of motions with unit, range and meaning: robot files, searches and pages read the same table.
#include <span>
#include <string_view>

namespace sinew::motion {

template <class T>
struct Param {
  std::string_view name;
  double T::*value;
  std::string_view unit;
  double least, most;
  std::string_view doc;
};

/// The row with this name; null: there is none.
template <class T>
constexpr const Param<T>* find_param(std::span<const Param<T>> table, std::string_view name) {
  for (const Param<T>& row : table)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace sinew::motion
