// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/branch_judge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "calib/gap/ramps/detail/ramp_spline.h"

namespace soak::calib::gap::reduced {
namespace {

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

std::optional<BranchJudge> BranchJudge::of(const RampRecording& recording, const FoldPlan& plan, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  const auto& rows = recording.observations.rows;
  BranchJudge judge;
  std::vector<int> branch;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].sensor[s].count == 0 || !std::isfinite(rows[i].sensor[s].mean)) continue;
    judge.row_.push_back(i);
    judge.run_.push_back(rows[i].run);
    judge.fold_.push_back(plan.fold[i]);
    judge.sweep_.push_back(rows[i].sweep);
    branch.push_back(recording.branch[i]);
    judge.piece_.push_back(recording.branch[i] * (plan.count + 1) + plan.fold[i]);
  }
  const auto count = static_cast<Eigen::Index>(judge.row_.size());
  if (count == 0) return std::nullopt;
  judge.values_.resize(count);
  judge.temp_c_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Observation& row = rows[judge.row_[static_cast<std::size_t>(i)]];
    judge.values_(i) = row.sensor[s].mean;
    judge.temp_c_(i) = row.sensor_temp_c[s];
  }
  if (judge.values_.maxCoeff() == judge.values_.minCoeff()) return std::nullopt;
  judge.values_.array() -= judge.values_.mean();
  judge.low_c_ = judge.temp_c_.minCoeff() - 1.0;
  judge.high_c_ = judge.temp_c_.maxCoeff() + 1.0;
  judge.noise_ = branch_noise(judge.values_, judge.temp_c_, branch);
  if (!(judge.noise_.sigma > 0.0)) return std::nullopt;
  judge.choose_judged_rows(plan.count);
  const auto enough = std::count_if(judge.weight_.begin(), judge.weight_.end(), [](double w) { return w > 0.0; });
  if (enough < 2) return std::nullopt;
  judge.base_ = judge.left_out(nullptr);
  return judge;
}

void BranchJudge::choose_judged_rows(int folds) {
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

BranchJudge::Design BranchJudge::design(const Shape* shape) const {
  Eigen::VectorXd temp_c = temp_c_;
  const auto row = [&](Eigen::Index i) { return static_cast<Eigen::Index>(row_[static_cast<std::size_t>(i)]); };
  if (shape != nullptr && shape->shifts) {
    for (Eigen::Index i = 0; i < temp_c.size(); ++i) temp_c(i) += shape->columns(row(i), 0);
  }
  const Eigen::MatrixXd curve = ramp_spline(temp_c, low_c_, high_c_, noise_.intervals);
  const int runs = *std::max_element(run_.begin(), run_.end());
  const Eigen::Index terms = shape == nullptr || shape->shifts ? 0 : shape->columns.cols();
  Design made;
  made.base = curve.cols() + runs;
  made.columns = Eigen::MatrixXd::Zero(temp_c.size(), made.base + terms);
  made.columns.leftCols(curve.cols()) = curve;
  for (Eigen::Index i = 0; i < temp_c.size(); ++i) {
    const int run = run_[static_cast<std::size_t>(i)];
    if (run > 0) made.columns(i, curve.cols() + run - 1) = 1.0;
    if (terms > 0) made.columns.row(i).tail(terms) = shape->columns.row(row(i));
  }
  return made;
}

// Neighbours of one piece: w_i = (x_i − ρ x_{i−1})/√(1 − ρ²), which leaves the variance of an AR(1) process as it is.
Eigen::MatrixXd BranchJudge::white(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result = columns;
  const double rho = noise_.correlation;
  for (Eigen::Index i = 1; i < columns.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (piece_[k] != piece_[k - 1]) continue;
    result.row(i) = (columns.row(i) - rho * columns.row(i - 1)) / std::sqrt(1.0 - rho * rho);
  }
  return result;
}

Eigen::VectorXd BranchJudge::ridge(const Design& design, const Eigen::MatrixXd& normal) const {
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

double BranchJudge::mean_square(const Eigen::VectorXd& error, int fold) const {
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

FoldSquares BranchJudge::left_out(const Shape* shape) const {
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
    const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
    const Eigen::VectorXd parameters = solver.solve(all.side - left.side);
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

std::vector<double> BranchJudge::left_out_by_direction() const {
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
    errors.back() = mean_square(values_ - made.columns * normal.matrix.ldlt().solve(normal.side), fold);
  }
  return errors;
}

WholeFit BranchJudge::whole(const Shape* shape) const {
  const Design made = design(shape);
  const Eigen::MatrixXd columns = white(made.columns);
  const Eigen::VectorXd values = white(values_);
  Normal normal = normal_of(columns, values, std::vector<bool>(row_.size(), true));
  normal.matrix.diagonal() += ridge(made, normal.matrix);
  const Eigen::VectorXd parameters = normal.matrix.ldlt().solve(normal.side);
  const Eigen::Index terms = made.columns.cols() - made.base;
  WholeFit fit;
  fit.squares = (values - columns * parameters).squaredNorm();
  fit.columns = static_cast<double>(made.columns.cols()) + (shape != nullptr && shape->shifts ? 1.0 : 0.0);
  fit.parameters = parameters.tail(terms);
  fit.term = made.columns.rightCols(terms) * fit.parameters;
  return fit;
}

}  // namespace soak::calib::gap::reduced
