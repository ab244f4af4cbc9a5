// SPDX-License-Identifier: Apache-2.0
#include "anfis/objective/consequents.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "anfis/linear/least_squares.h"
#include "anfis/objective/kernels.h"

namespace soak::anfis::training {
namespace {

// Memberships that overlap so far that a consequent moves the curve by 1e-10 of its size are one membership.
constexpr double kConsequentTolerance = 1e-10;

constexpr Eigen::Index kBlockRows = 512;

Eigen::Index padded(Eigen::Index rows) {
  constexpr auto lanes = static_cast<Eigen::Index>(kLanes);
  return (rows + lanes - 1) / lanes * lanes;
}

}  // namespace

void set_level(Model& model, const TrainingData& data) {
  if (!std::isinf(data.group_variance)) return;
  struct Sum {
    double weighted = 0.0;
    double weight = 0.0;
  };
  const std::vector<double> r = residuals(data, model);
  std::map<int, Sum> sums;
  for (std::size_t i = 0; i < data.rows(); ++i) {
    const double weight = data.weight.empty() ? 1.0 : data.weight[i];
    Sum& sum = sums[data.group[i]];
    sum.weighted += weight * r[i];
    sum.weight += weight;
  }
  double level = 0.0;
  for (const auto& [group, sum] : sums) level += sum.weighted / sum.weight / static_cast<double>(sums.size());
  for (Rule& rule : model.rules) rule.offset += level / model.output.half_range;
}

ConsequentSolver::ConsequentSolver(Eigen::Index rows, Eigen::Index columns)
    : block_(std::min(rows, std::max(kBlockRows, padded(4 * columns)))),
      work_(block_ < rows ? block_ + padded(columns + 1) : rows, columns + 1),
      factor_(columns + 1, columns + 1),
      scale_(columns),
      scaled_(columns, columns),
      qr_(columns, kConsequentTolerance),
      right_(columns),
      solution_(columns) {}

void ConsequentSolver::condense(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  Eigen::Index above = 0;  // rows of the factor so far
  for (Eigen::Index first = 0; first < a.rows(); first += block_) {
    const Eigen::Index rows = std::min(block_, a.rows() - first);
    work_.topRows(above).setZero();
    if (above > 0) work_.topRows(factor_.rows()) = factor_;
    work_.middleRows(above, rows).leftCols(a.cols()) = a.middleRows(first, rows);
    work_.middleRows(above, rows).rightCols<1>() = b.segment(first, rows);
    work_.bottomRows(work_.rows() - above - rows).setZero();
    triangular_factor(static_cast<std::size_t>(work_.rows()), static_cast<std::size_t>(work_.cols()), work_.data(),
                      factor_.data());
    above = padded(factor_.rows());
  }
}

const Eigen::VectorXd& ConsequentSolver::solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  condense(a, b);
  if (!factor_.allFinite()) {
    solution_.setConstant(std::numeric_limits<double>::quiet_NaN());
    return solution_;
  }
  if (scale_and_decompose() == a.cols()) {
    right_ = factor_.col(a.cols()).head(a.cols());
    qr_.solve(right_, solution_);
    solution_.array() *= scale_.array();
  } else {
    solution_ = least_squares_coefficients(factor_.topLeftCorner(a.cols(), a.cols()),
                                           factor_.col(a.cols()).head(a.cols()), kConsequentTolerance);
  }
  return solution_;
}

/// Columns of unit norm into the pivoting QR; the rank that it finds.
Eigen::Index ConsequentSolver::scale_and_decompose() {
  const Eigen::Index n = solution_.size();
  // A column that free offsets of the groups have swept away is rounding error: unit norm would make it real.
  const double least = kConsequentTolerance * factor_.leftCols(n).colwise().norm().maxCoeff();
  for (Eigen::Index k = 0; k < n; ++k) {
    if (factor_.col(k).head(n).norm() < least) factor_.col(k).setZero();
    const double norm = factor_.col(k).head(n).norm();
    scale_(k) = norm > 0.0 ? 1.0 / norm : 1.0;
    scaled_.col(k) = scale_(k) * factor_.col(k).head(n);
  }
  return qr_.decompose(scaled_);
}

}  // namespace soak::anfis::training
