#pragma once
#include <cstddef>
#include <span>

namespace sinew::learn {

/// Solves A x = b for a general square matrix by elimination with row pivots; every sum runs in one fixed order, so the
/// same numbers give the same bits on every machine (a blocked solver chooses its blocks by the processor's caches).
/// Shape:   `a` is n x n, row-major, n = b.size(); it is destroyed. `b` becomes x.
/// Thread:  any.   RT: bounded by n^3, allocates nothing.
/// Errors:  false when A is singular or something is not finite; both hold nothing useful then.
[[nodiscard]] bool solve_in_place(std::span<double> a, std::span<double> b);

}  // namespace sinew::learn
