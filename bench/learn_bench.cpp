// One decision added to the sums of LSTD-Q, and the solution of those sums, beside the bare arithmetic: the same
// products and sums on the same numbers, in plain loops over arrays.
// usage: learn_bench [PAIRS]
#include <array>
#include <cstdlib>
#include <vector>

#include "learn/dense_solver.hpp"
#include "learn/lstd_q.hpp"
#include "math/random.hpp"
#include "pairs.hpp"

namespace {

using namespace sinew;

constexpr std::size_t kBasis = 49, kActions = 5, kWeights = kBasis * kActions;  // of the landing's way aside
constexpr std::size_t kDecisions = 64;                                          // for each call

struct Decision {
  std::array<double, kBasis> basis, next;
  std::size_t action, next_action;
  double reward;
};

std::vector<Decision> decisions() {
  math::Random random(1);
  std::vector<Decision> all(kDecisions);
  for (Decision& d : all) {
    for (double& f : d.basis) f = random.uniform();
    for (double& f : d.next) f = random.uniform();
    d.action = random.below(kActions), d.next_action = random.below(kActions), d.reward = -random.uniform();
  }
  return all;
}

/// Of discrete actions: rows of one action, columns of two.
void bare_update(std::vector<double>& a, std::vector<double>& b, const Decision& d, double discount) {
  double* const rows = a.data() + d.action * kBasis * kWeights;
  for (std::size_t r = 0; r < kBasis; ++r) {
    const double f = d.basis[r];
    double* const now = rows + r * kWeights + d.action * kBasis;
    double* const then = rows + r * kWeights + d.next_action * kBasis;
    for (std::size_t c = 0; c < kBasis; ++c) now[c] += f * d.basis[c];
    for (std::size_t c = 0; c < kBasis; ++c) then[c] -= f * discount * d.next[c];
    b[d.action * kBasis + r] += f * d.reward;
  }
}

/// Elimination without pivots.
void bare_solve(std::vector<double>& a, std::vector<double>& b) {
  const std::size_t n = b.size();
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t r = p + 1; r < n; ++r) {
      const double f = a[r * n + p] / a[p * n + p];
      for (std::size_t c = p + 1; c < n; ++c) a[r * n + c] -= f * a[p * n + c];
      b[r] -= f * b[p];
    }
  for (std::size_t r = n; r-- > 0;) {
    for (std::size_t c = r + 1; c < n; ++c) b[r] -= a[r * n + c] * b[c];
    b[r] /= a[r * n + r];
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 31;
  const std::vector<Decision> all = decisions();
  learn::LstdQ sums(kWeights);
  const auto ours = [&] {
    for (const Decision& d : all) {
      learn::Actions::Columns now{}, then{};
      now[d.action] = then[d.next_action] = 1;
      sums.add(d.basis, now, d.next, then, 0.95, d.reward);
    }
    bench::keep(sums);
  };
  std::vector<double> a(kWeights * kWeights), b(kWeights);
  const auto bare = [&] {
    for (const Decision& d : all) bare_update(a, b, d, 0.95);
    bench::keep(a);
  };
  bool good = bench::report("LSTD-Q update x 64 / bare sums", bench::alternate(pairs, 100, ours, bare), 1.3);

  math::Random random(2);
  std::vector<double> matrix(kWeights * kWeights), right(kWeights);
  for (double& v : matrix) v = random.uniform(-1, 1);
  for (std::size_t i = 0; i < kWeights; ++i) matrix[i * kWeights + i] += 20, right[i] = random.uniform();
  const auto solve = [&] {
    std::vector<double> m(matrix), r(right);
    if (!learn::solve_in_place(m, r)) std::abort();
    bench::keep(r);
  };
  const auto eliminate = [&] {
    std::vector<double> m(matrix), r(right);
    bare_solve(m, r);
    bench::keep(r);
  };
  good &= bench::report("solution of 245 sums / bare", bench::alternate(pairs, 2, solve, eliminate), 1.3);
  return good ? 0 : 1;
}
