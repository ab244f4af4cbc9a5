// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/jumps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr double kInvisible = 1e-3;      ///< share of a step's squares below which the base takes it up
constexpr std::size_t kMostPlaces = 80;  ///< of a step in one run; of more, every second, third...
constexpr double kWays = 2.0;            ///< in which chances are put together

/// Rows at which a step may come: the first of placements other than the run's first.
std::vector<Eigen::Index> places_in(const Observations& observations, int run) {
  std::vector<Eigen::Index> places;
  for (std::size_t i = 1; i < observations.rows.size(); ++i) {
    const Observation& row = observations.rows[i];
    const Observation& before = observations.rows[i - 1];
    if (row.run == run && before.run == run && row.placement != before.placement) {
      places.push_back(static_cast<Eigen::Index>(i));
    }
  }
  const std::size_t stride = places.size() / kMostPlaces + 1;
  std::vector<Eigen::Index> thinned;
  for (std::size_t k = stride / 2; k < places.size(); k += stride) thinned.push_back(places[k]);
  return thinned;
}

/// A step to 1 at each place until the run's end, a column each.
Eigen::MatrixXd steps_at(const Observations& observations, const std::vector<Eigen::Index>& places, int run) {
  Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.rows.size()),
                                                static_cast<Eigen::Index>(places.size()));
  for (std::size_t k = 0; k < places.size(); ++k) {
    for (Eigen::Index i = places[k]; i < steps.rows(); ++i) {
      if (observations.rows[static_cast<std::size_t>(i)].run != run) break;
      steps(i, static_cast<Eigen::Index>(k)) = 1.0;
    }
  }
  return steps;
}

/// Columns of the effects in one run only, zero in the others.
Eigen::MatrixXd in_run(const Observations& observations, Eigen::MatrixXd columns, int run) {
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    if (observations.rows[static_cast<std::size_t>(i)].run != run) columns.row(i).setZero();
  }
  return columns;
}

/// What the step that stands out most in a run takes out of the squares, more than the largest of as many chances
/// would, and its chance among all places.
struct Step {
  double excess = 0.0;
  double p = 1.0;
};

Step strongest_step(const Observations& observations, const SensorResidual& residual, const Eigen::MatrixXd& effects,
                    double noise_dof, int run) {
  const std::vector<Eigen::Index> places = places_in(observations, run);
  if (places.empty()) return {};
  Eigen::MatrixXd white = residual.whiten(steps_at(observations, places, run));
  const Eigen::RowVectorXd before = white.colwise().squaredNorm();
  white = residual.project(std::move(white));
  Eigen::VectorXd left = residual.residual();
  if (effects.cols() > 0) {
    const Eigen::MatrixXd strength = residual.project(residual.whiten(in_run(observations, effects, run)));
    for (Eigen::Index k = 0; k < white.cols(); ++k) {
      white.col(k) -= strength * base::solve_pivoted_qr(strength, Eigen::VectorXd(white.col(k)));
    }
    left -= strength * base::solve_pivoted_qr(strength, left);
  }
  double gain = 0.0;
  for (Eigen::Index k = 0; k < white.cols(); ++k) {
    const double information = white.col(k).squaredNorm();
    if (information <= kInvisible * before(k)) continue;
    const double score = white.col(k).dot(left);
    gain = std::max(gain, score * score / information);
  }
  const auto count = static_cast<double>(places.size());
  if (gain <= 0.0 || noise_dof <= 0.0) return {};
  return {std::max(0.0, gain - 2.0 * std::log(count)), std::min(1.0, count * base::f_upper_tail(gain, 1.0, noise_dof))};
}

}  // namespace

std::optional<SlowNoise> jumps(const CampaignModel& model, const std::vector<NamedEffect>& effects) {
  const Observations& observations = model.regressor_inputs().observations;
  std::array<std::vector<double>, kSensorCount> chances;
  std::array<double, kSensorCount> excess{};
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const auto& residual = model.residuals().sensor[s];
    if (!residual) continue;
    sensors.push_back(sensor);
    const Eigen::MatrixXd columns = contributions(effects, sensor, static_cast<Eigen::Index>(observations.rows.size()));
    for (int run = 0; run < observations.run_count(); ++run) {
      const Step step = strongest_step(observations, *residual, columns, model.residuals().noise[s].visit_dof, run);
      chances[s].push_back(step.p);
      excess[s] += step.excess;
    }
  }
  const auto sets = sensor_sets(sensors);
  SlowNoise best;
  for (const auto& set : sets) {
    std::vector<double> all;
    double squares = 0.0;
    for (const Sensor sensor : set) {
      all.insert(all.end(), chances[index_of(sensor)].begin(), chances[index_of(sensor)].end());
      squares += excess[index_of(sensor)];
    }
    const double least = *std::min_element(all.begin(), all.end()) * static_cast<double>(all.size());
    const double p = kWays * std::min(chance_together(all), least);
    const double adjusted = std::min(1.0, p * static_cast<double>(sets.size()));
    if (adjusted < best.p_adjusted) best = {adjusted, squares, set};
  }
  if (best.p_adjusted > kSlowGate) return std::nullopt;
  return best;
}

}  // namespace soak::calib::gap
