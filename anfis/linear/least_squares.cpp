// SPDX-License-Identifier: Apache-2.0
#include "anfis/linear/least_squares.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>

#include "base/linear/dense_solve.h"

namespace soak::anfis {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

/// D that gives the columns of A D unit norm; a column of zeros keeps its scale and is found to be dependent.
Eigen::VectorXd unit_norm_scale(const Eigen::Ref<const Eigen::MatrixXd>& a) {
  const Eigen::VectorXd norm = a.colwise().norm().transpose();
  return (norm.array() > 0.0).select(norm.cwiseInverse(), 1.0);
}

/// Values with zeros, or repetitions of the last, up to `rows`.
template <class Value>
std::vector<Value> filled_up(std::vector<Value> values, std::size_t rows, Value with) {
  if (!values.empty()) values.resize(rows, with);
  return values;
}

}  // namespace

GroupWhitening::GroupWhitening(const TrainingData& data, std::size_t padded_rows)
    : GroupWhitening(
          std::max(padded_rows, data.rows()),
          filled_up(data.weight.empty() ? std::vector<double>(data.rows(), 1.0) : data.weight,
                    std::max(padded_rows, data.rows()), 0.0),
          filled_up(data.group, std::max(padded_rows, data.rows()), data.group.empty() ? 0 : data.group.back()),
          data.group_variance) {
  if (data.precision_factor.empty()) return;
  const auto rows = static_cast<Eigen::Index>(data.rows());
  factor_ = Eigen::Map<const Eigen::MatrixXd>(data.precision_factor.data(), rows, rows);
}

GroupWhitening::GroupWhitening(std::size_t rows, std::span<const double> weight, std::span<const int> group,
                               double group_variance)
    : root_weight_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows))) {
  assert(weight.empty() || weight.size() == rows);
  assert(group.empty() || group.size() == rows);
  assert(group_variance >= 0.0);
  for (std::size_t i = 0; i < weight.size(); ++i) root_weight_(static_cast<Eigen::Index>(i)) = std::sqrt(weight[i]);
  if (group.empty() || group_variance == 0.0) return;
  std::map<int, std::size_t> position;
  for (std::size_t i = 0; i < rows; ++i) {
    const auto found = position.try_emplace(group[i], groups_.size());
    if (found.second) groups_.emplace_back();
    groups_[found.first->second].rows.push_back(static_cast<Eigen::Index>(i));
  }
  for (Group& g : groups_) {
    double norm = 0.0;  // u^T u
    for (const Eigen::Index row : g.rows) norm += root_weight_(row) * root_weight_(row);
    g.contiguous = g.rows.back() - g.rows.front() + 1 == static_cast<Eigen::Index>(g.rows.size());
    g.factor = (1.0 - 1.0 / std::sqrt(1.0 + group_variance * norm)) / norm;
  }
}

void GroupWhitening::apply(Eigen::Ref<Eigen::MatrixXd> values) const {
  if (factor_.size() > 0) return apply_factor(values);
  values.array().colwise() *= root_weight_.array();
  shrink_groups(values);
}

void GroupWhitening::apply_transposed(Eigen::Ref<Eigen::MatrixXd> values) const {
  if (factor_.size() > 0) return apply_factor_transposed(values);
  shrink_groups(values);
  values.array().colwise() *= root_weight_.array();
}

// z <- R z in place: entry j is read before any step changes it.
void GroupWhitening::apply_factor(Eigen::Ref<Eigen::MatrixXd> values) const {
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    auto z = values.col(column);
    for (Eigen::Index j = 0; j < factor_.cols(); ++j) {
      const double at_j = z(j);
      z.head(j) += at_j * factor_.col(j).head(j);
      z(j) = at_j * factor_(j, j);
    }
    z.tail(z.size() - factor_.rows()).setZero();
  }
}

void GroupWhitening::apply_factor_transposed(Eigen::Ref<Eigen::MatrixXd> values) const {
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    auto z = values.col(column);
    for (Eigen::Index j = factor_.cols(); j-- > 0;) z(j) = factor_.col(j).head(j + 1).dot(z.head(j + 1));
    z.tail(z.size() - factor_.rows()).setZero();
  }
}

// z <- z - kappa u (u^T z) / (u^T u)
void GroupWhitening::shrink(const Group& group, Eigen::Ref<Eigen::VectorXd> column) const {
  if (group.contiguous) {
    const auto u = root_weight_.segment(group.rows.front(), static_cast<Eigen::Index>(group.rows.size()));
    auto z = column.segment(group.rows.front(), u.size());
    const double projection = u.dot(z);
    z -= (group.factor * projection) * u;
    return;
  }
  double projection = 0.0;
  for (const Eigen::Index row : group.rows) projection += root_weight_(row) * column(row);
  for (const Eigen::Index row : group.rows) column(row) -= group.factor * projection * root_weight_(row);
}

void GroupWhitening::shrink_groups(Eigen::Ref<Eigen::MatrixXd> values) const {
  for (Eigen::Index column = 0; column < values.cols(); ++column) {
    for (const Group& group : groups_) shrink(group, values.col(column));
  }
}

LeastSquaresFit solve_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                    const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  LeastSquaresFit fit;
  if (!a.allFinite() || !b.allFinite()) {
    fit.coefficients.setConstant(a.cols(), kNotANumber);
    fit.residual_sum_of_squares = kNotANumber;
    return fit;
  }
  const Eigen::VectorXd scale = unit_norm_scale(a);
  const auto solution = base::solve_orthogonal_with_factor(a * scale.asDiagonal(), b, tolerance);
  fit.rank = solution.rank;
  fit.coefficients = scale.asDiagonal() * solution.x;
  fit.residual_sum_of_squares = (a * fit.coefficients - b).squaredNorm();
  fit.covariance_factor = scale.asDiagonal() * solution.factor;
  return fit;
}

Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                           const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance) {
  if (!a.allFinite() || !b.allFinite()) return Eigen::VectorXd::Constant(a.cols(), kNotANumber);
  const Eigen::VectorXd scale = unit_norm_scale(a);
  const Eigen::VectorXd x = base::solve_orthogonal(a * scale.asDiagonal(), Eigen::VectorXd(b), tolerance);
  return scale.asDiagonal() * x;
}

SequentialLeastSquares::SequentialLeastSquares(std::size_t columns, double initial_covariance, double forgetting)
    : initial_covariance_(initial_covariance),
      forgetting_(forgetting),
      coefficients_(static_cast<Eigen::Index>(columns)),
      covariance_(coefficients_.size(), coefficients_.size()),
      direction_(coefficients_.size()),
      next_(coefficients_.size()) {
  assert(columns >= 1 && initial_covariance > 0.0 && forgetting > 0.0 && forgetting <= 1.0);
  restart();
}

bool SequentialLeastSquares::update(const Eigen::Ref<const Eigen::VectorXd>& a, double b) {
  assert(a.size() == coefficients_.size());
  direction_.noalias() = covariance_ * a;
  const double variance = a.dot(direction_);
  // [AH05 eq. 5.14] X + S_{i+1} a (b - a^T X), where S_{i+1} a = S_i a / (lambda + a^T S_i a)
  next_ = coefficients_ + direction_ * ((b - a.dot(coefficients_)) / (forgetting_ + variance));
  if (!next_.allFinite() || !std::isfinite(variance) || !std::isfinite(direction_.squaredNorm())) return false;
  coefficients_.swap(next_);
  // [AH05 eq. 5.14] (S - S a a^T S / (lambda + a^T S a)) / lambda
  subtract(1.0 / (forgetting_ + variance));
  if (forgetting_ < 1.0) {
    covariance_ /= forgetting_;
    limit_covariance();
  }
  return true;
}

void SequentialLeastSquares::restart() {
  coefficients_.setZero();
  restart_covariance();
}

void SequentialLeastSquares::restart(const Eigen::Ref<const Eigen::VectorXd>& coefficients) {
  assert(coefficients.size() == coefficients_.size());
  coefficients_ = coefficients;
  restart_covariance();
}

void SequentialLeastSquares::restart_covariance() {
  covariance_.setZero();
  covariance_.diagonal().setConstant(initial_covariance_);
}

void SequentialLeastSquares::limit_covariance() {
  for (Eigen::Index j = 0; j < covariance_.cols(); ++j) {
    const double variance = covariance_(j, j);
    if (variance <= 2.0 * initial_covariance_) continue;
    // S - S e_j e_j^T S (1 - eta / S_jj) / S_jj
    direction_ = covariance_.col(j);
    subtract((1.0 - initial_covariance_ / variance) / variance);
  }
}

/// S <- S - share direction_ direction_^T, one triangle mirrored to the other.
void SequentialLeastSquares::subtract(double share) {
  for (Eigen::Index column = 0; column < covariance_.cols(); ++column) {
    const double scaled = share * direction_(column);
    for (Eigen::Index row = column; row < covariance_.rows(); ++row) {
      covariance_(row, column) -= direction_(row) * scaled;
      covariance_(column, row) = covariance_(row, column);
    }
  }
}

}  // namespace soak::anfis
