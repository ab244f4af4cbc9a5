// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calib/gap/effects/effect.h"
#include "calib/gap/search/evaluation.h"

namespace soak::calib::gap {

/// The saturated base of all sensors with the terms taken in so far, fitted to the blocks of a campaign: what
/// candidates are tested against. One run may be left out of every fit, to be judged later. Observations and courses
/// must outlive it. A sensor without readings, or whose readings never scatter, has no residual.
class CampaignModel {
 public:
  CampaignModel(const Observations& observations, const Courses& courses, std::optional<int> without_run = {});

  [[nodiscard]] const Residuals& residuals() const { return residuals_; }
  /// Must not outlive the model.
  [[nodiscard]] Circumstances circumstances() const;
  /// Adds a term to the base of the given sensors and fits anew. Sensors with parameters of their own get the term's
  /// columns; of a shared term they get one column that carries `common`.
  void take_in(const Candidate& candidate, const std::vector<Sensor>& sensors, const Eigen::VectorXd& common);
  /// Readings less base and terms in SI, one per observation, those of the run left out too; NaN where the sensor has
  /// no reading.
  [[nodiscard]] Eigen::VectorXd remainder(Sensor sensor) const;
  /// Variance of what base and terms predict at each observation, less their mean over `run`, SI squared.
  [[nodiscard]] Eigen::VectorXd prediction_variance(Sensor sensor, int run) const;
  /// Offsets of the runs, the first being 0, SI. Only of a model that leaves no run out.
  [[nodiscard]] std::vector<double> run_offsets(Sensor sensor) const;

 private:
  void fit();
  void fit(Sensor sensor);
  [[nodiscard]] Eigen::VectorXd read_at(Sensor sensor, const std::vector<double>& temp_c) const;

  const Observations& observations_;
  const Courses& courses_;
  std::vector<bool> keep_;
  std::array<std::vector<double>, kSensorCount> temp_c_;
  std::array<Eigen::MatrixXd, kSensorCount> terms_;
  std::array<Eigen::MatrixXd, kSensorCount> columns_;
  std::array<Eigen::VectorXd, kSensorCount> prior_;
  std::array<Eigen::VectorXd, kSensorCount> slope_;
  Residuals residuals_;
};

}  // namespace soak::calib::gap
