// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/chamber_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "base/statistics.h"
#include "calib/curve/families.h"
#include "calib/judge/detail/schedule.h"
#include "calib/judge/detail/subsampling.h"

namespace soak::calib {
namespace {

constexpr int kFewestRuns = 4;             ///< to be judged at all
constexpr int kFewestRunsRecommended = 3;  ///< under three runs a fit has no held-out error
constexpr double kWorseBy = 1.1;
constexpr double kConfidence = 0.95;
constexpr std::uint64_t kSeed = 20260;
constexpr std::array kRunCounts = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
/// An ANFIS of two rules needs six temperatures.
constexpr std::size_t kFewestPlateaus = 6;

/// Which plateaus in which sweeps.
struct Pattern {
  int step = 1;
  Sweeps sweeps = Sweeps::both;
};

/// All that the options are made of.
struct Campaign {
  std::vector<RunSchedule> schedules;
  std::vector<std::string> names;       ///< labels
  std::vector<std::string> long_names;  ///< with the campaign, where labels clash
  std::vector<double> set_points_c;

  /// Position of a run of a table of rows; -1 for one that is not in the campaign.
  [[nodiscard]] int find(const std::string& name) const {
    for (const auto* list : {&names, &long_names}) {
      const auto found = std::ranges::find(*list, name);
      if (found != list->end()) return static_cast<int>(found - list->begin());
    }
    return -1;
  }
};

/// Rows of one sensor with the visit that each belongs to.
struct SensorRows {
  PlacedRows placed;
  std::vector<std::pair<std::size_t, std::size_t>> visit;  ///< of each row: run of the campaign, visit
};

Campaign campaign_of(const UnitInput& input) {
  Campaign campaign;
  for (const RunInput& run : input.runs) {
    RunSchedule schedule = schedule_of(run);
    if (schedule.visits.empty()) continue;
    campaign.schedules.push_back(std::move(schedule));
    campaign.names.push_back(run.label);
    campaign.long_names.push_back(run.campaign + "/" + run.label);
  }
  campaign.set_points_c = set_points(campaign.schedules);
  return campaign;
}

/// Number of the place (set point, sweep, how manyeth time) of each visit of a run.
std::vector<int> places_of(const RunSchedule& run, const std::vector<double>& set_points_c,
                           std::map<std::tuple<std::size_t, Sweep, int>, int>& numbers) {
  std::map<std::pair<std::size_t, Sweep>, int> times;
  std::vector<int> places;
  for (const PlateauVisit& visit : run.visits) {
    const std::size_t plateau = nearest_set_point(set_points_c, visit.plateau_c);
    const int time = times[{plateau, visit.sweep}]++;
    const auto next = static_cast<int>(numbers.size());
    places.push_back(numbers.try_emplace({plateau, visit.sweep, time}, next).first->second);
  }
  return places;
}

std::optional<SensorRows> sensor_rows(const Campaign& campaign, const CurveData& data, const CurveFit& fit) {
  std::map<std::tuple<std::size_t, Sweep, int>, int> numbers;
  std::vector<std::vector<int>> places;
  for (const RunSchedule& run : campaign.schedules) places.push_back(places_of(run, campaign.set_points_c, numbers));
  SensorRows rows;
  rows.placed.data = data;
  rows.placed.data.rows.clear();
  for (const CurveRow& row : data.rows) {
    const int run = campaign.find(data.runs[static_cast<std::size_t>(row.run)]);
    const int visit = run < 0 ? -1 : visit_at(campaign.schedules[static_cast<std::size_t>(run)], row.t_s);
    if (visit < 0) continue;
    const std::pair<std::size_t, std::size_t> at(run, visit);
    rows.placed.data.rows.push_back(row);
    rows.placed.place.push_back(places[at.first][at.second]);
    rows.visit.push_back(at);
  }
  const auto components = estimate_variance_components(rows.placed.data);
  if (!components) return std::nullopt;
  rows.placed.components = *components;
  rows.placed.structure = structure_of(fit);
  return rows;
}

bool visits_both_ways(const Campaign& campaign) {
  const auto any = [&](Sweep sweep) {
    return std::ranges::any_of(campaign.schedules, [sweep](const RunSchedule& run) {
      return std::ranges::any_of(run.visits, [sweep](const PlateauVisit& visit) { return visit.sweep == sweep; });
    });
  };
  return any(Sweep::up) && any(Sweep::down);
}

std::vector<Pattern> patterns_of(const Campaign& campaign) {
  std::vector<Pattern> patterns = {{1, Sweeps::both}};
  const auto enough = [&](int step) {
    return std::ranges::count(every(campaign.set_points_c.size(), step), true) >=
           static_cast<std::ptrdiff_t>(kFewestPlateaus);
  };
  for (int step = 2; step <= 4 && enough(step); ++step) patterns.push_back({step, Sweeps::both});
  if (!visits_both_ways(campaign)) return patterns;
  for (const Sweeps sweeps : {Sweeps::up, Sweeps::down}) {
    for (int step = 1; step <= 2 && (step == 1 || enough(step)); ++step) patterns.push_back({step, sweeps});
  }
  return patterns;
}

/// Numbers of runs that leave a quarter of them, and two at least, to judge by.
std::vector<int> run_counts(int runs) {
  std::vector<int> counts;
  for (const int count : kRunCounts) {
    if (count <= runs - 2 && 4 * count <= 3 * runs) counts.push_back(count);
  }
  return counts;
}

/// Which visits a pattern keeps, run by run.
std::vector<std::vector<bool>> kept_by(const Campaign& campaign, const Pattern& pattern) {
  const std::vector<bool> plateaus = every(campaign.set_points_c.size(), pattern.step);
  std::vector<std::vector<bool>> kept;
  for (const RunSchedule& run : campaign.schedules) {
    kept.push_back(kept_visits(run, campaign.set_points_c, plateaus, pattern.sweeps));
  }
  return kept;
}

ChamberTimeOption option_of(const Campaign& campaign, const Pattern& pattern,
                            const std::vector<std::vector<bool>>& kept, int runs) {
  ChamberTimeOption option;
  option.runs = runs;
  option.plateau_step = pattern.step;
  option.sweeps = pattern.sweeps;
  const std::vector<bool> plateaus = every(campaign.set_points_c.size(), pattern.step);
  for (std::size_t i = 0; i < plateaus.size(); ++i) {
    if (plateaus[i]) option.plateaus_c.push_back(campaign.set_points_c[i]);
  }
  const double share = static_cast<double>(runs) / static_cast<double>(kept.size());
  for (std::size_t r = 0; r < kept.size(); ++r) {
    const RunHours hours = run_hours(campaign.schedules[r], kept[r]);
    option.hours += share * hours.most;
    option.hours_at_least += share * hours.least;
  }
  return option;
}

std::vector<bool> kept_rows(const SensorRows& rows, const std::vector<std::vector<bool>>& kept) {
  std::vector<bool> keep;
  for (const auto& [run, visit] : rows.visit) keep.push_back(kept[run][visit]);
  return keep;
}

double root(double square) { return std::sqrt(std::max(0.0, square)); }

ExpectedError expected(const SquaredError& error, const SensorRows& rows, double row_variance, int runs) {
  const double t = base::student_t_two_sided(kConfidence, static_cast<double>(rows.placed.data.runs.size()) - 1.0);
  const double half = t * error.standard_error;
  const double high = std::max(0.0, error.value + half);
  return {root(error.value),
          root(error.value - half),
          root(high),
          std::sqrt(row_variance + std::max(0.0, error.value)),
          std::sqrt(row_variance + high),
          rows.placed.components.run_to_run_sigma.value_or(0.0) / std::sqrt(static_cast<double>(runs))};
}

/// Errors of one sensor for the options of one pattern, in order of runs; the last from the trend of those before.
class PatternErrors {
 public:
  PatternErrors(const SensorRows& rows, const std::vector<bool>& keep, const std::vector<int>& counts, int all) {
    std::vector<TrendPoint> points;
    for (const int count : counts) {
      errors_.push_back(subsampled_error(rows.placed, keep, count, kSeed));
      if (errors_.back()) points.push_back({count, *errors_.back()});
    }
    if (!points.empty()) row_variance_ = points.back().error.row_variance;
    errors_.push_back(extrapolated_error(points, all));
  }

  [[nodiscard]] const std::optional<SquaredError>& at(std::size_t index) const { return errors_[index]; }
  [[nodiscard]] double row_variance() const { return row_variance_; }

 private:
  std::vector<std::optional<SquaredError>> errors_;
  double row_variance_ = 0.0;
};

/// Adds one sensor to the options, which stand in order of patterns and then of runs.
void judge(const Campaign& campaign, const SensorRows& rows, Sensor sensor, const std::vector<Pattern>& patterns,
           const std::vector<int>& counts, std::vector<ChamberTimeOption>& options) {
  const int all = static_cast<int>(campaign.schedules.size());
  double row_variance = 0.0;
  auto option = options.begin();
  for (const Pattern& pattern : patterns) {
    const PatternErrors errors(rows, kept_rows(rows, kept_by(campaign, pattern)), counts, all);
    // The first pattern is the whole one, which follows the runs best: what it leaves is the scatter of single rows.
    if (option == options.begin()) row_variance = errors.row_variance();
    for (std::size_t i = 0; i <= counts.size(); ++i, ++option) {
      if (const auto& error = errors.at(i)) {
        option->sensors[index_of(sensor)] = expected(*error, rows, row_variance, option->runs);
      }
    }
  }
}

bool is_as_good(const ChamberTimeOption& option, const ChamberTimeOption& whole) {
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!whole.sensors[s]) continue;
    if (!option.sensors[s] || option.sensors[s]->rmse_shape_high > kWorseBy * whole.sensors[s]->rmse_shape)
      return false;
  }
  return true;
}

std::string recommendation(const ChamberTimeOption& option, double hours) {
  const std::string sweeps =
      option.sweeps == Sweeps::both ? "" : fmt::format(", {} sweep only", name_of(option.sweeps));
  return fmt::format(
      "{} runs at {} plateaus{}: {:.1f} of {:.1f} hours; the shape error on a fresh run is expected to stay within 10 "
      "%  of the whole campaign's for every sensor",
      option.runs, option.plateaus_c.size(), sweeps, option.hours, hours);
}

void recommend(ChamberTime& study) {
  const ChamberTimeOption& whole = study.options.back();
  for (std::size_t i = 0; i + 1 < study.options.size(); ++i) {
    const ChamberTimeOption& option = study.options[i];
    if (option.runs < kFewestRunsRecommended || !is_as_good(option, whole)) continue;
    study.recommended = i;
    study.reason = recommendation(option, study.hours);
    return;
  }
  study.reason =
      "no shorter campaign of at least 3 runs is certain to keep the shape error of every sensor within 10 % of the "
      "whole campaign's";
}

// ---- the document ----

using nlohmann::json;

json expected_error_json(Sensor sensor, const ExpectedError& error) {
  const double factor = printed_per_si(sensor);
  return {{"rmse_shape", error.rmse_shape * factor},
          {"rmse_shape_high", error.rmse_shape_high * factor},
          {"error_rms", error.error_rms * factor},
          {"ci95", {error.error_low * factor, error.error_high * factor}},
          {"level_rms", error.level_rms * factor}};
}

json option_json(const ChamberTimeOption& option) {
  json sensors = json::object();
  for (const Sensor sensor : kSensors) {
    const auto& error = option.sensors[index_of(sensor)];
    if (error) sensors[std::string(name_of(sensor))] = expected_error_json(sensor, *error);
  }
  return {{"runs", option.runs},           {"plateau_step", option.plateau_step},
          {"plateaus", option.plateaus_c}, {"sweeps", name_of(option.sweeps)},
          {"hours", option.hours},         {"hours_at_least", option.hours_at_least},
          {"measured", option.measured},   {"sensors", std::move(sensors)}};
}

/// What every option is compared with: shape error of the whole campaign.
json reference_rmse_json(const ChamberTime& study) {
  json reference = json::object();
  if (study.options.empty()) return reference;
  for (const Sensor sensor : kSensors) {
    const auto& error = study.options.back().sensors[index_of(sensor)];
    if (error) reference[std::string(name_of(sensor))] = error->rmse_shape * printed_per_si(sensor);
  }
  return reference;
}

}  // namespace

ChamberTime study_chamber_time(const UnitInput& input, const UnitRows& rows, const SensorFits& fits) {
  const Campaign campaign = campaign_of(input);
  ChamberTime study;
  study.runs = static_cast<int>(campaign.schedules.size());
  for (const RunSchedule& run : campaign.schedules) {
    study.hours += run_hours(run, std::vector<bool>(run.visits.size(), true)).most;
  }
  if (study.runs < kFewestRuns) {
    study.reason = fmt::format(
        "{} runs with plateaus; at least {} are needed, some to fit parts of the campaign to and two to judge them by",
        study.runs, kFewestRuns);
    return study;
  }
  const std::vector<int> counts = run_counts(study.runs);
  const std::vector<Pattern> patterns = patterns_of(campaign);
  for (const Pattern& pattern : patterns) {
    const auto kept = kept_by(campaign, pattern);
    for (const int count : counts) study.options.push_back(option_of(campaign, pattern, kept, count));
    study.options.push_back(option_of(campaign, pattern, kept, study.runs));
    study.options.back().measured = false;
  }
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (!rows.bias[s] || !fits[s]) continue;
    const auto placed = sensor_rows(campaign, *rows.bias[s], fits[s]->bias);
    if (placed) judge(campaign, *placed, sensor, patterns, counts, study.options);
  }
  // The whole campaign is the longest; of equally long ones it stays the last.
  std::swap(study.options[counts.size()], study.options.back());
  std::stable_sort(study.options.begin(), study.options.end() - 1,
                   [](const auto& a, const auto& b) { return a.hours < b.hours; });
  recommend(study);
  return study;
}

json chamber_time_json(const ChamberTime& study) {
  json options = json::array();
  for (const ChamberTimeOption& option : study.options) options.push_back(option_json(option));
  return {{"hours", study.hours},
          {"runs", study.runs},
          {"reference_rmse_shape", reference_rmse_json(study)},
          {"options", std::move(options)},
          {"recommended", study.recommended ? json(*study.recommended) : json()},
          {"recommendation", study.recommended ? json(study.reason) : json()},
          {"reason", study.reason}};
}

}  // namespace soak::calib
