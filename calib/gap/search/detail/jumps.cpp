// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/jumps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/statistics.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr double kInvisible = 1e-3;  ///< share of a step's squares below which the base takes it up

/// Rows at which a step may come: the first of each placement but that of the run.
std::vector<Eigen::Index> places_in(const Observations& observations, int run) {
  std::vector<Eigen::Index> places;
  for (std::size_t i = 1; i < observations.rows.size(); ++i) {
    const Observation& row = observations.rows[i];
    const Observation& before = observations.rows[i - 1];
    if (row.run == run && before.run == run && row.placement != before.placement) {
      places.push_back(static_cast<Eigen::Index>(i));
    }
  }
  return places;
}

/// What the step that stands out most in a run takes out of the squares, and its chance among all places.
struct Step {
  double gain = 0.0;
  double p = 1.0;
};

Step strongest_step(const Observations& observations, const SensorResidual& residual, double noise_dof, int run) {
  const std::vector<Eigen::Index> places = places_in(observations, run);
  if (places.empty()) return {};
  Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.rows.size()),
                                                static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    for (Eigen::Index i = places[k]; i < steps.rows() && observations.rows[static_cast<std::size_t>(i)].run == run;
         ++i) {
      steps(i, static_cast<Eigen::Index>(k)) = 1.0;
    }
  }
  Eigen::MatrixXd white = residual.whiten(steps);
  const Eigen::RowVectorXd before = white.colwise().squaredNorm();
  white = residual.project(std::move(white));
  Step best;
  for (Eigen::Index k = 0; k < white.cols(); ++k) {
    const double information = white.col(k).squaredNorm();
    if (information <= kInvisible * before(k)) continue;
    const double score = white.col(k).dot(residual.residual());
    best.gain = std::max(best.gain, score * score / information);
  }
  if (best.gain > 0.0) {
    best.p = std::min(1.0, static_cast<double>(places.size()) * base::f_upper_tail(best.gain, 1.0, noise_dof));
  }
  return best;
}

}  // namespace

std::optional<SlowNoise> jumps(const CampaignModel& model) {
  const Observations& observations = model.regressor_inputs().observations;
  std::array<std::vector<double>, kSensorCount> chances;
  std::array<double, kSensorCount> gain{};
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const auto& residual = model.residuals().sensor[s];
    if (!residual) continue;
    sensors.push_back(sensor);
    for (int run = 0; run < observations.run_count(); ++run) {
      const Step step = strongest_step(observations, *residual, model.residuals().noise[s].visit_dof, run);
      chances[s].push_back(step.p);
      gain[s] += step.gain;
    }
  }
  const auto sets = sensor_sets(sensors);
  SlowNoise best;
  for (const auto& set : sets) {
    std::vector<double> together;
    double excess = 0.0;
    for (const Sensor sensor : set) {
      together.insert(together.end(), chances[index_of(sensor)].begin(), chances[index_of(sensor)].end());
      excess += gain[index_of(sensor)];
    }
    const double adjusted = std::min(1.0, chance_together(together) * static_cast<double>(sets.size()));
    if (adjusted < best.p_adjusted) best = {adjusted, excess, set};
  }
  if (best.p_adjusted > kSlowGate) return std::nullopt;
  return best;
}

}  // namespace soak::calib::gap
