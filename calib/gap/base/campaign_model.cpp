// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/campaign_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/linear/products.h"

namespace soak::calib::gap {
namespace {

constexpr int kPasses = 3;
// Where the noise is known, the last pass takes the rows of the one before, which must have been whitened by that
// noise: the first pass has not.
static_assert(kPasses >= 3);
constexpr double kNoSlope = 1e12;  ///< prior that keeps a slope at that of the spline
constexpr double kSlow_s = 7200.0;

Eigen::MatrixXd beside(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
  Eigen::MatrixXd both(left.rows(), left.cols() + right.cols());
  both << left, right;
  return both;
}

/// Whether a sensor has any noise: one that is stuck at a number says nothing.
bool scatters(const NoiseComponents& noise) {
  constexpr double kLeast = 1e-12;  ///< far below the resolution of any output, deg/s or m/s²
  double most = std::hypot(noise.block, noise.placement, noise.visit);
  for (const GaussMarkov& process : noise.wander) most = std::max(most, process.sigma);
  return most > kLeast;
}

Eigen::VectorXd readings(const Observations& observations, Sensor sensor) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(observations.rows.size()));
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    y(i) = observations.rows[static_cast<std::size_t>(i)].sensor[index_of(sensor)].mean;
  }
  return y;
}

NoiseComponents without_slow_processes(NoiseComponents noise) {
  std::erase_if(noise.wander, [](const GaussMarkov& process) { return process.tau_s >= kSlow_s; });
  return noise;
}

}  // namespace

SensorResidual::SensorResidual(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
                               const std::vector<bool>& keep, Whitening whitening, const WhitenedBase& white,
                               const Eigen::VectorXd& prior)
    : whitening_(std::move(whitening)) {
  const NoiseComponents quick = without_slow_processes(noise);
  if (quick.wander.size() < noise.wander.size()) without_slow_.emplace(observations, sensor, quick, keep);
  for (const Observation& row : observations.rows) run_.push_back(row.run);
  anfis::LeastSquaresFit fit = white.solve(prior);
  coefficients_ = std::move(fit.coefficients);
  coefficient_factor_ = std::move(fit.covariance_factor);
  // X F has orthonormal columns, as F Fᵀ is the pseudo-inverse of XᵀX. Nothing else has a part in the prior's rows.
  basis_ = base::product(white.columns(), coefficient_factor_);
  residual_ = white.readings() - white.columns() * coefficients_;
}

Eigen::MatrixXd SensorResidual::project(Eigen::MatrixXd white) const {
  base::subtract_product(basis_, base::transposed_product(basis_, white), white);
  return white;
}

double SensorResidual::slow_share(const Eigen::MatrixXd& columns) const {
  if (!without_slow_) return 0.0;
  Eigen::MatrixXd centred = columns;
  for (Eigen::Index first = 0, i = 0; i < centred.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (at + 1 < run_.size() && run_[at + 1] == run_[at]) continue;
    auto run = centred.middleRows(first, i + 1 - first);
    run.rowwise() -= run.colwise().mean().eval();
    first = i + 1;
  }
  const double information = whitening_.apply(centred).squaredNorm();
  const double of_quick = without_slow_->apply(centred).squaredNorm();
  return of_quick > 0.0 ? std::max(0.0, 1.0 - information / of_quick) : 0.0;
}

CampaignModel::CampaignModel(const Observations& observations, const TemperatureHistory& history,
                             std::optional<int> without_run, std::optional<KnownNoise> noise)
    : observations_(observations), history_(history), noise_(std::move(noise)) {
  terms_.fill(Eigen::MatrixXd(static_cast<Eigen::Index>(observations.rows.size()), 0));
  for (const Observation& row : observations.rows) {
    keep_.push_back(row.run != without_run);
    residuals_.run_fold.push_back(row.run);
    residuals_.level_fold.push_back(row.level);
    for (std::size_t s = 0; s < kSensorCount; ++s) temp_c_[s].push_back(row.sensor_temp_c[s]);
  }
  residuals_.runs = observations.run_count();
  residuals_.levels = observations.level_count();
  for (const Sensor sensor : kSensors) {
    columns_[index_of(sensor)] = base_design(observations_, sensor, temp_c_[index_of(sensor)]).columns;
    fit(sensor);
  }
}

RegressorInputs CampaignModel::regressor_inputs() const {
  return {observations_, history_, slope_,
          [this](Sensor sensor, const std::vector<double>& temp_c) { return read_at(sensor, temp_c); }};
}

void CampaignModel::add_term(const Candidate& candidate, const std::vector<Sensor>& sensors,
                             const Eigen::VectorXd& common) {
  for (const Sensor sensor : sensors) {
    const std::size_t s = index_of(sensor);
    const Eigen::MatrixXd joined =
        candidate.shared ? Eigen::MatrixXd(candidate.columns[s] * common) : candidate.columns[s];
    terms_[s] = beside(terms_[s], joined);
    columns_[s] = beside(columns_[s], joined);
    fit(sensor);
  }
}

Eigen::VectorXd CampaignModel::remainder(Sensor sensor) const {
  return remainder(sensor, residuals_.sensor[index_of(sensor)]->coefficients());
}

Eigen::VectorXd CampaignModel::remainder(Sensor sensor, const Eigen::VectorXd& coefficients) const {
  const std::size_t s = index_of(sensor);
  Eigen::VectorXd residual = -(columns_[s] * coefficients);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    const SensorStatistics& statistics = observations_.rows[static_cast<std::size_t>(i)].sensor[s];
    residual(i) = statistics.count > 0 ? residual(i) + statistics.mean : std::numeric_limits<double>::quiet_NaN();
  }
  return residual;
}

SensorResidual CampaignModel::residual_under(Sensor sensor, const NoiseComponents& noise) const {
  const std::size_t s = index_of(sensor);
  Whitening whitening(observations_, sensor, noise, keep_);
  const WhitenedBase white(whitening, columns_[s], readings(observations_, sensor));
  return {observations_, sensor, noise, keep_, std::move(whitening), white, prior_[s]};
}

double CampaignModel::prediction_variance(Sensor sensor, int run) const {
  const std::size_t s = index_of(sensor);
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < observations_.rows.size(); ++i) {
    if (observations_.rows[i].run == run) rows.push_back(static_cast<Eigen::Index>(i));
  }
  if (rows.empty()) return 0.0;
  Eigen::MatrixXd columns = columns_[s](rows, Eigen::all);
  // Offsets are the runs' own: levels about their mean say what is predicted.
  columns.rightCols(terms_[s].cols() + observations_.run_count() - 1).leftCols(observations_.run_count() - 1).setZero();
  Eigen::MatrixXd spread = columns * residuals_.sensor[s]->coefficient_factor();
  spread.rowwise() -= spread.colwise().mean().eval();
  return spread.squaredNorm() / static_cast<double>(rows.size());
}

/// By normal equations with columns of unit length: many temperatures are tried. The slopes at the plateaus are the
/// spline's: where up and down lie kelvins apart, slopes of their own would fit the noise of each visit.
Eigen::VectorXd CampaignModel::read_at(Sensor sensor, const std::vector<double>& temp_c) const {
  constexpr double kRidge = 1e-12;
  const std::size_t s = index_of(sensor);
  const SensorResidual& present = *residuals_.sensor[s];
  const BaseDesign design = base_design(observations_, sensor, temp_c);
  const Eigen::Index levels = design.levels;
  const Eigen::Index after_slopes = design.columns.cols() - 2 * levels;
  Eigen::MatrixXd base(design.columns.rows(), levels + after_slopes);
  base << design.columns.leftCols(levels), design.columns.rightCols(after_slopes);
  const Eigen::MatrixXd white = present.whiten(beside(base, terms_[s]));
  const Eigen::VectorXd readings = present.residual() + present.whiten(columns_[s] * present.coefficients());
  Eigen::MatrixXd normal = base::lower_products(white);
  Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
  for (double& x : scale) x = x > 0.0 ? 1.0 / x : 0.0;
  normal = scale.asDiagonal() * normal * scale.asDiagonal();
  normal.diagonal().array() += kRidge;
  const Eigen::VectorXd wanted = scale.asDiagonal() * (white.transpose() * readings);
  const Eigen::VectorXd coefficients = scale.asDiagonal() * base::solve_ldlt(normal, wanted);
  return (base.leftCols(levels) - columns_[s].leftCols(levels)) * coefficients.head(levels) +
         (base.rightCols(after_slopes) - columns_[s].middleCols(2 * levels, after_slopes)) *
             coefficients.segment(levels, after_slopes);
}

std::vector<double> CampaignModel::run_offsets(Sensor sensor) const {
  const Eigen::VectorXd& coefficients = residuals_.sensor[index_of(sensor)]->coefficients();
  const Eigen::Index offsets = observations_.run_count() - 1;
  const Eigen::Index first = coefficients.size() - terms_[index_of(sensor)].cols() - offsets;
  std::vector<double> values = {0.0};
  for (Eigen::Index r = 0; r < offsets; ++r) values.push_back(coefficients(first + r));
  return values;
}

NoiseComponents CampaignModel::noise_of(Sensor sensor, const Eigen::VectorXd& coefficients) const {
  if (noise_) return (*noise_)[index_of(sensor)];
  Eigen::VectorXd left = remainder(sensor, coefficients);
  for (std::size_t i = 0; i < keep_.size(); ++i) {
    if (!keep_[i]) left(static_cast<Eigen::Index>(i)) = std::numeric_limits<double>::quiet_NaN();
  }
  return noise_components(observations_, left);
}

/// Noise is estimated first as if all rows were alike, then from what the fit under that noise leaves; so is how far
/// the curve's slope may be off. The passes before the last need no more than coefficients. Where the noise is known
/// the last pass has the rows of the one before.
void CampaignModel::fit(Sensor sensor) {
  const std::size_t s = index_of(sensor);
  const Eigen::Index levels = observations_.level_count();
  NoiseComponents noise;
  noise.block = 1.0;
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(columns_[s].cols());
  prior.segment(levels, levels).setConstant(kNoSlope);
  const Eigen::VectorXd y = readings(observations_, sensor);
  std::optional<Whitening> whitening;
  std::optional<WhitenedBase> white;
  const auto make_white = [&] {
    whitening.emplace(observations_, sensor, noise, keep_);
    white.emplace(*whitening, columns_[s], y);
  };
  for (int pass = 1; pass < kPasses; ++pass) {
    make_white();
    if (whitening->rows().empty()) return residuals_.sensor[s].reset();
    const Eigen::VectorXd coefficients = white->solve(prior).coefficients;
    const Eigen::VectorXd sigmas = slope_sigmas(observations_.level_c, coefficients.head(levels));
    prior.segment(levels, levels) = sigmas.cwiseMax(1.0 / kNoSlope).cwiseInverse();
    noise = noise_of(sensor, coefficients);
    if (!scatters(noise)) return residuals_.sensor[s].reset();
  }
  if (!noise_) make_white();
  residuals_.sensor[s].emplace(observations_, sensor, noise, keep_, *std::move(whitening), *white, prior);
  residuals_.noise[s] = noise;
  prior_[s] = prior;
  slope_[s] = base_slope(observations_, sensor, temp_c_[s], residuals_.sensor[s]->coefficients());
}

}  // namespace soak::calib::gap
