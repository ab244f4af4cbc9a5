// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/slow_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "base/linear/dense_solve.h"
#include "base/statistics.h"
#include "calib/gap/noise/noise.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr Eigen::Index kWaves = 4;        ///< half waves over a run: the low frequencies
constexpr double kLeastDof = 6.0;         ///< of the scatter that low frequencies are compared with
constexpr double kLeastPlacements = 4.0;  ///< in a visit whose slope and bow are looked at

/// Squares of low frequencies and of the others, with their degrees of freedom.
struct Spectrum {
  double low = 0.0;
  double low_dof = 0.0;
  double high = 0.0;
  double high_dof = 0.0;

  [[nodiscard]] double p() const {
    if (low_dof <= 0.0 || high_dof < kLeastDof || high <= 0.0) return 1.0;
    return base::f_upper_tail(low / low_dof / (high / high_dof), low_dof, high_dof);
  }
  /// Squares that white scatter would not have, over the mean square of all.
  [[nodiscard]] double excess() const {
    if (high_dof <= 0.0 || low + high <= 0.0) return 0.0;
    return (low - low_dof * high / high_dof) * (low_dof + high_dof) / (low + high);
  }
};

/// Squares and degrees of freedom that a least-squares fit leaves.
std::pair<double, double> left_by(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  const base::TurnedByQr qr = base::turn_by_pivoted_qr(columns, y);
  // Runs and cells depend on each other: what lies beyond the rank is left, whatever the coefficients.
  const Eigen::Index dof = y.size() - qr.rank;
  return {qr.turned.tail(dof).squaredNorm(), static_cast<double>(dof)};
}

/// Half waves over each run against the other scatter of visits, with runs and cells taken off.
Spectrum over_runs(const std::vector<Stay>& visits) {
  std::map<int, std::pair<double, double>> span_s;
  std::map<int, Eigen::Index> cells;
  for (const Stay& visit : visits) {
    auto& [first, last] = span_s.try_emplace(visit.run, visit.t_s.value, visit.t_s.value).first->second;
    last = std::max(last, visit.t_s.value);
    cells.try_emplace(visit.cell, static_cast<Eigen::Index>(cells.size()));
  }
  const auto n = static_cast<Eigen::Index>(visits.size());
  const auto runs = static_cast<Eigen::Index>(span_s.size());
  const Eigen::Index fixed = runs + static_cast<Eigen::Index>(cells.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, fixed + kWaves * runs);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Stay& visit = visits[static_cast<std::size_t>(i)];
    const auto r = static_cast<Eigen::Index>(std::distance(span_s.begin(), span_s.find(visit.run)));
    const auto [first, last] = span_s.at(visit.run);
    const double phase = last > first ? (visit.t_s.value - first) / (last - first) : 0.0;
    y(i) = visit.value.value;
    columns(i, r) = 1.0;
    columns(i, runs + cells.at(visit.cell)) = 1.0;
    for (Eigen::Index k = 0; k < kWaves; ++k)
      columns(i, fixed + kWaves * r + k) = std::cos(std::numbers::pi * static_cast<double>(k + 1) * phase);
  }
  const auto [before, dof_before] = left_by(columns.leftCols(fixed), y);
  const auto [after, dof_after] = left_by(columns, y);
  return {before - after, dof_before - dof_after, after, dof_after};
}

/// Adds slope and bow of one visit, whose placements differ from their cells' means by `values`; `freedom`: share of a
/// deviation that is free beside those means.
void add_visit(const std::vector<double>& values, double freedom, Spectrum& spectrum) {
  const auto m = static_cast<Eigen::Index>(values.size());
  Eigen::MatrixXd shapes(m, 3);
  Eigen::VectorXd y(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const double x = 2.0 * static_cast<double>(k) / static_cast<double>(m - 1) - 1.0;
    shapes.row(k) << 1.0, x, x * x;
    y(k) = values[static_cast<std::size_t>(k)];
  }
  const double all = (y.array() - y.mean()).matrix().squaredNorm();
  const double high = left_by(shapes, y).first;
  spectrum.low += all - high;
  spectrum.low_dof += 2.0 * freedom;
  spectrum.high += high;
  spectrum.high_dof += static_cast<double>(m - 3) * freedom;
}

/// Slope and bow of each visit against the other scatter of its placements.
Spectrum within_visits(const std::vector<Stay>& placements) {
  std::map<int, Mean> cells;
  for (const Stay& placement : placements) cells[placement.cell].add(placement.value.value);
  Spectrum spectrum;
  for (std::size_t first = 0; first < placements.size();) {
    std::vector<double> values;
    double replicates = 0.0;
    std::size_t k = first;
    for (; k < placements.size() && same_visit(placements[k], placements[first]); ++k) {
      const Mean& cell = cells.at(placements[k].cell);
      if (cell.count < 2.0) continue;
      values.push_back(placements[k].value.value - cell.value);
      replicates += cell.count;
    }
    const auto count = static_cast<double>(values.size());
    if (count >= kLeastPlacements) add_visit(values, 1.0 - count / replicates, spectrum);
    first = k;
  }
  return spectrum;
}

/// Takes off what an effect reads more or less in each run than in all of them.
void take_off_strength(const Observations& observations, const Eigen::MatrixXd& columns, Eigen::VectorXd& remainder) {
  if (columns.cols() == 0) return;
  constexpr double kMost = 0.6;  ///< twice the 30 % that strengths may differ by
  for (int run = 0; run < observations.run_count(); ++run) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < remainder.size(); ++i) {
      if (observations.rows[static_cast<std::size_t>(i)].run == run && std::isfinite(remainder(i))) rows.push_back(i);
    }
    if (static_cast<Eigen::Index>(rows.size()) <= columns.cols()) continue;
    Eigen::MatrixXd x = columns(rows, Eigen::all);
    x.rowwise() -= x.colwise().mean().eval();
    const Eigen::VectorXd more =
        base::solve_pivoted_qr(x, Eigen::VectorXd(remainder(rows))).cwiseMax(-kMost).cwiseMin(kMost);
    remainder(rows) -= x * more;
  }
}

/// Chances and excess of one sensor.
struct Found {
  double over_runs = 1.0;
  double within_visits = 1.0;
  double excess = 0.0;
};

}  // namespace

Eigen::MatrixXd contributions(const std::vector<NamedEffect>& effects, Sensor sensor, Eigen::Index rows) {
  Eigen::MatrixXd columns(rows, 0);
  for (const NamedEffect& effect : effects) {
    if (std::find(effect.sensors.begin(), effect.sensors.end(), sensor) == effect.sensors.end()) continue;
    const std::size_t s = index_of(sensor);
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols(1) = effect.candidate.columns[s] * effect.parameters[s];
  }
  return columns;
}

Eigen::VectorXd unexplained(const CampaignModel& model, const std::vector<NamedEffect>& effects, Sensor sensor) {
  Eigen::VectorXd remainder = model.remainder(sensor);
  take_off_strength(model.regressor_inputs().observations, contributions(effects, sensor, remainder.size()), remainder);
  return remainder;
}

std::optional<SlowNoise> slow_noise(const CampaignModel& model, const std::vector<NamedEffect>& effects) {
  const Observations& observations = model.regressor_inputs().observations;
  std::array<Found, kSensorCount> found;
  std::vector<Sensor> sensors;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    const auto placements = placements_of(observations, unexplained(model, effects, sensor));
    const Spectrum slow = over_runs(visits_of(placements));
    const Spectrum fast = within_visits(placements);
    found[index_of(sensor)] = {slow.p(), fast.p(), slow.excess() + fast.excess()};
    sensors.push_back(sensor);
  }
  const auto sets = sensor_sets(sensors);
  constexpr double kDistances = 3.0;  // over runs, within visits, both
  SlowNoise best;
  for (const auto& set : sets) {
    std::vector<double> slow;
    std::vector<double> fast;
    double excess = 0.0;
    for (const Sensor sensor : set) {
      slow.push_back(found[index_of(sensor)].over_runs);
      fast.push_back(found[index_of(sensor)].within_visits);
      excess += found[index_of(sensor)].excess;
    }
    std::vector<double> both = slow;
    both.insert(both.end(), fast.begin(), fast.end());
    const double p = std::min({chance_together(slow), chance_together(fast), chance_together(both)});
    const double adjusted = std::min(1.0, p * kDistances * static_cast<double>(sets.size()));
    if (adjusted < best.p_adjusted) best = {.p_adjusted = adjusted, .excess = excess, .sensors = set};
  }
  if (best.p_adjusted > kSlowGate) return std::nullopt;
  return best;
}

}  // namespace soak::calib::gap
