// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

// Dense linear algebra behind plain functions. Eigen's decompositions are templates of which each costs seconds to
// compile: all that the rooms use are instantiated in this folder, and nowhere else.
//
// Vector and matrix right-hand sides take different paths inside Eigen and differ in the last bits: the overloads keep
// them apart. Sizes must fit (Eigen's assertions). Numbers that are not finite lead to numbers that are not finite,
// unless a function says otherwise.
namespace soak::base {

// --- Symmetric matrices: only the lower triangle is read.

/// a^-1 b by L D L^T with symmetric pivoting; a positive or negative semidefinite.
[[nodiscard]] Eigen::VectorXd solve_ldlt(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd solve_ldlt(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// One such factorisation for many right-hand sides.
class Ldlt {
 public:
  explicit Ldlt(const Eigen::MatrixXd& a);
  Ldlt(Ldlt&&) noexcept;
  Ldlt& operator=(Ldlt&&) noexcept;
  ~Ldlt();

  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Factor;
  std::unique_ptr<const Factor> factor_;
};

/// a^-1 b by Cholesky's L L^T; a positive definite.
[[nodiscard]] Eigen::VectorXd solve_llt(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd solve_llt(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Cholesky's factor L, a = L L^T, zero above the diagonal. For matrices that are positive definite by construction:
/// where one is not, L is meaningless from the failing column on.
[[nodiscard]] Eigen::MatrixXd cholesky(const Eigen::MatrixXd& a);
[[nodiscard]] Eigen::Matrix2d cholesky(const Eigen::Matrix2d& a);
/// The same; nothing where a is not positive definite.
[[nodiscard]] std::optional<Eigen::MatrixXd> try_cholesky(const Eigen::MatrixXd& a);

/// L^-1 b for a lower triangular L.
[[nodiscard]] Eigen::VectorXd solve_lower(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd solve_lower(const Eigen::MatrixXd& lower, const Eigen::MatrixXd& b);
void solve_lower_in_place(const Eigen::MatrixXd& lower, Eigen::Ref<Eigen::MatrixXd> b);

/// u^-1 b for an upper triangular u.
[[nodiscard]] Eigen::MatrixXd solve_upper(const Eigen::MatrixXd& upper, const Eigen::MatrixXd& b);

/// a = vectors diag(values) vectors^T, values rising.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;  ///< one per column, orthonormal
};
[[nodiscard]] SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
struct SymmetricEigen2 {
  Eigen::Vector2d values;
  Eigen::Matrix2d vectors;
};
[[nodiscard]] SymmetricEigen2 symmetric_eigen(const Eigen::Matrix2d& a);

// --- Least squares, min ||a x - b||.

/// By Householder QR with column pivoting; columns beyond Eigen's numerical rank get x = 0.
[[nodiscard]] Eigen::VectorXd solve_pivoted_qr(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::Vector4d solve_pivoted_qr(const Eigen::MatrixX4d& a, const Eigen::VectorXd& b);

/// R of the Householder QR without pivoting, a = Q R, columns x columns; a has at least as many rows as columns.
[[nodiscard]] Eigen::MatrixXd upper_of_qr(const Eigen::MatrixXd& a);

/// Q^T b of the pivoted QR: its squares from `rank` on are what least squares leaves.
struct TurnedByQr {
  Eigen::Index rank = 0;
  Eigen::VectorXd turned;
};
[[nodiscard]] TurnedByQr turn_by_pivoted_qr(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// By the complete orthogonal decomposition: where a is rank-deficient, the solution of least norm. Pivots below
/// `threshold` times the largest count as zero; without one, Eigen's own (columns times the machine's epsilon).
[[nodiscard]] Eigen::VectorXd solve_orthogonal(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                               std::optional<double> threshold = std::nullopt);
[[nodiscard]] Eigen::MatrixXd solve_orthogonal(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                                               std::optional<double> threshold = std::nullopt);

/// The same with what a covariance needs.
struct OrthogonalSolution {
  Eigen::VectorXd x;
  Eigen::Index rank = 0;
  Eigen::MatrixXd factor;  ///< columns x rank: factor factor^T = (a^T a)^+
};
[[nodiscard]] OrthogonalSolution solve_orthogonal_with_factor(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                                              double threshold);

/// Square systems of one size, again and again, without allocating memory: QR with column pivoting.
class SquareQr {
 public:
  /// Pivots below `threshold` times the largest count as zero.
  SquareQr(Eigen::Index size, double threshold);
  SquareQr(SquareQr&&) noexcept;
  SquareQr& operator=(SquareQr&&) noexcept;
  ~SquareQr();

  /// Decomposes a, size x size; its numerical rank.
  Eigen::Index decompose(const Eigen::MatrixXd& a);
  /// x of a x = b for the matrix of full rank decomposed last; b is overwritten.
  void solve(Eigen::VectorXd& b, Eigen::VectorXd& x) const;

 private:
  struct Decomposition;
  std::unique_ptr<Decomposition> qr_;
};

/// a^-1 b by LU with partial pivoting; a invertible.
[[nodiscard]] Eigen::MatrixXd solve_lu(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Inverse of a small matrix in closed form; a invertible.
[[nodiscard]] Eigen::Matrix2d inverse(const Eigen::Matrix2d& a);
[[nodiscard]] Eigen::Matrix3d inverse(const Eigen::Matrix3d& a);

// --- Singular values, by one-sided Jacobi rotations: accurate to the last digits also of the small ones.

/// a = u diag(singular) v^T, singular values falling.
struct Svd {
  Eigen::MatrixXd u;
  Eigen::VectorXd singular;
  Eigen::MatrixXd v;
};
/// As many columns of u and v as there are singular values.
[[nodiscard]] Svd thin_svd(const Eigen::MatrixXd& a);
/// All columns of v; u is left empty.
[[nodiscard]] Svd full_v_svd(const Eigen::MatrixXd& a);
[[nodiscard]] Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);
/// Least squares of least norm; singular values below `threshold` times the largest count as zero.
[[nodiscard]] Eigen::VectorXd solve_svd(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

}  // namespace soak::base
