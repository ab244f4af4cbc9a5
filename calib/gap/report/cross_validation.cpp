// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/cross_validation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/statistics.h"

namespace soak::calib::gap {
namespace {

constexpr double kProbability = 0.95;

/// Expected mean square of noise about its own mean over a run.
double expected_noise(const Observations& observations, const NoiseComponents& noise, int run) {
  std::map<int, double> placement;
  std::map<int, double> visit;
  double rows = 0.0;
  for (const Observation& row : observations.rows) {
    if (row.run != run) continue;
    rows += 1.0;
    placement[row.placement] += 1.0;
    visit[row.visit] += 1.0;
  }
  // Variance of the mean: each group's variance counts with the square of its share of the rows.
  double of_mean = noise.block * noise.block / rows;
  for (const auto& [id, count] : placement) of_mean += std::pow(noise.placement * count / rows, 2);
  for (const auto& [id, count] : visit) of_mean += std::pow(noise.visit * count / rows, 2);
  return noise.block * noise.block + noise.placement * noise.placement + noise.visit * noise.visit - of_mean +
         variance_about_mean(observations, noise.wander, run);
}

/// What the unseen runs say of one sensor.
struct JudgedRuns {
  std::vector<double> before;
  std::vector<double> after;
  std::vector<double> floor;
};

using SensorJudgements = std::array<JudgedRuns, kSensorCount>;

double root_mean(const std::vector<double>& squares) {
  double sum = 0.0;
  for (const double value : squares) sum += value / static_cast<double>(squares.size());
  return std::sqrt(sum);
}

struct Spread {
  double mean = 0.0;
  double standard_error = 0.0;
};

Spread spread_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  Spread spread;
  for (const double value : values) spread.mean += value / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  spread.standard_error = n > 1.0 ? std::sqrt(squares / (n - 1.0) / n) : 0.0;
  return spread;
}

/// Whether effects that act on a sensor could close its gap in a run that they have not seen: one that is drawn anew
/// with every mounting cannot.
bool can_close(const std::vector<NamedEffect>& effects, Sensor sensor) {
  return std::any_of(effects.begin(), effects.end(), [&](const NamedEffect& named) {
    return named.effect->candidates && named.candidate.folds == Folds::runs &&
           std::find(named.sensors.begin(), named.sensors.end(), sensor) != named.sensors.end();
  });
}

SensorGap summarise(const JudgedRuns& judged, bool closing) {
  SensorGap gap{.before_rms = root_mean(judged.before),
                .after_rms = root_mean(judged.after),
                .floor_rms = root_mean(judged.floor),
                .closed_fraction = {},
                .closed_ci95 = {}};
  std::vector<double> open;
  std::vector<double> closed;
  for (std::size_t r = 0; r < judged.before.size(); ++r) {
    const double before = std::sqrt(judged.before[r]);
    open.push_back(before - std::sqrt(judged.floor[r]));
    closed.push_back(before - std::sqrt(judged.after[r]));
  }
  const Spread size = spread_of(open);
  if (!closing || open.size() < 2 || size.mean <= 2.0 * size.standard_error || size.mean <= 0.0) return gap;
  // A ratio of means: runs with a small gap of their own would make a mean of ratios wild.
  const double fraction = spread_of(closed).mean / size.mean;
  std::vector<double> off;
  for (std::size_t r = 0; r < open.size(); ++r) off.push_back(closed[r] - fraction * open[r]);
  const double half = base::student_t_two_sided(kProbability, static_cast<double>(open.size()) - 1.0) *
                      spread_of(off).standard_error / size.mean;
  gap.closed_fraction = fraction;
  gap.closed_ci95 = {fraction - half, fraction + half};
  return gap;
}

void judge_run(const Observations& observations, const CampaignModel& plain, const CampaignModel& with, int run,
               SensorJudgements& judged) {
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (!plain.residuals().sensor[s] || !with.residuals().sensor[s]) continue;
    const auto before = mean_square(observations, plain.remainder(sensor), run);
    const auto after = mean_square(observations, with.remainder(sensor), run);
    if (!before || !after) continue;
    const NoiseComponents& noise = with.residuals().noise[s];
    judged[s].before.push_back(*before);
    judged[s].after.push_back(*after);
    judged[s].floor.push_back(expected_noise(observations, noise, run) + with.prediction_variance(sensor, run));
  }
}

void judge_unseen_run(const Observations& observations, const TemperatureHistory& history,
                      const std::vector<NamedEffect>& effects, int run, const std::optional<KnownNoise>& noise,
                      SensorJudgements& judged) {
  const CampaignModel plain(observations, history, run, noise);
  CampaignModel with = plain;
  for (const NamedEffect& named : effects) {
    if (!named.effect->candidates) continue;  // nothing that a mean shows
    const auto again = best_shape(with, *named.effect);
    if (!again) continue;
    with.add_term(again->candidate, named.sensors, again->parameters[index_of(again->sensors.front())]);
  }
  judge_run(observations, plain, with, run, judged);
}

SensorGaps summarised(const SensorJudgements& judged, const std::vector<NamedEffect>& effects) {
  SensorGaps gaps;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!judged[s].before.empty()) gaps[s] = summarise(judged[s], can_close(effects, kSensors[s]));
  }
  return gaps;
}

}  // namespace

std::optional<double> mean_square(const Observations& observations, const Eigen::VectorXd& remainder, int run) {
  double count = 0.0;
  double mean = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = remainder(static_cast<Eigen::Index>(i));
    if (observations.rows[i].run != run || !std::isfinite(value)) continue;
    count += 1.0;
    const double off = value - mean;
    mean += off / count;
    squares += off * (value - mean);
  }
  if (count < 2.0) return std::nullopt;
  return squares / count;
}

SensorGaps cross_validated_gap(const Observations& observations, const TemperatureHistory& history,
                               const std::vector<NamedEffect>& effects, const std::optional<KnownNoise>& noise) {
  SensorJudgements judged;
  for (int run = 0; run < observations.run_count(); ++run)
    judge_unseen_run(observations, history, effects, run, noise, judged);
  return summarised(judged, effects);
}

SensorGaps gap_of_unseen_run(const Observations& observations, const TemperatureHistory& history,
                             const std::vector<NamedEffect>& effects, int run, const std::optional<KnownNoise>& noise) {
  SensorJudgements judged;
  judge_unseen_run(observations, history, effects, run, noise, judged);
  auto gaps = summarised(judged, effects);
  for (auto& gap : gaps) {
    if (!gap) continue;
    // One run has no scatter: its fraction has no interval.
    const double open = gap->before_rms - gap->floor_rms;
    if (open > 0.0 && can_close(effects, kSensors[static_cast<std::size_t>(&gap - gaps.data())]))
      gap->closed_fraction = (gap->before_rms - gap->after_rms) / open;
  }
  return gaps;
}

}  // namespace soak::calib::gap
