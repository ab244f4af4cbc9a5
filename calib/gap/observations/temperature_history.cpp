// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/observations/temperature_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace soak::calib::gap {
namespace {

constexpr double kLoggingHole_s = 300.0;
constexpr double kHoles = 0.05;          ///< share of the time that may be missing: a visit or two
constexpr double kHalfWindow_s = 120.0;  ///< of the slope of the temperature
constexpr double kHalfBlock_s = 30.0;
constexpr double kTurn_c = 0.5;  ///< noise and drift of a plateau are no turn
constexpr double kStartRoom_c = 23.0;
constexpr std::size_t kLeastLevels = 5;

/// Linear between the samples, constant beyond the ends.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  if (at <= x.front()) return y.front();
  if (at >= x.back()) return y.back();
  const auto upper = std::upper_bound(x.begin(), x.end(), at);
  const auto k = static_cast<std::size_t>(upper - x.begin());
  const double share = (at - x[k - 1]) / (x[k] - x[k - 1]);
  return y[k - 1] + share * (y[k] - y[k - 1]);
}

/// Mean of the values within `half_s` of `at`; NaN where there is none.
double mean_about(const RunLog& log, const std::vector<double>& values, double at, double half_s) {
  const auto first = std::lower_bound(log.t_s.begin(), log.t_s.end(), at - half_s);
  const auto last = std::upper_bound(log.t_s.begin(), log.t_s.end(), at + half_s);
  double sum = 0.0;
  double count = 0.0;
  for (auto t = first; t != last; ++t) {
    const double value = values[static_cast<std::size_t>(t - log.t_s.begin())];
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

/// Least-squares slope of the temperature about `at`, K/s; 0 where fewer than three values are near.
double slope_about(const std::vector<double>& t_s, const std::vector<double>& temp_c, double at) {
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), at - kHalfWindow_s) - t_s.begin();
  const auto last = std::upper_bound(t_s.begin(), t_s.end(), at + kHalfWindow_s) - t_s.begin();
  if (last - first < 3) return 0.0;
  double t = 0.0;
  double c = 0.0;
  const double n = static_cast<double>(last - first);
  for (auto k = static_cast<std::size_t>(first); k < static_cast<std::size_t>(last); ++k) {
    t += t_s[k] / n;
    c += temp_c[k] / n;
  }
  double squares = 0.0;
  double products = 0.0;
  for (auto k = static_cast<std::size_t>(first); k < static_cast<std::size_t>(last); ++k) {
    squares += (t_s[k] - t) * (t_s[k] - t);
    products += (t_s[k] - t) * (temp_c[k] - c);
  }
  return squares > 0.0 ? products / squares : 0.0;
}

/// A channel at the observations; empty where any of them has no value.
template <class Channel>
std::vector<double> at_blocks(const LoggedCampaign& campaign, const Observations& observations, Channel channel) {
  std::vector<double> values;
  for (const Observation& row : observations.rows) {
    const RunLog& log = campaign.runs[observations.logged[static_cast<std::size_t>(row.run)]].log;
    const std::vector<double>& logged = channel(log);
    if (logged.empty()) return {};
    const double value = mean_about(log, logged, row.t_s, kHalfBlock_s);
    if (!std::isfinite(value)) return {};
    values.push_back(value);
  }
  return values;
}

std::vector<double> unix_times(const LoggedCampaign& campaign, const Observations& observations) {
  std::vector<double> values;
  for (const Observation& row : observations.rows) {
    const auto& start = campaign.runs[observations.logged[static_cast<std::size_t>(row.run)]].start_utc_s;
    if (!start) return {};
    values.push_back(*start + row.t_s);
  }
  return values;
}

/// Whether a run's log reaches from its first observation to its last.
bool covers(const std::vector<double>& t_s, const Observations& observations, std::size_t run) {
  return std::all_of(observations.rows.begin(), observations.rows.end(), [&](const Observation& row) {
    return static_cast<std::size_t>(row.run) != run ||
           (!t_s.empty() && row.t_s > t_s.front() - kLoggingHole_s && row.t_s < t_s.back() + kLoggingHole_s);
  });
}

std::optional<std::string> why_coarse(const LoggedCampaign& campaign) {
  const auto& step_c = campaign.thermometer.step;
  if (!step_c || *step_c < kCoarseStep_c) return std::nullopt;
  return fmt::format("the thermometer moves in steps of {:.2g} K", *step_c);
}

std::optional<std::string> why_blurred(const LoggedCampaign& campaign, const Observations& observations) {
  if (auto coarse = why_coarse(campaign)) return coarse;
  if (observations.level_c.size() < kLeastLevels) {
    return "fewer than five plateaus: the slope of the curve is not known well enough";
  }
  return std::nullopt;
}

/// Sign of the first move of the temperature by more than half of kTurn_c; 1 where there is none.
double first_movement(const std::vector<double>& temp_c) {
  for (const double c : temp_c) {
    if (std::abs(c - temp_c.front()) > kTurn_c / 2) return std::copysign(1.0, c - temp_c.front());
  }
  return 1.0;
}

std::vector<double> memory_of(const std::vector<double>& temp_c, double width_c, std::optional<double> along) {
  std::vector<double> memory;
  // The end of a rod that follows the temperature with a play of ±kTurn_c/2: it stands while the temperature dithers.
  double follower = temp_c.empty() ? 0.0 : temp_c.front();
  double h = follower < kStartRoom_c ? -1.0 : 1.0;
  if (along) h = *along * first_movement(temp_c);
  for (const double c : temp_c) {
    const double next = std::clamp(follower, c - kTurn_c / 2, c + kTurn_c / 2);
    const double step = next - follower;
    if (step != 0.0) h += (std::copysign(1.0, step) - h) * -std::expm1(-std::abs(step) / width_c);
    follower = next;
    memory.push_back(h);
  }
  return memory;
}

}  // namespace

TemperatureHistory::TemperatureHistory(const LoggedCampaign& campaign, const Observations& observations)
    : observations_(observations), blurred_(why_blurred(campaign, observations)), coarse_(why_coarse(campaign)) {
  double holes_s = 0.0;
  double logged_s = 0.0;
  for (const std::size_t number : observations.logged) {
    const LoggedRun& run = campaign.runs[number];
    RunTemperature kept;
    for (std::size_t k = 0; k < run.log.t_s.size(); ++k) {
      if (!std::isfinite(run.log.temp_c[k])) continue;
      const double step_s = kept.t_s.empty() ? 0.0 : run.log.t_s[k] - kept.t_s.back();
      logged_s += step_s;
      if (step_s > kLoggingHole_s) holes_s += step_s;
      kept.t_s.push_back(run.log.t_s[k]);
      kept.temp_c.push_back(run.log.temp_c[k]);
    }
    runs_.push_back(std::move(kept));
    continuous_ = continuous_ && covers(runs_.back().t_s, observations, runs_.size() - 1);
  }
  continuous_ = continuous_ && holes_s <= kHoles * logged_s;
  for (const Observation& row : observations.rows) {
    const auto r = static_cast<std::size_t>(row.run);
    rate_.push_back(slope_about(runs_[r].t_s, runs_[r].temp_c, row.t_s));
  }
  since_power_ = at_blocks(campaign, observations, [](const RunLog& log) -> auto& { return log.t_since_power_s; });
  compressor_ = at_blocks(campaign, observations, [](const RunLog& log) -> auto& { return log.compressor; });
  supply_ = at_blocks(campaign, observations, [](const RunLog& log) -> auto& { return log.supply_v; });
  chamber_ = at_blocks(campaign, observations, [](const RunLog& log) -> auto& { return log.chamber_c; });
  unit_ = at_blocks(campaign, observations, [](const RunLog& log) -> auto& { return log.temp_c; });
  utc_ = unix_times(campaign, observations);
}

std::vector<double> TemperatureHistory::at_observations(const std::vector<std::vector<double>>& of_runs) const {
  std::vector<double> values;
  for (const Observation& row : observations_.rows) {
    const auto r = static_cast<std::size_t>(row.run);
    values.push_back(of_runs[r].empty() ? 0.0 : interpolate(runs_[r].t_s, of_runs[r], row.t_s));
  }
  return values;
}

std::vector<double> TemperatureHistory::lag(double tau_s, bool under_way) const {
  std::vector<std::vector<double>> of_runs;
  for (const RunTemperature& run : runs_) {
    std::vector<double> behind(run.t_s.size(), 0.0);
    if (under_way && !behind.empty()) {
      behind[0] = -tau_s * slope_about(run.t_s, run.temp_c, run.t_s.front());
    }
    for (std::size_t k = 1; k < behind.size(); ++k) {
      // Exact for a straight line between two samples.
      const double dt = run.t_s[k] - run.t_s[k - 1];
      const double slope = (run.temp_c[k] - run.temp_c[k - 1]) / dt;
      const double decay = std::exp(-dt / tau_s);
      behind[k] = behind[k - 1] * decay - slope * tau_s * (1.0 - decay);
    }
    of_runs.push_back(std::move(behind));
  }
  return at_observations(of_runs);
}

std::vector<double> TemperatureHistory::branch_memory(double width_c, std::optional<double> along) const {
  std::vector<std::vector<double>> of_runs;
  for (const RunTemperature& run : runs_) of_runs.push_back(memory_of(run.temp_c, width_c, along));
  return at_observations(of_runs);
}

std::vector<double> TemperatureHistory::water_left(double tau_s, double activation_k) const {
  constexpr double kFifty_k = 323.15;
  constexpr double kZero_k = 273.15;
  std::vector<std::vector<double>> of_runs;
  for (const RunTemperature& run : runs_) {
    std::vector<double> water(run.t_s.size(), 1.0);
    for (std::size_t k = 1; k < water.size(); ++k) {
      const double kelvin = 0.5 * (run.temp_c[k] + run.temp_c[k - 1]) + kZero_k;
      const double dried = (run.t_s[k] - run.t_s[k - 1]) / tau_s * std::exp(activation_k * (1 / kFifty_k - 1 / kelvin));
      water[k] = water[k - 1] * std::exp(-dried);
    }
    of_runs.push_back(std::move(water));
  }
  return at_observations(of_runs);
}

}  // namespace soak::calib::gap
