// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/branch_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap::reduced {
namespace {

constexpr double kLeastExcess =
    2.25;  ///< of the floor's square: noise that wanders slower than a branch is not known better
constexpr double kBetter = 0.81;    ///< of a fold's square: a tenth of its RMS
constexpr double kAtFloor = 1.5;    ///< of the floor's square: nothing more to gain in that fold
constexpr double kExplains = 0.95;  ///< share of the square that a mechanism has to close
constexpr double kRival = 6.0;
constexpr double kSecondColumn = 0.8;  ///< share of the square that a second parameter may leave at most

SensorFinding judge_base(const BranchJudge& judge, double sensors) {
  SensorFinding finding;
  finding.before = over_folds(judge.base().error, judge.weight());
  finding.floor = over_folds(judge.base().floor, judge.weight());
  double rows = 0.0;
  for (const double count : judge.weight()) rows += count;
  // Correlated blocks count as fewer: n(1 − ρ)/(1 + ρ).
  const double rho = judge.noise().correlation;
  const double dof = std::max(1.0, rows * (1.0 - rho) / (1.0 + rho));
  const double excess = std::max(kLeastExcess, base::chi_squared_quantile(1.0 - kGate / sensors, dof) / dof);
  finding.limit = (excess - 1.0) * finding.floor;
  finding.p_gap = std::min(1.0, sensors * base::chi_squared_upper_tail(dof * finding.before / finding.floor, dof));
  finding.gap = finding.before > excess * finding.floor;
  return finding;
}

/// Whether a curve of each direction predicts what it can, two folds at least, and all of them better than one curve.
bool repeats(const BranchJudge& judge) {
  const std::vector<double> errors = judge.left_out_by_direction();
  int better = 0;
  for (std::size_t f = 0; f < errors.size(); ++f) {
    if (std::isnan(errors[f])) continue;
    if (errors[f] > kBetter * judge.base().error[f]) return false;
    ++better;
  }
  return better >= 2;
}

double shape_count(const std::vector<Mechanism>& mechanisms) {
  double count = 0.0;
  for (const Mechanism& mechanism : mechanisms) count += static_cast<double>(mechanism.shapes.size());
  return count;
}

/// Errors of every shape of a mechanism in the sensors with a gap.
using Errors = std::array<std::vector<std::vector<double>>, kSensorCount>;

Errors errors_of(const Mechanism& mechanism, const Judges& judges, const BranchFinding& finding) {
  Errors errors;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!finding.sensor[s] || !finding.sensor[s]->gap) continue;
    for (const Shape& shape : mechanism.shapes) errors[s].push_back(judges[s]->left_out(&shape).error);
  }
  return errors;
}

/// log of the square over the floor: what shapes are compared by.
double remainder(const std::vector<double>& errors, const BranchJudge& judge, double floor) {
  return std::log(std::max(over_folds(errors, judge.weight()) / floor, std::numeric_limits<double>::min()));
}

/// The best shape for each sensor, or, where shared, for all of them.
std::array<std::size_t, kSensorCount> best_shapes(const Mechanism& mechanism, const Errors& errors,
                                                  const Judges& judges, const BranchFinding& finding) {
  std::array<std::size_t, kSensorCount> best{};
  std::vector<double> together(mechanism.shapes.size(), 0.0);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (errors[s].empty()) continue;
    std::vector<double> own;
    for (std::size_t k = 0; k < together.size(); ++k) {
      const double price = mechanism.shapes[k].columns.cols() > 1 ? -std::log(kSecondColumn) : 0.0;
      own.push_back(remainder(errors[s][k], *judges[s], finding.sensor[s]->floor) + price);
      together[k] += own.back();
    }
    best[s] = static_cast<std::size_t>(std::min_element(own.begin(), own.end()) - own.begin());
  }
  if (mechanism.shared) {
    best.fill(static_cast<std::size_t>(std::min_element(together.begin(), together.end()) - together.begin()));
  }
  return best;
}

bool supported(const std::vector<double>& errors, const BranchJudge& judge) {
  for (std::size_t f = 0; f < errors.size(); ++f) {
    if (judge.weight()[f] <= 0.0) continue;
    const double before = judge.base().error[f];
    const bool done = errors[f] < before && errors[f] < kAtFloor * judge.base().floor[f];
    if (!done && errors[f] >= kBetter * before) return false;
  }
  return true;
}

Outcome judge_shape(const Shape& shape, std::size_t number, std::vector<double> errors, const BranchJudge& judge,
                    const SensorFinding& finding, double tests) {
  Outcome outcome;
  outcome.shape = number;
  outcome.after = over_folds(errors, judge.weight());
  outcome.closed = 1.0 - std::max(0.0, outcome.after - finding.floor) / (finding.before - finding.floor);
  outcome.supported = supported(errors, judge);
  outcome.errors = std::move(errors);
  const WholeFit without = judge.whole(nullptr);
  const WholeFit with = judge.whole(&shape);
  const double added = with.columns - without.columns;
  const double dof = std::max(1.0, judge.rows() - with.columns);
  const double f = std::max(0.0, without.squares - with.squares) / added / (with.squares / dof);
  outcome.p_adjusted = std::min(1.0, tests * base::f_upper_tail(f, added, dof));
  outcome.delta_bic = judge.rows() * std::log(without.squares / with.squares) - added * std::log(judge.rows());
  outcome.explains = outcome.supported && outcome.closed >= kExplains && outcome.p_adjusted < kGate;
  return outcome;
}

/// Mean over sensors of log(square over floor), 0 at the floor; what no fold supports counts as the base.
double distance(const BranchFinding& finding, const std::vector<Sensor>& sensors, std::size_t mechanism) {
  double sum = 0.0;
  for (const Sensor sensor : sensors) {
    const SensorFinding& own = *finding.sensor[index_of(sensor)];
    const Outcome& outcome = own.outcomes[mechanism];
    const double square = outcome.supported ? outcome.after : own.before;
    sum += std::log(std::max(1.0, square / own.floor)) / static_cast<double>(sensors.size());
  }
  return sum;
}

void choose(BranchFinding& finding, std::size_t mechanisms) {
  double greatest = 0.0;
  for (std::size_t m = 0; m < mechanisms; ++m) {
    std::vector<Sensor> explained;
    std::vector<Sensor> rest;
    double gain = 0.0;
    for (const Sensor sensor : kSensors) {
      const auto& own = finding.sensor[index_of(sensor)];
      if (!own || !own->gap) continue;
      (own->outcomes[m].explains ? explained : rest).push_back(sensor);
      if (own->outcomes[m].explains) gain += std::log(own->before / std::max(own->floor, own->outcomes[m].after));
    }
    if (m == 0) finding.unexplained = rest;
    if (gain <= greatest) continue;
    greatest = gain;
    finding.winner = m;
    finding.explained = explained;
    finding.unexplained = rest;
  }
  if (!finding.winner) return;
  const double least = distance(finding, finding.explained, *finding.winner);
  for (std::size_t m = 0; m < mechanisms; ++m) {
    if (m != *finding.winner && distance(finding, finding.explained, m) - least < std::log(kRival)) {
      finding.rivals.push_back(m);
    }
  }
}

}  // namespace

double over_folds(const std::vector<double>& squares, const std::vector<double>& weight) {
  double sum = 0.0;
  double total = 0.0;
  for (std::size_t f = 0; f < squares.size(); ++f) {
    if (weight[f] <= 0.0) continue;
    sum += weight[f] * squares[f];
    total += weight[f];
  }
  return sum / total;
}

BranchFinding search_branches(const Judges& judges, const std::vector<Mechanism>& mechanisms) {
  BranchFinding finding;
  const auto sensors = static_cast<double>(
      std::count_if(judges.begin(), judges.end(), [](const auto& judge) { return judge.has_value(); }));
  const double tests = shape_count(mechanisms) * sensors;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!judges[s]) continue;
    finding.sensor[s] = judge_base(*judges[s], sensors);
    finding.sensor[s]->repeats = finding.sensor[s]->gap && repeats(*judges[s]);
  }
  for (const Mechanism& mechanism : mechanisms) {
    Errors errors = errors_of(mechanism, judges, finding);
    const auto best = best_shapes(mechanism, errors, judges, finding);
    for (std::size_t s = 0; s < kSensorCount; ++s) {
      if (errors[s].empty()) continue;
      const std::size_t k = best[s];
      finding.sensor[s]->outcomes.push_back(
          judge_shape(mechanism.shapes[k], k, std::move(errors[s][k]), *judges[s], *finding.sensor[s], tests));
    }
  }
  choose(finding, mechanisms.size());
  return finding;
}

}  // namespace soak::calib::gap::reduced
