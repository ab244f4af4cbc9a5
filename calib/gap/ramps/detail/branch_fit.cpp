// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/branch_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/linear/dense_solve.h"

namespace soak::calib::gap::ramps {
namespace {

/// Cubic B-splines on `intervals` equal intervals of low_c..high_c at the temperatures (one row each, intervals + 3
/// columns that sum to 1). Temperatures beyond the range count as its nearer end. Source: C. de Boor, A Practical Guide
/// to Splines, 2001, ch. X, for equal distances. Needs low_c < high_c, intervals > 0.
Eigen::MatrixXd ramp_spline(const Eigen::VectorXd& temp_c, double low_c, double high_c, int intervals) {
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(temp_c.size(), intervals + 3);
  for (Eigen::Index i = 0; i < temp_c.size(); ++i) {
    const double place = std::clamp((temp_c(i) - low_c) / (high_c - low_c), 0.0, 1.0) * intervals;
    const int k = std::min(static_cast<int>(place), intervals - 1);
    const double u = place - k;
    // The four pieces of a cubic B-spline with knots at whole numbers.
    basis(i, k) = (1 - u) * (1 - u) * (1 - u) / 6;
    basis(i, k + 1) = (3 * u * u * u - 6 * u * u + 4) / 6;
    basis(i, k + 2) = (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6;
    basis(i, k + 3) = u * u * u / 6;
  }
  return basis;
}

constexpr std::array kIntervals = {2, 3, 4, 5, 6, 8, 10};
constexpr Eigen::Index kLeastRows = 8;
constexpr double kMostCorrelation = 0.9;

/// What is left of the branches about their own curves.
struct Remainder {
  double squares = 0.0;
  double neighbours = 0.0;  ///< sum of the products of neighbouring residuals
  double rows = 0.0;
  double parameters = 0.0;
};

void add_branch(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, int intervals, Remainder& total) {
  const Eigen::Index rows = values.size();
  if (rows < kLeastRows) return;
  // Two rows for each column at least.
  const int most = std::max(1, static_cast<int>(rows / 2) - 3);
  const Eigen::MatrixXd basis =
      ramp_spline(temp_c, temp_c.minCoeff(), temp_c.maxCoeff(), std::clamp(intervals, 1, most));
  const Eigen::VectorXd left = values - basis * base::solve_orthogonal(basis, values);
  total.squares += left.squaredNorm();
  total.neighbours += left.head(rows - 1).dot(left.tail(rows - 1));
  total.rows += static_cast<double>(rows);
  total.parameters += static_cast<double>(basis.cols());
}

Remainder remainder_of(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, const std::vector<int>& branch,
                       int intervals) {
  const double range_c = temp_c.maxCoeff() - temp_c.minCoeff();
  Remainder total;
  Eigen::Index first = 0;
  for (Eigen::Index i = 1; i <= values.size(); ++i) {
    if (i < values.size() && branch[static_cast<std::size_t>(i)] == branch[static_cast<std::size_t>(first)]) continue;
    const Eigen::VectorXd own_c = temp_c.segment(first, i - first);
    const double share = (own_c.maxCoeff() - own_c.minCoeff()) / range_c;
    if (share > 0.0) {
      add_branch(values.segment(first, i - first), own_c, static_cast<int>(std::lround(intervals * share)), total);
    }
    first = i;
  }
  return total;
}

/// Fits a spline to every branch alone. Rows in the order of time, `branch` rising; at least 8 of them in some branch,
/// the branches with fewer do not count.
BranchNoise branch_noise(const Eigen::VectorXd& values, const Eigen::VectorXd& temp_c, const std::vector<int>& branch) {
  BranchNoise best;
  double least = std::numeric_limits<double>::infinity();
  for (const int intervals : kIntervals) {
    const Remainder left = remainder_of(values, temp_c, branch, intervals);
    if (left.rows <= left.parameters || left.squares <= 0.0) continue;
    const double criterion = left.rows * std::log(left.squares / left.rows) + left.parameters * std::log(left.rows);
    if (criterion >= least) continue;
    least = criterion;
    best.intervals = intervals;
    best.sigma = std::sqrt(left.squares / (left.rows - left.parameters));
    // A fit of p parameters to n rows makes neighbours look opposite by about p/n.
    best.correlation = std::clamp(left.neighbours / left.squares + left.parameters / left.rows, 0.0, kMostCorrelation);
  }
  return best;
}

constexpr double kLeastJudged = 4.0;
constexpr double kTinyRidge = 1e-8;  ///< of the mean diagonal: where a training has no rows the spline stays finite
constexpr double kPriorVariance = 9.0;

/// Normal equations of some rows.
struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd side;
};

Normal normal_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& values, const std::vector<bool>& keep) {
  Normal sum{Eigen::MatrixXd::Zero(columns.cols(), columns.cols()), Eigen::VectorXd::Zero(columns.cols())};
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    if (!keep[static_cast<std::size_t>(i)]) continue;
    sum.matrix.selfadjointView<Eigen::Lower>().rankUpdate(columns.row(i).transpose());
    sum.side += values(i) * columns.row(i).transpose();
  }
  sum.matrix = sum.matrix.selfadjointView<Eigen::Lower>();
  return sum;
}

}  // namespace

std::optional<BranchFit> BranchFit::of(const RampRecording& recording, const FoldPlan& plan, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  const auto& rows = recording.observations.rows;
  BranchFit fit;
  fit.sensor_ = sensor;
  std::vector<int> branch;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].sensor[s].count == 0 || !std::isfinite(rows[i].sensor[s].mean)) continue;
    fit.row_.push_back(i);
    fit.run_.push_back(rows[i].run);
    fit.fold_.push_back(plan.fold[i]);
    fit.sweep_.push_back(rows[i].sweep);
    branch.push_back(recording.branch[i]);
    fit.piece_.push_back(recording.branch[i] * (plan.count + 1) + plan.fold[i]);
  }
  const auto count = static_cast<Eigen::Index>(fit.row_.size());
  if (count == 0) return std::nullopt;
  fit.values_.resize(count);
  fit.temp_c_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Observation& row = rows[fit.row_[static_cast<std::size_t>(i)]];
    fit.values_(i) = row.sensor[s].mean;
    fit.temp_c_(i) = row.sensor_temp_c[s];
  }
  if (fit.values_.maxCoeff() == fit.values_.minCoeff()) return std::nullopt;
  fit.values_.array() -= fit.values_.mean();
  fit.low_c_ = fit.temp_c_.minCoeff() - 1.0;
  fit.high_c_ = fit.temp_c_.maxCoeff() + 1.0;
  fit.noise_ = branch_noise(fit.values_, fit.temp_c_, branch);
  if (!(fit.noise_.sigma > 0.0)) return std::nullopt;
  fit.choose_judged_rows(plan.count);
  const auto enough = std::count_if(fit.weight_.begin(), fit.weight_.end(), [](double w) { return w > 0.0; });
  if (enough < 2) return std::nullopt;
  fit.base_ = fit.predict_folds(nullptr);
  return fit;
}

void BranchFit::choose_judged_rows(int folds) {
  judged_.assign(row_.size(), false);
  for (int fold = 0; fold < folds; ++fold) {
    double low_c = std::numeric_limits<double>::infinity();
    double high_c = -low_c;
    const auto own = std::find(fold_.begin(), fold_.end(), fold);
    bool lone = true;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      if (fold_[i] == fold) continue;
      lone = lone && (own == fold_.end() || run_[i] != run_[static_cast<std::size_t>(own - fold_.begin())]);
      low_c = std::min(low_c, temp_c_(static_cast<Eigen::Index>(i)));
      high_c = std::max(high_c, temp_c_(static_cast<Eigen::Index>(i)));
    }
    std::vector<std::size_t> within;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      const double here_c = temp_c_(static_cast<Eigen::Index>(i));
      if (fold_[i] == fold && here_c >= low_c && here_c <= high_c) within.push_back(i);
    }
    const bool enough = static_cast<double>(within.size()) >= kLeastJudged;
    weight_.push_back(enough ? static_cast<double>(within.size()) : 0.0);
    lone_.push_back(lone);
    for (const std::size_t i : within) judged_[i] = enough;
  }
}

BranchFit::Design BranchFit::design(const Candidate* shape) const {
  Eigen::VectorXd temp_c = temp_c_;
  const Eigen::MatrixXd none;
  const Eigen::MatrixXd& added = shape == nullptr ? none : shape->columns[index_of(sensor_)];
  const auto row = [&](Eigen::Index i) { return static_cast<Eigen::Index>(row_[static_cast<std::size_t>(i)]); };
  if (shape != nullptr && shape->shifts) {
    for (Eigen::Index i = 0; i < temp_c.size(); ++i) temp_c(i) += added(row(i), 0);
  }
  const Eigen::MatrixXd curve = ramp_spline(temp_c, low_c_, high_c_, noise_.intervals);
  const int runs = *std::max_element(run_.begin(), run_.end());
  const Eigen::Index terms = shape == nullptr || shape->shifts ? 0 : added.cols();
  Design made;
  made.base = curve.cols() + runs;
  made.columns = Eigen::MatrixXd::Zero(temp_c.size(), made.base + terms);
  made.columns.leftCols(curve.cols()) = curve;
  for (Eigen::Index i = 0; i < temp_c.size(); ++i) {
    const int run = run_[static_cast<std::size_t>(i)];
    if (run > 0) made.columns(i, curve.cols() + run - 1) = 1.0;
    if (terms > 0) made.columns.row(i).tail(terms) = added.row(row(i));
  }
  return made;
}

// Neighbours of one piece: w_i = (x_i − ρ x_{i−1})/√(1 − ρ²), which leaves the variance of an AR(1) process as it is.
Eigen::MatrixXd BranchFit::white(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result = columns;
  const double rho = noise_.correlation;
  for (Eigen::Index i = 1; i < columns.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (piece_[k] != piece_[k - 1]) continue;
    result.row(i) = (columns.row(i) - rho * columns.row(i - 1)) / std::sqrt(1.0 - rho * rho);
  }
  return result;
}

Eigen::VectorXd BranchFit::ridge(const Design& design, const Eigen::MatrixXd& normal) const {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(normal.rows(), kTinyRidge * normal.diagonal().mean());
  if (design.base == normal.rows()) return diagonal;
  double square = 0.0;
  for (const double error : base_.error) square += error / static_cast<double>(base_.error.size());
  for (Eigen::Index k = design.base; k < normal.rows(); ++k) {
    const double size = design.columns.col(k).squaredNorm() / static_cast<double>(design.columns.rows());
    diagonal(k) = noise_.sigma * noise_.sigma * size / (kPriorVariance * square) + 1e-300;
  }
  return diagonal;
}

double BranchFit::mean_square(const Eigen::VectorXd& error, int fold) const {
  double sum = 0.0;
  double squares = 0.0;
  const double count = weight_[static_cast<std::size_t>(fold)];
  for (std::size_t i = 0; i < row_.size(); ++i) {
    if (fold_[i] != fold || !judged_[i]) continue;
    const double e = error(static_cast<Eigen::Index>(i));
    sum += e;
    squares += e * e;
  }
  const double mean = lone_[static_cast<std::size_t>(fold)] ? sum / count : 0.0;
  return squares / count - mean * mean;
}

FoldSquares BranchFit::predict_folds(const Candidate* shape) const {
  const Design made = design(shape);
  const Eigen::MatrixXd columns = white(made.columns);
  const Eigen::VectorXd values = white(values_);
  const Normal all = normal_of(columns, values, std::vector<bool>(row_.size(), true));
  FoldSquares squares;
  for (std::size_t f = 0; f < weight_.size(); ++f) {
    const int fold = static_cast<int>(f);
    squares.error.push_back(0.0);
    squares.floor.push_back(0.0);
    if (weight_[f] <= 0.0) continue;
    std::vector<bool> own(row_.size());
    for (std::size_t i = 0; i < own.size(); ++i) own[i] = fold_[i] == fold;
    const Normal left = normal_of(columns, values, own);
    Eigen::MatrixXd normal = all.matrix - left.matrix;
    normal.diagonal() += ridge(made, all.matrix);
    const base::Ldlt solver(normal);
    const Eigen::VectorXd parameters = solver.solve(Eigen::VectorXd(all.side - left.side));
    squares.error.back() = mean_square(values_ - made.columns * parameters, fold);
    double leverage = 0.0;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      if (!own[i] || !judged_[i]) continue;
      const Eigen::VectorXd x = made.columns.row(static_cast<Eigen::Index>(i)).transpose();
      leverage += x.dot(solver.solve(x)) / weight_[f];
    }
    // A lone run's offset is taken off, whatever the others say of it.
    if (lone_[f]) leverage = std::min(leverage, 1.0);
    squares.floor.back() = noise_.sigma * noise_.sigma * (1.0 + leverage);
  }
  return squares;
}

std::vector<double> BranchFit::predict_by_direction() const {
  const Design made = design(nullptr);
  const Eigen::MatrixXd columns = white(made.columns);
  const Eigen::VectorXd values = white(values_);
  std::vector<double> errors;
  for (std::size_t f = 0; f < weight_.size(); ++f) {
    const int fold = static_cast<int>(f);
    errors.push_back(std::numeric_limits<double>::quiet_NaN());
    const auto first = std::find(fold_.begin(), fold_.end(), fold);
    if (weight_[f] <= 0.0 || first == fold_.end()) continue;
    const Sweep sweep = sweep_[static_cast<std::size_t>(first - fold_.begin())];
    std::vector<bool> alike(row_.size());
    for (std::size_t i = 0; i < alike.size(); ++i) alike[i] = fold_[i] != fold && sweep_[i] == sweep;
    if (std::none_of(alike.begin(), alike.end(), [](bool is) { return is; })) continue;
    Normal normal = normal_of(columns, values, alike);
    normal.matrix.diagonal() += ridge(made, normal.matrix);
    errors.back() = mean_square(values_ - made.columns * base::solve_ldlt(normal.matrix, normal.side), fold);
  }
  return errors;
}

WholeFit BranchFit::fit_all(const Candidate* shape) const {
  const Design made = design(shape);
  const Eigen::MatrixXd columns = white(made.columns);
  const Eigen::VectorXd values = white(values_);
  Normal normal = normal_of(columns, values, std::vector<bool>(row_.size(), true));
  normal.matrix.diagonal() += ridge(made, normal.matrix);
  const base::Ldlt solver(normal.matrix);
  const Eigen::VectorXd parameters = solver.solve(normal.side);
  const Eigen::Index terms = made.columns.cols() - made.base;
  WholeFit fit;
  fit.squares = (values - columns * parameters).squaredNorm();
  fit.columns = static_cast<double>(made.columns.cols()) + (shape != nullptr && shape->shifts ? 1.0 : 0.0);
  fit.parameters = parameters.tail(terms);
  const Eigen::MatrixXd units = Eigen::MatrixXd::Identity(made.columns.cols(), made.columns.cols()).rightCols(terms);
  fit.covariance = noise_.sigma * noise_.sigma * solver.solve(Eigen::MatrixXd(units)).bottomRows(terms);
  fit.term = made.columns.rightCols(terms) * fit.parameters;
  return fit;
}

}  // namespace soak::calib::gap::ramps
