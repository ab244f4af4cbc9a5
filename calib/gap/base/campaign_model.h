// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calib/gap/base/base_curve.h"
#include "calib/gap/base/whitened_base.h"
#include "calib/gap/effects/effect.h"
#include "calib/gap/noise/noise.h"

namespace soak::calib::gap {

/// What a term is tested against, sensor by sensor: the readings with base and accepted terms projected out, whitened.
class SensorResidual {
 public:
  /// `keep`: observations that take part. `whitening`: by `noise`, of these. `white`: by it, the columns of the base
  /// and of accepted terms; they may depend on each other. `prior`: per column the reciprocal standard deviation that
  /// its coefficient has about 0; 0 = free.
  SensorResidual(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
                 const std::vector<bool>& keep, Whitening whitening, const WhitenedBase& white,
                 const Eigen::VectorXd& prior);

  [[nodiscard]] Eigen::MatrixXd whiten(const Eigen::MatrixXd& columns) const { return whitening_.apply(columns); }
  /// Of the whitened rows the `count` from the `first` on, which is the first of a run.
  [[nodiscard]] Eigen::MatrixXd whiten_in_run(const Eigen::MatrixXd& columns, Eigen::Index first,
                                              Eigen::Index count) const {
    return whitening_.apply_in_run(columns, first, count);
  }
  /// Whitened columns freed of what the base takes up.
  [[nodiscard]] Eigen::MatrixXd project(Eigen::MatrixXd white) const;
  /// B with project(w) = w - B Bᵀw: orthonormal but for what the prior holds of it.
  [[nodiscard]] const Eigen::MatrixXd& basis() const { return basis_; }
  /// Share of the variance of a term's parameters that comes from the slow part of a wander, processes of two hours and
  /// more: 0 where the noise has none. About the means of runs.
  [[nodiscard]] double slow_share(const Eigen::MatrixXd& columns) const;
  /// Whitened readings less what the base and the terms make of them: the residual.
  [[nodiscard]] const Eigen::VectorXd& residual() const { return residual_; }
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return whitening_.rows(); }
  /// Coefficients of the base's columns, by generalised least squares.
  [[nodiscard]] const Eigen::VectorXd& coefficients() const { return coefficients_; }
  /// F with F Fᵀ the covariance of the coefficients.
  [[nodiscard]] const Eigen::MatrixXd& coefficient_factor() const { return coefficient_factor_; }

 private:
  Whitening whitening_;
  std::optional<Whitening> without_slow_;  ///< absent where the noise has no slow process
  std::vector<int> run_;                   ///< of each observation
  /// Orthonormal, of the whitened base and, below it, the prior's rows; a column's part of the former.
  Eigen::MatrixXd basis_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd coefficient_factor_;
  Eigen::VectorXd residual_;
};

/// Sensors of a campaign with base and accepted terms taken off; a sensor that was not recorded has none.
struct Residuals {
  std::array<std::optional<SensorResidual>, kSensorCount> sensor;
  std::array<NoiseComponents, kSensorCount> noise;
  std::vector<int> run_fold;    ///< of each observation
  std::vector<int> level_fold;  ///< likewise
  int runs = 0;
  int levels = 0;
};

/// Noise of a campaign that another model of it has told.
using KnownNoise = std::array<NoiseComponents, kSensorCount>;

/// The saturated base of all sensors with the terms taken in so far, fitted to the blocks of a campaign: what
/// candidates are tested against. One run may be left out of every fit, to be judged later. Observations and history
/// must outlive it. Without `noise` that is estimated from what the fit leaves. A sensor without readings, or whose
/// readings never scatter, has no residual.
class CampaignModel {
 public:
  CampaignModel(const Observations& observations, const TemperatureHistory& history,
                std::optional<int> without_run = {}, std::optional<KnownNoise> noise = {});

  [[nodiscard]] const Residuals& residuals() const { return residuals_; }
  /// The noise that it was given.
  [[nodiscard]] const std::optional<KnownNoise>& known_noise() const { return noise_; }
  /// Must not outlive the model.
  [[nodiscard]] RegressorInputs regressor_inputs() const;
  /// Adds a term to the base of the given sensors and fits them anew. Sensors with parameters of their own get the
  /// term's columns; of a shared term they get one column that carries `common`.
  void add_term(const Candidate& candidate, const std::vector<Sensor>& sensors, const Eigen::VectorXd& common);
  /// Readings less base and terms in SI, one per observation, those of the run left out too; NaN where the sensor has
  /// no reading.
  [[nodiscard]] Eigen::VectorXd remainder(Sensor sensor) const;
  /// Variance of what base and terms predict of `run`, less their mean over it: mean over its observations, SI squared.
  [[nodiscard]] double prediction_variance(Sensor sensor, int run) const;
  /// The sensor's residual as it would be under another noise, base and terms fitted anew with it. Only of a sensor
  /// that has one.
  [[nodiscard]] SensorResidual residual_under(Sensor sensor, const NoiseComponents& noise) const;
  /// Offsets of the runs, the first being 0, SI. Only of a model that leaves no run out.
  [[nodiscard]] std::vector<double> run_offsets(Sensor sensor) const;

 private:
  void fit(Sensor sensor);
  [[nodiscard]] Eigen::VectorXd remainder(Sensor sensor, const Eigen::VectorXd& coefficients) const;
  [[nodiscard]] NoiseComponents noise_of(Sensor sensor, const Eigen::VectorXd& coefficients) const;
  [[nodiscard]] Eigen::VectorXd read_at(Sensor sensor, const std::vector<double>& temp_c) const;

  const Observations& observations_;
  const TemperatureHistory& history_;
  std::optional<KnownNoise> noise_;
  std::vector<bool> keep_;
  std::array<std::vector<double>, kSensorCount> temp_c_;
  std::array<Eigen::MatrixXd, kSensorCount> terms_;
  std::array<Eigen::MatrixXd, kSensorCount> columns_;
  std::array<Eigen::VectorXd, kSensorCount> prior_;
  std::array<Eigen::VectorXd, kSensorCount> slope_;
  Residuals residuals_;
};

}  // namespace soak::calib::gap
