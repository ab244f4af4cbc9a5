// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/telegraph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "calib/gap/noise/noise.h"

namespace soak::calib::gap {
namespace {

/// Mean times between jumps that are tried.
constexpr std::array<double, 5> kStays_s = {400.0, 1000.0, 2500.0, 6000.0, 15000.0};
constexpr int kSteps = 20;  ///< of expectation maximisation
/// Levels, scatter and time between jumps; beside them a mean of each run.
constexpr double kParameters = 3.0;

/// ln of a normal density, without −½ ln 2π.
double log_normal(double off, double variance) { return -0.5 * (off * off / variance + std::log(variance)); }

/// States of a bias at the beginning and at the end of a placement: index 2 * (low at the beginning) + (low at the
/// end).
constexpr std::array<double, 4> kMeanLevel = {1.0, 0.0, 0.0, -1.0};

/// Two levels about each run's mean, and how readings scatter about them.
struct TwoLevels {
  double amplitude = 0.0;
  double variance = 0.0;
  double stay_s = 0.0;
  std::vector<double> run_mean;

  /// Chance of another level after so long: ½ (1 − exp(−2 t/stay)).
  [[nodiscard]] double other_after(double time_s) const {
    return 0.5 - 0.5 * std::exp(-2.0 * std::max(0.0, time_s) / stay_s);
  }
  /// Density of a reading by the states at its ends, with the chance of the second; a jump within a placement leaves
  /// any mean between the levels.
  [[nodiscard]] std::array<double, 4> of_paths(const Reading& reading, double log_scale) const {
    const double other = other_after(reading.end_s - reading.begin_s);
    const double off = reading.value - run_mean[static_cast<std::size_t>(reading.run)];
    std::array<double, 4> density{};
    for (std::size_t path = 0; path < 4; ++path) {
      const bool jumps = path == 1 || path == 2;
      const double spread = variance + (jumps ? amplitude * amplitude / 3.0 : 0.0);
      density[path] =
          (jumps ? other : 1.0 - other) * std::exp(log_normal(off - amplitude * kMeanLevel[path], spread) - log_scale);
    }
    return density;
  }
};

/// Chances of the four paths of each placement, given all readings, and the logarithm of the readings' density.
struct Smoothed {
  std::vector<std::array<double, 4>> paths;
  double log_likelihood = 0.0;
};

/// Forward and backward recursion [Rabiner 1989], each step scaled to 1.
Smoothed smoothed(const std::vector<Reading>& readings, const TwoLevels& model) {
  const std::size_t n = readings.size();
  std::vector<std::array<double, 4>> density(n);
  std::vector<std::array<double, 2>> before(n);  // of the states at a placement's beginning, given what went before
  Smoothed result;
  result.paths.resize(n);
  std::array<double, 2> ended = {0.5, 0.5};
  const auto gap_s = [&](std::size_t i) { return readings[i].begin_s - readings[i - 1].end_s; };
  const auto same_run = [&](std::size_t i) { return i > 0 && i < n && readings[i].run == readings[i - 1].run; };
  for (std::size_t i = 0; i < n; ++i) {
    const double other = same_run(i) ? model.other_after(gap_s(i)) : 0.5;
    before[i] = {(1.0 - other) * ended[0] + other * ended[1], other * ended[0] + (1.0 - other) * ended[1]};
    const double log_scale = -0.5 * std::log(model.variance);
    density[i] = model.of_paths(readings[i], log_scale);
    ended = {before[i][0] * density[i][0] + before[i][1] * density[i][2],
             before[i][0] * density[i][1] + before[i][1] * density[i][3]};
    const double sum = std::max(ended[0] + ended[1], std::numeric_limits<double>::min());
    for (double& chance : ended) chance /= sum;
    for (double& path : density[i]) path /= sum;
    result.log_likelihood += std::log(sum) + log_scale;
  }
  std::array<double, 2> after = {1.0, 1.0};  // what later readings make of the states at a placement's end
  for (std::size_t i = n; i-- > 0;) {
    double sum = 0.0;
    for (std::size_t path = 0; path < 4; ++path) {
      result.paths[i][path] = before[i][path / 2] * density[i][path] * after[path % 2];
      sum += result.paths[i][path];
    }
    for (double& path : result.paths[i]) path /= std::max(sum, std::numeric_limits<double>::min());
    const std::array<double, 2> at_begin = {density[i][0] * after[0] + density[i][1] * after[1],
                                            density[i][2] * after[0] + density[i][3] * after[1]};
    const double other = same_run(i) ? model.other_after(gap_s(i)) : 0.5;
    after = {(1.0 - other) * at_begin[0] + other * at_begin[1], other * at_begin[0] + (1.0 - other) * at_begin[1]};
  }
  return result;
}

/// Means, levels and scatter that the smoothed states ask for: of the placements that end at the level where they
/// began.
void maximise(const std::vector<Reading>& readings, const Smoothed& states, TwoLevels& model) {
  std::vector<double> sum(model.run_mean.size(), 0.0);
  std::vector<double> weight(model.run_mean.size(), 0.0);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const auto run = static_cast<std::size_t>(readings[i].run);
    const double high = states.paths[i][0];
    const double low = states.paths[i][3];
    sum[run] += high * (readings[i].value - model.amplitude) + low * (readings[i].value + model.amplitude);
    weight[run] += high + low;
  }
  for (std::size_t run = 0; run < sum.size(); ++run) {
    if (weight[run] > 0.0) model.run_mean[run] = sum[run] / weight[run];
  }
  double along = 0.0;
  double squares = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double off = readings[i].value - model.run_mean[static_cast<std::size_t>(readings[i].run)];
    along += (states.paths[i][0] - states.paths[i][3]) * off;
    total += states.paths[i][0] + states.paths[i][3];
  }
  if (total <= 0.0) return;
  model.amplitude = along / total;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double off = readings[i].value - model.run_mean[static_cast<std::size_t>(readings[i].run)];
    squares += states.paths[i][0] * std::pow(off - model.amplitude, 2) +
               states.paths[i][3] * std::pow(off + model.amplitude, 2);
  }
  model.variance = std::max(squares / total, 1e-6 * model.amplitude * model.amplitude);
}

/// ln of the readings' density under the two levels that explain them best. `spread`: variance of all, to begin with.
double of_two_levels(const std::vector<Reading>& readings, std::size_t runs, double spread) {
  double best = -std::numeric_limits<double>::infinity();
  for (const double stay_s : kStays_s) {
    TwoLevels model{std::sqrt(0.7 * spread), 0.3 * spread, stay_s, std::vector<double>(runs, 0.0)};
    for (int step = 0; step < kSteps; ++step) {
      const Smoothed states = smoothed(readings, model);
      best = std::max(best, states.log_likelihood);
      maximise(readings, states, model);
    }
  }
  return best;
}

}  // namespace

PlacementMeans placement_means(const Observations& all, const Eigen::VectorXd& left, Sensor sensor) {
  PlacementMeans means;
  means.observations.runs = all.runs;
  for (Eigen::Index i = 0; i < left.size(); ++i) {
    if (!std::isfinite(left(i))) continue;
    const Observation& row = all.rows[static_cast<std::size_t>(i)];
    if (means.observations.rows.empty() || means.observations.rows.back().placement != row.placement) {
      means.observations.rows.push_back(row);
      means.readings.push_back({row.run, row.t_s, row.t_s, 0.0});
      means.observations.rows.back().sensor[index_of(sensor)].count = 0;
    }
    Observation& mean = means.observations.rows.back();
    Reading& reading = means.readings.back();
    const double count = static_cast<double>(++mean.sensor[index_of(sensor)].count);
    reading.value += (left(i) - reading.value) / count;
    reading.end_s = row.t_s;
    mean.t_s = 0.5 * (reading.begin_s + reading.end_s);
    means.blocks += 1.0;
  }
  means.blocks /= std::max(1.0, static_cast<double>(means.readings.size()));
  return means;
}

double chance_of_telegraph(const CampaignModel& model, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  if (!model.residuals().sensor[s] || model.residuals().noise[s].wander.empty()) return 1.0;
  const PlacementMeans means = placement_means(model.regressor_inputs().observations, model.remainder(sensor), sensor);
  const auto n = static_cast<Eigen::Index>(means.readings.size());
  Eigen::VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) values(i) = means.readings[static_cast<std::size_t>(i)].value;
  NoiseComponents noise = model.residuals().noise[s];
  noise.block /= std::sqrt(means.blocks);
  const Whitening whitening(means.observations, sensor, noise, std::vector<bool>(means.readings.size(), true));
  const double of_wander = -0.5 * (whitening.apply(values).squaredNorm() + whitening.log_determinant());
  const double spread = (values.array() - values.mean()).square().mean();
  if (!(spread > 0.0)) return 1.0;
  const auto runs = means.observations.runs.size();
  const double price = 0.5 * (kParameters + static_cast<double>(runs)) * std::log(static_cast<double>(n));
  return std::min(1.0, std::exp(-(of_two_levels(means.readings, runs, spread) - of_wander - price)));
}

}  // namespace soak::calib::gap
