// SPDX-License-Identifier: Apache-2.0
#include "calib/judge/verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "calib/curve/curve_fit.h"
#include "calib/curve/one_way.h"
#include "calib/judge/detail/row_errors.h"

namespace soak::calib {
namespace {

using verification::RowError;

constexpr double kSameGravity = 1e-5;  ///< relative: 10 ppm of scale

/// A curve of the file with what it is to be compared with.
struct CurveTask {
  std::string name;  ///< "gyro_x", "accel_z scale"
  const Curve* curve = nullptr;
  const UncertaintyTable* table = nullptr;  ///< absent = the file states none
  double temp_min_c = 0.0;
  double temp_max_c = 0.0;
  const CurveData* data = nullptr;  ///< absent = the runs do not give it
  std::optional<double> limit;
  double common_u = 0.0;
  std::vector<std::string> not_stated;
  bool relative = false;
  bool constant = false;  ///< measured at one temperature, so verified at one
  std::size_t file_runs = 0;
};

/// Standard uncertainty that all rows share: gravity and fixture. What the thermometer adds (the slope of the curve) is
/// part of the error in use, not of the measurement.
double common_u(const std::vector<TypeBInput>& inputs) {
  double variance = 0.0;
  for (const TypeBInput& input : inputs) variance += input.constant * input.constant;
  return std::sqrt(variance);
}

/// Those of the same inputs that are not stated.
std::vector<std::string> not_stated(const std::vector<TypeBInput>& inputs) {
  std::vector<std::string> names;
  for (const TypeBInput& input : inputs) {
    if (!input.stated && input.name != "thermometer") names.push_back(input.name);
  }
  return names;
}

/// The decision rule (JCGM 106 §8.3.2, §8.3.3) on rows that span enough of the range.
Verdict judge(const std::vector<RowError>& rows, double limit, double common_u, bool covered) {
  bool passes = true;
  for (const RowError& row : rows) {
    const double guard = verification::expanded(row, common_u);
    if (std::abs(row.error) - guard > limit) return Verdict::fail;
    passes = passes && std::abs(row.error) + guard <= limit;
  }
  if (!covered) return Verdict::not_measured;
  return passes ? Verdict::pass : Verdict::marginal;
}

double covered_share(const std::vector<RowError>& rows, const CurveTask& task) {
  if (task.constant) return 1.0;
  const auto [coldest, warmest] = std::minmax_element(
      rows.begin(), rows.end(), [](const RowError& a, const RowError& b) { return a.temp_c < b.temp_c; });
  const double range_c = task.temp_max_c - task.temp_min_c;
  return range_c > 0.0 ? std::min(1.0, (warmest->temp_c - coldest->temp_c) / range_c) : 1.0;
}

void describe_errors(std::vector<RowError> rows, const CurveTask& task, CurveVerification& result) {
  result.rows = rows.size();
  result.covered = covered_share(rows, task);
  result.rmse_abs = verification::rms(rows);
  const auto worst = std::max_element(rows.begin(), rows.end(), [](const RowError& a, const RowError& b) {
    return std::abs(a.error) < std::abs(b.error);
  });
  result.worst_abs = std::abs(worst->error);
  result.worst_temp_c = worst->temp_c;
  for (const RowError& row : rows) {
    const double guard = verification::expanded(row, task.common_u);
    if (guard <= result.guard) continue;
    result.guard = guard;
    result.guard_factor = guard / std::hypot(row.standard_error, task.common_u);
  }
  for (const verification::Cell& cell : verification::cells_of(rows)) result.temps_c.push_back(cell.temp_c);
  verification::remove_run_means(rows);
  result.rmse_shape = verification::rms(rows);
}

CurveVerification verify_curve(const CurveTask& task) {
  CurveVerification result;
  result.limit = task.limit;
  result.not_stated = task.not_stated;
  if (task.limit) result.verdict = Verdict::not_measured;
  if (task.curve == nullptr || task.data == nullptr) return result;
  auto [rows, out_of_range] = verification::errors_of(*task.curve, task.temp_min_c, task.temp_max_c, *task.data);
  result.out_of_range = out_of_range;
  if (rows.empty()) return result;
  if (task.relative) verification::remove_run_means(rows);
  describe_errors(rows, task, result);
  if (task.limit) result.verdict = judge(rows, *task.limit, task.common_u, result.covered >= kNeededCoverage);
  if (task.table == nullptr) return result;
  // Without a level of its own an error can be compared with the band of the shape only.
  if (!task.relative) result.fresh_band = verification::compare_fresh(rows, *task.table, task.file_runs);
  result.shape_band = verification::compare_shape(std::move(rows), *task.table, task.file_runs);
  return result;
}

/// How much a verdict counts against a sensor.
int severity_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::fail:
      return 4;
    case Verdict::not_measured:
      return 3;
    case Verdict::marginal:
      return 2;
    case Verdict::info:
      return 1;
    case Verdict::pass:
      break;
  }
  return 0;
}

Verdict sensor_verdict(const SensorVerification& sensor) {
  // A scale curve without a limit does not change the verdict on bias.
  if (!sensor.scale || !sensor.scale->limit) return sensor.bias_verdict;
  const Verdict scale = sensor.scale->verdict;
  return severity_of(scale) > severity_of(sensor.bias_verdict) ? scale : sensor.bias_verdict;
}

CurveTask bias_task(Sensor sensor, const SensorCalibration* stated, const UnitRows& rows) {
  const auto& data = rows.bias[index_of(sensor)];
  CurveTask task;
  task.name = name_of(sensor);
  if (stated != nullptr) task.curve = &stated->bias;
  if (stated != nullptr) task.table = &stated->bias_uncertainty;
  if (data) task.data = &*data;
  task.common_u = common_u(rows.bias_type_b[index_of(sensor)]);
  task.not_stated = not_stated(rows.bias_type_b[index_of(sensor)]);
  task.relative = rows.relative_accel && !is_gyro(sensor);
  return task;
}

CurveTask scale_task(Sensor sensor, const SensorCalibration* stated, const UnitRows& rows) {
  const auto& data = rows.scale[index_of(sensor)];
  CurveTask task;
  task.name = std::string(name_of(sensor)) + " scale";
  if (stated != nullptr && stated->scale_ppm) task.curve = &*stated->scale_ppm;
  if (stated != nullptr && stated->scale_uncertainty) task.table = &*stated->scale_uncertainty;
  if (data) task.data = &*data;
  task.common_u = common_u(rows.scale_type_b[index_of(sensor)]);
  task.not_stated = not_stated(rows.scale_type_b[index_of(sensor)]);
  return task;
}

void warn_of_rows(const CurveTask& task, const CurveVerification& result, std::vector<Warning>& warnings) {
  if (task.curve == nullptr) {
    warnings.push_back({"not_verified", fmt::format("{}: a limit is set, but the file has no such curve", task.name)});
    return;
  }
  if (task.data == nullptr) {
    warnings.push_back({"not_verified", fmt::format("{}: the runs do not measure it", task.name)});
    return;
  }
  if (result.covered < kNeededCoverage) {
    warnings.push_back(
        {"partial_range",
         fmt::format("{}: the runs cover {:.0f} % of the valid range {:.1f}..{:.1f} °C; a pass needs {:.0f} %",
                     task.name, 100.0 * result.covered, task.temp_min_c, task.temp_max_c, 100.0 * kNeededCoverage)});
  }
  if (result.out_of_range > 0) {
    warnings.push_back({"out_of_range", fmt::format("{}: {} rows outside {:.1f}..{:.1f} °C were not counted", task.name,
                                                    result.out_of_range, task.temp_min_c, task.temp_max_c)});
  }
}

/// Fresh rows at temperatures that the file's runs visited one way only.
struct OneWayRows {
  std::size_t same_way = 0;
  std::size_t other_way = 0;
};

OneWayRows count_rows(const OneWay& one_way, const CurveData& data) {
  OneWayRows rows;
  for (const CurveRow& row : data.rows) {
    const auto range = std::ranges::find_if(one_way.ranges, [&](const OneWayRange& stated) {
      return row.temp_c >= stated.low_c && row.temp_c <= stated.high_c;
    });
    if (range == one_way.ranges.end() || row.sweep == Sweep::unknown) continue;
    ++(row.sweep == range->sweep ? rows.same_way : rows.other_way);
  }
  return rows;
}

/// What the fresh runs say, and what not, where the file's own went one way only.
void warn_of_one_way(const OneWay& one_way, const std::optional<CurveData>& data, std::vector<Warning>& warnings) {
  const OneWayRows rows = data ? count_rows(one_way, *data) : OneWayRows();
  std::string fresh = "these runs do not show it";
  if (rows.other_way > 0) {
    fresh = fmt::format("{} of {} estimates of these runs there went the other way: their errors hold the whole of it",
                        rows.other_way, rows.other_way + rows.same_way);
  } else if (rows.same_way > 0) {
    fresh = "these runs went the same way, so that they do not show it either: verify with a run that goes both ways";
  }
  Warning warning{"one_way", fmt::format("in the runs of the file {}, and {}; {}", one_way_text(one_way.ranges),
                                         one_way_bands_text(one_way.known.source), fresh)};
  // That of the other sensors is the same where their thermometer is.
  if (std::ranges::find(warnings, warning.text, &Warning::text) == warnings.end()) {
    warnings.push_back(std::move(warning));
  }
}

void warn_of_one_run(const Calibration& calibration, std::vector<Warning>& warnings) {
  const bool of_one_run = std::ranges::any_of(
      calibration.sensors, [](const SensorCalibration& sensor) { return sensor.bias_uncertainty.one_run; });
  if (!of_one_run) return;
  warnings.push_back(
      {"one_run",
       "the file is of one run: ci95 does not hold the scatter from power-on to power-on, and there is no "
       "pi95 to compare a fresh power-on with"});
}

void warn_of_band(const std::string& name, std::string_view what, const std::optional<BandComparison>& band,
                  std::vector<Warning>& warnings) {
  if (!band || !band->too_narrow()) return;
  warnings.push_back(
      {"band_too_narrow", fmt::format("{}: {} {:.2f} times the 95 % band that the file states (RMS); with correct "
                                      "bands one file in a hundred has a curve beyond {:.2f} ({:.0f} % are inside)",
                                      name, what, band->ratio, band->ratio_max, 100.0 * band->inside)});
}

/// The comparisons of a curve with the bands of the file.
std::vector<BandComparison*> bands_of(CurveVerification& curve) {
  std::vector<BandComparison*> bands;
  if (curve.fresh_band) bands.push_back(&*curve.fresh_band);
  if (curve.shape_band) bands.push_back(&*curve.shape_band);
  return bands;
}

/// Verifies the curves of one file against the rows of fresh runs.
class Verifier {
 public:
  Verifier(const Calibration& calibration, const Limits& limits, const UnitRows& rows)
      : calibration_(calibration), limits_(limits), rows_(rows) {
    result_.warnings = rows.warnings;
    warn_of_one_run(calibration, result_.warnings);
  }

  Verification verify() {
    for (const Sensor sensor : kSensors) {
      const std::size_t s = index_of(sensor);
      const SensorCalibration* stated = stated_of(sensor);
      if (stated != nullptr || limits_.bias[s] || limits_.scale_ppm[s]) add(sensor, stated);
    }
    judge_bands();
    result_.verdict = overall();
    return std::move(result_);
  }

 private:
  [[nodiscard]] const SensorCalibration* stated_of(Sensor sensor) const {
    const auto found = std::find_if(calibration_.sensors.begin(), calibration_.sensors.end(),
                                    [&](const SensorCalibration& s) { return s.sensor == sensor; });
    return found == calibration_.sensors.end() ? nullptr : &*found;
  }

  void add(Sensor sensor, const SensorCalibration* stated) {
    const std::size_t s = index_of(sensor);
    if (stated != nullptr && stated->one_way) warn_of_one_way(*stated->one_way, rows_.bias[s], result_.warnings);
    CurveTask bias = bias_task(sensor, stated, rows_);
    SensorVerification verified;
    static_cast<CurveVerification&>(verified) = run(bias, stated, limits_.bias[s]);
    verified.bias_verdict = verified.verdict;
    verified.relative = bias.relative;
    CurveTask scale = scale_task(sensor, stated, rows_);
    if (limits_.scale_ppm[s] || (scale.curve != nullptr && scale.data != nullptr)) {
      verified.scale = run(scale, stated, limits_.scale_ppm[s]);
    }
    verified.verdict = sensor_verdict(verified);
    result_.sensors[s] = std::move(verified);
  }

  CurveVerification run(CurveTask& task, const SensorCalibration* stated, const std::optional<double>& limit) {
    task.limit = limit;
    task.file_runs = calibration_.run_hashes.size();
    task.constant = stated != nullptr && stated->model == name_of(Family::constant);
    if (stated != nullptr) task.temp_min_c = stated->temp_min_c;
    if (stated != nullptr) task.temp_max_c = stated->temp_max_c;
    CurveVerification verified = verify_curve(task);
    warn_of_rows(task, verified, result_.warnings);
    return verified;
  }

  /// All comparisons of a file share the chance of a false alarm.
  void judge_bands() {
    std::vector<BandComparison*> all;
    for (auto& sensor : result_.sensors) {
      if (!sensor) continue;
      for (BandComparison* band : bands_of(*sensor)) all.push_back(band);
      if (!sensor->scale) continue;
      for (BandComparison* band : bands_of(*sensor->scale)) all.push_back(band);
    }
    for (BandComparison* band : all) {
      band->ratio_max = verification::largest_ratio(calibration_.run_hashes.size(), all.size());
    }
    for (const Sensor sensor : kSensors) {
      const auto& result = result_.sensors[index_of(sensor)];
      if (!result) continue;
      warn_of_bands(std::string(name_of(sensor)), *result);
      if (result->scale) warn_of_bands(std::string(name_of(sensor)) + " scale", *result->scale);
    }
  }

  void warn_of_bands(const std::string& name, const CurveVerification& curve) {
    warn_of_band(name, "errors of a fresh power-on are", curve.fresh_band, result_.warnings);
    warn_of_band(name, "errors of the shape are", curve.shape_band, result_.warnings);
  }

  /// A pass only where every sensor of the file has a limit and passes.
  [[nodiscard]] Verdict overall() const {
    Verdict worst = Verdict::pass;
    for (const auto& sensor : result_.sensors) {
      if (!sensor) continue;
      if (sensor->verdict == Verdict::fail) return Verdict::fail;
      if (sensor->verdict == Verdict::marginal) worst = Verdict::marginal;
      if (sensor->verdict != Verdict::pass && worst == Verdict::pass) worst = Verdict::info;
    }
    return worst;
  }

  const Calibration& calibration_;
  const Limits& limits_;
  const UnitRows& rows_;
  Verification result_;
};

base::Status refuse_seen_runs(const Calibration& calibration, const UnitInput& runs) {
  for (const RunInput& run : runs.runs) {
    const auto& seen = calibration.run_hashes;
    if (std::find(seen.begin(), seen.end(), run.content_sha256) == seen.end()) continue;
    return base::bad_input(fmt::format("run '{}' of campaign '{}' holds the same samples as a run that the file was "
                                       "fitted to; verify against runs that no fit has seen",
                                       run.label, run.campaign),
                           runs.unit);
  }
  return {};
}

bool says_nothing(const Verification& verification) {
  return std::none_of(verification.sensors.begin(), verification.sensors.end(),
                      [](const auto& sensor) { return sensor && sensor->rows > 0; });
}

}  // namespace

base::Result<Verification> verify(const Calibration& calibration, const UnitInput& runs, const Limits& limits) {
  if (const auto fresh = refuse_seen_runs(calibration, runs); !fresh) return base::forward_error(fresh);
  const auto rows = make_rows(runs);
  if (!rows) return base::forward_error(rows);
  Verification result = Verifier(calibration, limits, *rows).verify();
  if (says_nothing(result)) {
    return base::bad_input("the runs have no estimate inside the file's valid temperature range", runs.unit);
  }
  const double apart = rows->gravity.mps2 - calibration.gravity_mps2;
  if (calibration.gravity_mps2 > 0.0 && std::abs(apart) > kSameGravity * calibration.gravity_mps2) {
    result.warnings.push_back(
        {"gravity_differs",
         fmt::format("gravity is {:.6g} m/s2 for these runs and {:.6g} m/s2 in the file: that alone is {:.3g} ppm of "
                     "the accelerometers' scale",
                     rows->gravity.mps2, calibration.gravity_mps2, 1e6 * std::abs(apart) / calibration.gravity_mps2)});
  }
  return result;
}

}  // namespace soak::calib
