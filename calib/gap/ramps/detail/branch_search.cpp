// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/branch_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"
#include "calib/gap/effects/columns.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap::ramps {
namespace {

constexpr double kLeastExcess =
    2.25;  ///< of the floor's square: noise that wanders slower than a branch is not known better
constexpr double kBetter = 0.81;    ///< of a fold's square: a tenth of its RMS
constexpr double kAtFloor = 1.5;    ///< of the floor's square: nothing more to gain in that fold
constexpr double kExplains = 0.95;  ///< share of the square that an effect has to close
constexpr double kRival = 6.0;
constexpr double kSecondColumn = 0.8;  ///< share of the square that a second parameter may leave at most
constexpr double kDriftApart = 4.0;    ///< of two branches: the square that a drift leaves over that of the effect

/// Effects that follow time, temperature or a logged channel, in the order in which rivals are listed.
constexpr std::array<std::string_view, 6> kOnRamps = {"thermal_hysteresis", "temperature_rate",
                                                      "sensor_lag",         "warmup_transient",
                                                      "supply_sensitivity", "vibration_rectification"};

const Effect* drift() {
  static const Effect effect = {
      .name = "aging_drift",
      .physics = "the bias moves on with time, whatever the temperature does",
      .experiment = "the same cycle once more: a drift goes on, what follows the temperature comes back"};
  return &effect;
}

RampEffect drift_on_ramps(const Observations& observations) {
  constexpr double kHour_s = 3600.0;
  Eigen::VectorXd time_h(static_cast<Eigen::Index>(observations.rows.size()));
  for (Eigen::Index i = 0; i < time_h.size(); ++i) {
    time_h(i) = observations.rows[static_cast<std::size_t>(i)].t_s / kHour_s;
  }
  time_h.array() -= time_h.mean();
  return {drift(),
          {.candidates = {for_all("", {}, time_h)},
           .per = "/h",
           .meaning = [](const Candidate&, Sensor) { return Meaning{}; }},
          true};
}

SensorResult judge_base(const BranchFit& fit, double sensors) {
  SensorResult result;
  result.before = over_folds(fit.base().error, fit.weight());
  result.floor = over_folds(fit.base().floor, fit.weight());
  double rows = 0.0;
  for (const double count : fit.weight()) rows += count;
  // Correlated blocks count as fewer: n(1 − ρ)/(1 + ρ).
  const double rho = fit.noise().correlation;
  const double dof = std::max(1.0, rows * (1.0 - rho) / (1.0 + rho));
  const double excess = std::max(kLeastExcess, base::chi_squared_quantile(1.0 - kGate / sensors, dof) / dof);
  result.limit = (excess - 1.0) * result.floor;
  result.p_gap = std::min(1.0, sensors * base::chi_squared_upper_tail(dof * result.before / result.floor, dof));
  result.gap = result.before > excess * result.floor;
  return result;
}

/// Whether a curve of each direction predicts what it can, two folds at least, and all of them better than one curve.
bool repeats(const BranchFit& fit) {
  const std::vector<double> errors = fit.predict_by_direction();
  int better = 0;
  for (std::size_t f = 0; f < errors.size(); ++f) {
    if (std::isnan(errors[f])) continue;
    if (errors[f] > kBetter * fit.base().error[f]) return false;
    ++better;
  }
  return better >= 2;
}

bool has_second_parameter(const Candidate& candidate) {
  return std::ranges::any_of(candidate.columns, [](const auto& columns) { return columns.cols() > 1; });
}

double candidate_count(const std::vector<RampEffect>& effects) {
  double count = 0.0;
  for (const RampEffect& effect : effects) count += static_cast<double>(effect.candidates().size());
  return count;
}

/// Errors of every candidate of an effect in the sensors with a gap.
using Errors = std::array<std::vector<std::vector<double>>, kSensorCount>;

Errors errors_of(const RampEffect& effect, const BranchFits& fits, const BranchResult& result) {
  Errors errors;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!result.sensor[s] || !result.sensor[s]->gap) continue;
    for (const Candidate& shape : effect.candidates()) errors[s].push_back(fits[s]->predict_folds(&shape).error);
  }
  return errors;
}

/// log of the square over the floor: what candidates are compared by.
double remainder(const std::vector<double>& errors, const BranchFit& fit, double floor) {
  return std::log(std::max(over_folds(errors, fit.weight()) / floor, std::numeric_limits<double>::min()));
}

/// The best candidate for each sensor, or, where shared, for all of them.
std::array<std::size_t, kSensorCount> best_candidates(const RampEffect& effect, const Errors& errors,
                                                      const BranchFits& fits, const BranchResult& result) {
  std::array<std::size_t, kSensorCount> best{};
  std::vector<double> together(effect.candidates().size(), 0.0);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (errors[s].empty()) continue;
    std::vector<double> own;
    for (std::size_t k = 0; k < together.size(); ++k) {
      const double price = has_second_parameter(effect.candidates()[k]) ? -std::log(kSecondColumn) : 0.0;
      own.push_back(remainder(errors[s][k], *fits[s], result.sensor[s]->floor) + price);
      together[k] += own.back();
    }
    best[s] = static_cast<std::size_t>(std::min_element(own.begin(), own.end()) - own.begin());
  }
  if (effect.candidates().front().shared) {
    best.fill(static_cast<std::size_t>(std::min_element(together.begin(), together.end()) - together.begin()));
  }
  return best;
}

bool supported(const std::vector<double>& errors, const BranchFit& fit) {
  for (std::size_t f = 0; f < errors.size(); ++f) {
    if (fit.weight()[f] <= 0.0) continue;
    const double before = fit.base().error[f];
    const bool done = errors[f] < before && errors[f] < kAtFloor * fit.base().floor[f];
    if (!done && errors[f] >= kBetter * before) return false;
  }
  return true;
}

Outcome judge_shape(const Candidate& shape, std::size_t number, std::vector<double> errors, const BranchFit& fit,
                    const SensorResult& result, double tests) {
  Outcome outcome;
  outcome.candidate = number;
  outcome.after = over_folds(errors, fit.weight());
  outcome.closed = 1.0 - std::max(0.0, outcome.after - result.floor) / (result.before - result.floor);
  outcome.supported = supported(errors, fit);
  outcome.errors = std::move(errors);
  const WholeFit without = fit.fit_all(nullptr);
  const WholeFit with = fit.fit_all(&shape);
  const double added = with.columns - without.columns;
  const double dof = std::max(1.0, fit.rows() - with.columns);
  const double f = std::max(0.0, without.squares - with.squares) / added / (with.squares / dof);
  outcome.p_adjusted = std::min(1.0, tests * base::f_upper_tail(f, added, dof));
  outcome.delta_bic = fit.rows() * std::log(without.squares / with.squares) - added * std::log(fit.rows());
  outcome.explains = outcome.supported && outcome.closed >= kExplains && outcome.p_adjusted < kGate;
  return outcome;
}

/// Of two branches: halves of one difference that also grows with time support no effect.
void withhold_where_a_drift_does(const std::vector<RampEffect>& effects, SensorResult& result) {
  double drift = std::numeric_limits<double>::infinity();
  for (std::size_t m = 0; m < result.outcomes.size(); ++m) {
    if (effects[m].nuisance) drift = std::min(drift, result.outcomes[m].after);
  }
  for (std::size_t m = 0; m < result.outcomes.size(); ++m) {
    Outcome& outcome = result.outcomes[m];
    if (!effects[m].nuisance && kDriftApart * outcome.after > drift) outcome.explains = false;
  }
}

/// Mean over sensors of log(square over floor), 0 at the floor; what no fold supports counts as the base.
double distance(const BranchResult& result, const std::vector<Sensor>& sensors, std::size_t effect) {
  double sum = 0.0;
  for (const Sensor sensor : sensors) {
    const SensorResult& own = *result.sensor[index_of(sensor)];
    const Outcome& outcome = own.outcomes[effect];
    const double square = outcome.supported ? outcome.after : own.before;
    sum += std::log(std::max(1.0, square / own.floor)) / static_cast<double>(sensors.size());
  }
  return sum;
}

void choose_winner(BranchResult& result, std::size_t effects) {
  double greatest = 0.0;
  for (std::size_t m = 0; m < effects; ++m) {
    std::vector<Sensor> explained;
    std::vector<Sensor> rest;
    double gain = 0.0;
    for (const Sensor sensor : kSensors) {
      const auto& own = result.sensor[index_of(sensor)];
      if (!own || !own->gap) continue;
      (own->outcomes[m].explains ? explained : rest).push_back(sensor);
      if (own->outcomes[m].explains) gain += std::log(own->before / std::max(own->floor, own->outcomes[m].after));
    }
    if (m == 0) result.unexplained = rest;
    if (gain <= greatest) continue;
    greatest = gain;
    result.winner = m;
    result.explained = explained;
    result.unexplained = rest;
  }
  if (!result.winner) return;
  const double least = distance(result, result.explained, *result.winner);
  for (std::size_t m = 0; m < effects; ++m) {
    if (m != *result.winner && distance(result, result.explained, m) - least < std::log(kRival)) {
      result.rivals.push_back(m);
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

std::vector<RampEffect> effects_on_ramps(const RampRecording& recording, const TemperatureHistory& history,
                                         bool halves) {
  std::vector<RampEffect> list;
  for (const std::string_view name : kOnRamps) {
    const auto effect =
        std::find_if(library().begin(), library().end(), [&](const Effect& e) { return e.name == name; });
    list.push_back({&*effect, effect->on_ramps(recording.observations, history)});
  }
  list.push_back(drift_on_ramps(recording.observations));
  // The one difference of two branches is a smooth curve of temperature, which two parameters and a shape nearly always
  // follow: that one half of it predicts the other says little then.
  for (RampEffect& effect : list) {
    if (halves) std::erase_if(effect.shown.candidates, has_second_parameter);
  }
  std::erase_if(list, [](const RampEffect& effect) { return effect.candidates().empty(); });
  return list;
}

BranchResult search_branches(const BranchFits& fits, const std::vector<RampEffect>& effects, bool halves) {
  BranchResult result;
  const auto sensors =
      static_cast<double>(std::count_if(fits.begin(), fits.end(), [](const auto& fit) { return fit.has_value(); }));
  const double tests = candidate_count(effects) * sensors;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!fits[s]) continue;
    result.sensor[s] = judge_base(*fits[s], sensors);
    result.sensor[s]->repeats = result.sensor[s]->gap && repeats(*fits[s]);
  }
  for (const RampEffect& effect : effects) {
    Errors errors = errors_of(effect, fits, result);
    const auto best = best_candidates(effect, errors, fits, result);
    for (std::size_t s = 0; s < kSensorCount; ++s) {
      if (errors[s].empty()) continue;
      const std::size_t k = best[s];
      result.sensor[s]->outcomes.push_back(
          judge_shape(effect.candidates()[k], k, std::move(errors[s][k]), *fits[s], *result.sensor[s], tests));
    }
  }
  for (auto& sensor : result.sensor) {
    if (halves && sensor) withhold_where_a_drift_does(effects, *sensor);
  }
  choose_winner(result, effects.size());
  return result;
}

}  // namespace soak::calib::gap::ramps
