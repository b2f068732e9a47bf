#pragma once
// Matrices whose size is known at run time, and what least squares needs of them. Every sum runs in one fixed order, so
// the same numbers give the same bits on every machine.
// Thread:  any.   RT: no, they allocate.
#include <cstddef>
#include <optional>
#include <vector>

namespace sinew::identify {

/// Row-major.
class Dense {
 public:
  Dense() = default;
  Dense(std::size_t rows, std::size_t columns) : rows_(rows), columns_(columns), a_(rows * columns) {}

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  double& operator()(std::size_t r, std::size_t c) { return a_[r * columns_ + c]; }
  double operator()(std::size_t r, std::size_t c) const { return a_[r * columns_ + c]; }
  double* row(std::size_t r) { return a_.data() + r * columns_; }
  const double* row(std::size_t r) const { return a_.data() + r * columns_; }

 private:
  std::size_t rows_ = 0, columns_ = 0;
  std::vector<double> a_;
};

/// Inverse of a symmetric positive definite matrix, by Cholesky. Nothing: it is not positive definite, or not finite.
std::optional<Dense> inverse_of_positive(const Dense& a);

/// x of a x = b for such a matrix. Nothing: as above.
std::optional<std::vector<double>> solve_positive(const Dense& a, const std::vector<double>& b);

/// Eigenvalues of a symmetric matrix, the smallest first; column i of `vectors` belongs to value i.
/// Source:  C. Jacobi's rotations, as in G. Golub and C. Van Loan, Matrix Computations (2013), 8.5.
struct SymmetricEigen {
  std::vector<double> values;
  Dense vectors;
};
SymmetricEigen symmetric_eigen(Dense a);

}  // namespace sinew::identify
