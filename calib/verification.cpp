// SPDX-License-Identifier: Apache-2.0
#include "calib/verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace soak::calib {
namespace {

constexpr double kGuardFactor = 1.96;
/// Share of a sensor's valid range that fresh rows must span before it can pass.
constexpr double kCoverage = 0.8;

struct RowError {
  int run;
  double temp_c;
  double error;
  double guard;
};

void remove_run_means(std::vector<RowError>& rows) {
  std::map<int, std::pair<double, double>> sums;
  for (const RowError& row : rows) {
    sums[row.run].first += row.error;
    sums[row.run].second += 1.0;
  }
  for (RowError& row : rows) row.error -= sums[row.run].first / sums[row.run].second;
}

double rms(const std::vector<RowError>& rows) {
  double squares = 0.0;
  for (const RowError& row : rows) squares += row.error * row.error;
  return std::sqrt(squares / static_cast<double>(rows.size()));
}

Verdict judge(const std::vector<RowError>& rows, double limit) {
  bool passes = true;
  for (const RowError& row : rows) {
    if (std::abs(row.error) - row.guard > limit) return Verdict::fail;
    passes = passes && std::abs(row.error) + row.guard <= limit;
  }
  return passes ? Verdict::pass : Verdict::marginal;
}

std::optional<SensorVerification> verify_sensor(const SensorCalibration& sensor, const CurveData& data, bool relative,
                                                const std::optional<double>& limit) {
  SensorVerification result;
  result.limit = limit;
  // Estimates at the very ends of the range scatter across it by the thermometer's noise.
  const double slack_c = 0.5;
  std::vector<RowError> rows;
  for (const CurveRow& row : data.rows) {
    if (row.temp_c < sensor.temp_min_c - slack_c || row.temp_c > sensor.temp_max_c + slack_c) {
      ++result.out_of_range;
      continue;
    }
    rows.push_back(
        {row.run, row.temp_c, row.value - evaluate(sensor.bias, row.temp_c), kGuardFactor * row.standard_error});
  }
  if (rows.empty()) return std::nullopt;
  const auto [coldest, warmest] = std::minmax_element(
      rows.begin(), rows.end(), [](const RowError& a, const RowError& b) { return a.temp_c < b.temp_c; });
  const double range_c = sensor.temp_max_c - sensor.temp_min_c;
  result.covered = range_c > 0.0 ? std::min(1.0, (warmest->temp_c - coldest->temp_c) / range_c) : 1.0;
  if (relative) remove_run_means(rows);
  result.rows = rows.size();
  result.rmse_abs = rms(rows);
  const auto worst = std::max_element(rows.begin(), rows.end(), [](const RowError& a, const RowError& b) {
    return std::abs(a.error) < std::abs(b.error);
  });
  result.worst_abs = std::abs(worst->error);
  result.worst_temp_c = worst->temp_c;
  if (limit) result.verdict = judge(rows, *limit);
  remove_run_means(rows);
  result.rmse_shape = rms(rows);
  return result;
}

base::Status refuse_seen_runs(const Calibration& calibration, const UnitInput& runs) {
  for (const RunInput& run : runs.runs) {
    const auto& seen = calibration.run_hashes;
    if (std::find(seen.begin(), seen.end(), run.content_sha256) == seen.end()) continue;
    return base::bad_input(
        fmt::format(
            "run '{}' of campaign '{}' holds the same samples as a run that the file was fitted to; verify against "
            "runs that no fit has seen",
            run.label, run.campaign),
        runs.unit);
  }
  return {};
}

/// The worst of the sensors; a pass only where every sensor of the file was judged, over nearly all of its range.
Verdict overall(const Verification& verification, bool complete) {
  Verdict worst = Verdict::pass;
  bool every_limit = complete;
  for (const auto& sensor : verification.sensors) {
    if (!sensor) continue;
    every_limit = every_limit && sensor->limit.has_value();
    if (sensor->verdict == Verdict::fail) worst = Verdict::fail;
    if (sensor->verdict == Verdict::marginal && worst == Verdict::pass) worst = Verdict::marginal;
  }
  return worst == Verdict::pass && !every_limit ? Verdict::info : worst;
}

}  // namespace

base::Result<Verification> verify(const Calibration& calibration, const UnitInput& runs, const Limits& limits) {
  if (const auto fresh = refuse_seen_runs(calibration, runs); !fresh) return base::forward_error(fresh);
  const auto rows = make_rows(runs);
  if (!rows) return base::forward_error(rows);
  Verification result;
  result.warnings = rows->warnings;
  bool any = false;
  bool complete = true;
  for (const SensorCalibration& sensor : calibration.sensors) {
    const std::size_t s = index_of(sensor.sensor);
    if (!rows->bias[s]) {
      result.warnings.push_back(
          {"not_verified", fmt::format("{}: the runs do not give this sensor", name_of(sensor.sensor))});
      complete = false;
      continue;
    }
    result.sensors[s] =
        verify_sensor(sensor, *rows->bias[s], rows->relative_accel && !is_gyro(sensor.sensor), limits[s]);
    any = any || result.sensors[s];
    if (!result.sensors[s] || result.sensors[s]->covered < kCoverage) {
      complete = false;
      result.warnings.push_back(
          {"partial_range",
           fmt::format("{}: the runs cover {:.0f} % of the valid range {:.1f}..{:.1f} °C; a pass needs {:.0f} %",
                       name_of(sensor.sensor), 100.0 * (result.sensors[s] ? result.sensors[s]->covered : 0.0),
                       sensor.temp_min_c, sensor.temp_max_c, 100.0 * kCoverage)});
    }
    if (result.sensors[s] && result.sensors[s]->out_of_range > 0) {
      result.warnings.push_back(
          {"out_of_range", fmt::format("{}: {} rows outside {:.1f}..{:.1f} °C were not counted", name_of(sensor.sensor),
                                       result.sensors[s]->out_of_range, sensor.temp_min_c, sensor.temp_max_c)});
    }
  }
  if (!any) return base::bad_input("the runs say nothing inside the file's valid temperature range", runs.unit);
  result.verdict = overall(result, complete);
  return result;
}

}  // namespace soak::calib
