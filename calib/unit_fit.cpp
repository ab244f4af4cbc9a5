// SPDX-License-Identifier: Apache-2.0
#include "calib/unit_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "base/statistics.h"
#include "calib/fit/branches.h"
#include "calib/fit/gated_input.h"
#include "calib/six_position/problem.h"
#include "calib/statistics.h"

namespace soak::calib {
namespace {

constexpr double kReferenceTemp_c = 25.0;
constexpr double kLargestReading = 1e6;  ///< deg/s or m/s²
/// No inertial unit is that far from its nominal scale; a swapped position or sign is off by 2.
constexpr double kLargestScaleError = 0.2;
constexpr double kSignificant = 4.0;  ///< standard errors from which an even-order term is told
constexpr double kOnAxis = 0.9;       ///< cosine beyond which an axis counts as pointing up or down

bool has_plateaus(const RunInput& run) {
  return std::any_of(run.segments.begin(), run.segments.end(),
                     [](const Segment& s) { return s.plateau_c.has_value(); });
}

/// Labels for messages and JSON; runs of several campaigns may share a label.
std::vector<std::string> run_names(const std::vector<const RunInput*>& runs) {
  std::set<std::string> seen;
  bool clash = false;
  for (const RunInput* run : runs) clash = clash || !seen.insert(run->label).second;
  std::vector<std::string> names;
  for (const RunInput* run : runs) names.push_back(clash ? run->campaign + "/" + run->label : run->label);
  return names;
}

/// Refuses readings that no inertial sensor gives.
base::Status check_magnitude(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    for (const Segment& segment : run.segments) {
      for (const Sensor sensor : kSensors) {
        const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
        const double mean = statistics.mean * printed_per_si(sensor);
        if (statistics.count == 0 || std::abs(mean) <= kLargestReading) continue;
        return base::bad_input(
            fmt::format("{} of unit {} reads {:.3g} {} in run '{}': check the unit in the column's name, "
                        "void the run and import it again",
                        name_of(sensor), input.unit, mean, printed_unit(sensor), run.label),
            std::string(name_of(sensor)));
      }
    }
  }
  return {};
}

/// Refuses a sensor that gave one and the same number throughout a run.
base::Status check_stuck(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    for (const Sensor sensor : kSensors) {
      std::set<double> means;
      std::size_t samples = 0;
      bool varies = false;
      for (const Segment& segment : run.segments) {
        const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
        if (statistics.count == 0) continue;
        samples += statistics.count;
        varies = varies || statistics.variance > 0.0;
        means.insert(statistics.mean);
      }
      if (samples < 2 || varies || means.size() != 1) continue;
      return base::bad_input(
          fmt::format(
              "{} of unit {} reads the constant {} in every one of {} samples of run '{}': a stuck or disconnected "
              "sensor; void the run ('soak runs void'), or import it without this column",
              name_of(sensor), input.unit, *means.begin() * printed_per_si(sensor), samples, run.label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

/// Takes the rows of one run after another into the six sensors' tables.
class RowCollector {
 public:
  RowCollector(UnitRows& rows, std::vector<std::string> names, bool by_plateau)
      : rows_(rows), names_(std::move(names)), by_plateau_(by_plateau) {}

  void add_plateaus(const RunInput& run, int index, const UnitType& type) {
    const SixPositionEstimate estimate = estimate_six_positions(run.segments, run.site, type);
    add_gravity(estimate.gravity);
    for (const Warning& warning : estimate.warnings) {
      ++seen_in_[{warning.code, warning.text}];
      if (seen_in_[{warning.code, warning.text}] == 1) first_seen_.push_back({warning, name(index)});
    }
    for (const Sensor sensor : kSensors) {
      const std::size_t s = index_of(sensor);
      for (const PlateauEstimate& plateau : estimate.sensor[s].plateaus) {
        const std::string branch = fmt::format("{} {}", name(index), name_of(plateau.sweep));
        CurveRow row{
            index,          branch_of(rows_.bias[s], branch), plateau.sweep, plateau.t_s, plateau.temp_c, plateau.bias,
            plateau.bias_se};
        table(rows_.bias[s]).rows.push_back(row);
        if (!plateau.scale_ppm) continue;
        row.branch = branch_of(rows_.scale[s], branch);
        row.value = *plateau.scale_ppm;
        row.standard_error = *plateau.scale_se_ppm;
        table(rows_.scale[s]).rows.push_back(row);
      }
      couplings_[s].push_back(estimate.sensor[s]);
    }
  }

  void add_blocks(const RunInput& run, int index, const UnitType& type) {
    add_gravity(gravity_at(run.site));
    for (const Sensor sensor : kSensors) {
      std::vector<CurveRow> rows = block_rows(run, index, sensor, type);
      if (rows.empty()) continue;
      std::vector<double> temps;
      for (const CurveRow& row : rows) temps.push_back(row.temp_c);
      std::map<Sweep, int> count;
      auto& target = rows_.bias[index_of(sensor)];
      for (const Branch& branch : find_branches(temps)) {
        const std::string_view word = branch.sweep == Sweep::up     ? "heating"
                                      : branch.sweep == Sweep::down ? "cooling"
                                                                    : "steady";
        const int id = branch_of(target, fmt::format("{} {} {}", name(index), word, ++count[branch.sweep]));
        for (std::size_t i = branch.first; i < branch.last; ++i) {
          rows[i].branch = id;
          rows[i].sweep = branch.sweep;
        }
      }
      auto& all = table(target).rows;
      all.insert(all.end(), rows.begin(), rows.end());
    }
  }

  /// What the runs' estimates warn of; the same words of several runs once.
  void state_warnings() const {
    for (const auto& [warning, run] : first_seen_) {
      const std::size_t more = seen_in_.at({warning.code, warning.text}) - 1;
      rows_.warnings.push_back(
          {warning.code, fmt::format("run {}: {}{}", run, warning.text,
                                     more > 0 ? fmt::format(" (and so in {} more runs)", more) : "")});
    }
    for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) warn_of_even_order(sensor);
  }

  /// Mean over runs of one kind of sensor's couplings, weighted; absent unless all three sensors have all entries.
  [[nodiscard]] std::optional<Coupling> mean_coupling(bool gyros) const {
    Coupling mean;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& runs = couplings_[gyros ? i : i + 3];
      for (std::size_t j = 0; j < 3; ++j) {
        if (!gyros && i == j) continue;
        std::vector<Estimate> entries;
        for (const SensorEstimate& run : runs) {
          if (run.coupling[j]) entries.push_back({*run.coupling[j], run.coupling_se[j]});
        }
        const auto entry = average(entries);
        if (!entry) return std::nullopt;
        mean.value[i][j] = entry->value;
        mean.standard_error[i][j] = entry->standard_error;
      }
    }
    return mean;
  }

 private:
  /// The unit's gravity is the mean over its runs: each run was reduced with its own.
  void add_gravity(const Gravity& gravity) {
    ++gravity_count_;
    rows_.gravity.mps2 += (gravity.mps2 - rows_.gravity.mps2) / gravity_count_;
    rows_.gravity.assumed = rows_.gravity.assumed || gravity.assumed;
  }

  [[nodiscard]] const std::string& name(int index) const { return names_[static_cast<std::size_t>(index)]; }

  CurveData& table(std::optional<CurveData>& data) {
    if (!data) {
      data.emplace();
      data->runs = names_;
      data->by_plateau = by_plateau_;
    }
    return *data;
  }

  int branch_of(std::optional<CurveData>& data, const std::string& branch) {
    auto& branches = table(data).branches;
    const auto found = std::find(branches.begin(), branches.end(), branch);
    if (found != branches.end()) return static_cast<int>(found - branches.begin());
    branches.push_back(branch);
    return static_cast<int>(branches.size()) - 1;
  }

  static std::vector<CurveRow> block_rows(const RunInput& run, int index, Sensor sensor, const UnitType& type) {
    const std::size_t s = index_of(sensor);
    const double g = gravity_at(run.site).mps2 * type.sign_at_rest;
    const double vertical = run.site.latitude_deg ? vertical_earth_rate_rps(*run.site.latitude_deg) : 0.0;
    std::vector<CurveRow> rows;
    for (const Segment& segment : run.segments) {
      if (six_position::turns(segment)) continue;
      double known = 0.0;
      if (segment.position) known = (is_gyro(sensor) ? vertical : g) * segment.position->up[axis_of(sensor)];
      for (const Block& block : segment.blocks) {
        if (block.sensor[s].count == 0) continue;
        rows.push_back({index, 0, Sweep::unknown, block.t_s, block.sensor_temp_c[s], block.sensor[s].mean - known,
                        block.sensor[s].standard_error});
      }
    }
    return rows;
  }

  /// Weighted mean, its error inflated where the estimates scatter by more than theirs; nothing of nothing.
  static std::optional<Estimate> average(std::vector<Estimate> estimates) {
    std::erase_if(estimates, [](const Estimate& estimate) { return estimate.standard_error <= 0.0; });
    if (estimates.empty()) return std::nullopt;
    double weight = 0.0;
    double sum = 0.0;
    for (const Estimate& estimate : estimates) {
      const double w = std::pow(estimate.standard_error, -2);
      weight += w;
      sum += w * estimate.value;
    }
    const double mean = sum / weight;
    double scatter = 0.0;
    for (const Estimate& estimate : estimates) {
      scatter += std::pow((estimate.value - mean) / estimate.standard_error, 2);
    }
    const auto freedoms = static_cast<double>(estimates.size()) - 1.0;
    const double inflation = freedoms > 0.0 ? std::max(1.0, scatter / freedoms) : 1.0;
    return Estimate{mean, std::sqrt(inflation / weight)};
  }

  /// Tells a significant even-order term, mean over runs: it is the difference between bias at ±g and at 0 g.
  void warn_of_even_order(Sensor sensor) const {
    std::vector<Estimate> terms;
    for (const SensorEstimate& run : couplings_[index_of(sensor)]) {
      if (run.even_order) terms.push_back(*run.even_order);
    }
    const auto term = average(terms);
    if (!term || std::abs(term->value) < kSignificant * term->standard_error) return;
    constexpr double kPerG = 1e6 * base::kStandardGravity_mps2;  // 1/(m/s²) to µg/g²
    const double g = rows_.gravity.mps2;
    rows_.warnings.push_back(
        {"even_order",
         fmt::format("{}: even-order term of {:.4g} ± {:.2g} µg/g² (one standard error); its bias is that at ±1 g, and "
                     "that at 0 g is {:.3g} m/s2 {}. Faces of the fixture that are not square look the same",
                     name_of(sensor), kPerG * term->value, kPerG * term->standard_error, std::abs(term->value) * g * g,
                     term->value > 0.0 ? "lower" : "higher")});
  }

  UnitRows& rows_;
  std::vector<std::string> names_;
  bool by_plateau_;
  double gravity_count_ = 0.0;
  std::map<std::pair<std::string, std::string>, std::size_t> seen_in_;  ///< runs by code and text of their warnings
  std::vector<std::pair<Warning, std::string>> first_seen_;             ///< in order, with the run's name
  std::array<std::vector<SensorEstimate>, kSensorCount> couplings_;
};

/// Drops the names of runs that gave no row and renumbers.
void drop_empty_runs(std::optional<CurveData>& data) {
  if (!data) return;
  std::vector<int> number(data->runs.size(), -1);
  std::vector<std::string> kept;
  for (const CurveRow& row : data->rows) number[static_cast<std::size_t>(row.run)] = 0;
  for (std::size_t r = 0; r < number.size(); ++r) {
    if (number[r] < 0) continue;
    number[r] = static_cast<int>(kept.size());
    kept.push_back(data->runs[r]);
  }
  for (CurveRow& row : data->rows) row.run = number[static_cast<std::size_t>(row.run)];
  data->runs = std::move(kept);
  if (data->rows.empty()) data.reset();
}

/// Middle reading of an accelerometer over the segments of a run in which its axis points up (or down: `sign` −1).
double typical_reading(const RunInput& run, Sensor sensor, double sign) {
  std::vector<double> means;
  for (const Segment& segment : run.segments) {
    const bool plateau =
        segment.plateau_c && segment.phase == Phase::soak && segment.position && !six_position::turns(segment);
    if (!plateau || segment.sensor[index_of(sensor)].count == 0) continue;
    if (sign * segment.position->up[axis_of(sensor)] > kOnAxis) means.push_back(segment.sensor[index_of(sensor)].mean);
  }
  return base::median(means);
}

/// Refuses runs whose accelerometers, turned up and down, cannot have read gravity: a wrong sign, unit or position
/// label.
base::Status check_gravity(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    const double g = gravity_at(run.site).mps2 * input.type.sign_at_rest;
    for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) {
      const double share = (typical_reading(run, sensor, 1.0) - typical_reading(run, sensor, -1.0)) / (2.0 * g);
      if (!(std::abs(share - 1.0) > kLargestScaleError)) continue;
      return base::bad_input(
          fmt::format(
              "{} of unit {} reads {:.3g} times gravity between its up and down positions in run '{}': check the "
              "sign of the axis (scale = -1 in a columns map), the position labels and the unit in the column's "
              "name, then void the run and import it into a new campaign",
              name_of(sensor), input.unit, share, run.label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

/// Refusals that look at everything recorded, also at what the data gate rejects.
base::Status check_readings(const UnitInput& input) {
  if (input.runs.empty()) {
    return base::bad_input(fmt::format("unit {} has no sealed, unvoided run in its current epoch to fit", input.unit));
  }
  if (auto sane = check_magnitude(input); !sane) return sane;
  if (auto alive = check_stuck(input); !alive) return alive;
  return check_gravity(input);
}

bool any_position(const std::vector<const RunInput*>& runs) {
  for (const RunInput* run : runs) {
    for (const Segment& segment : run->segments) {
      if (segment.position) return true;
    }
  }
  return false;
}

void warn(const UnitInput& input, const std::vector<const RunInput*>& used, UnitRows& rows) {
  if (used.size() < input.runs.size()) {
    rows.warnings.push_back({"runs_without_plateaus", fmt::format("{} of {} runs have no plateaus and were left out",
                                                                  input.runs.size() - used.size(), input.runs.size())});
  }
  if (rows.gravity.assumed && !rows.relative_accel) {
    rows.warnings.push_back(
        {"gravity_assumed",
         fmt::format(
             "gravity was assumed to be {} m/s2; give --gravity-mps2, or --latitude-deg and --height-m, at import",
             rows.gravity.mps2)});
  }
  if (rows.relative_accel) {
    rows.warnings.push_back({"one_attitude",
                             "one attitude throughout: gyro bias holds the Earth's rotation and g-sensitivity, "
                             "accelerometer bias is relative to that at 25 °C, and no scale factor can be given"});
  }
}

void shift(Curve& curve, double by) {
  if (auto* model = std::get_if<anfis::Model>(&curve)) {
    model->output.centre += by;
  } else if (auto* spline = std::get_if<SplineCurve>(&curve)) {
    for (auto& piece : spline->coefficients) piece[0] += by;
  } else if (auto* points = std::get_if<TableCurve>(&curve)) {
    for (double& value : points->values) value += by;
  }
}

/// Takes the level out of an accelerometer's bias curve: its value at 25 °C, or at the end of the range nearest to
/// that.
void make_relative(CurveFit& fit) {
  const double level = evaluate(fit.curve, kReferenceTemp_c);
  shift(fit.curve, -level);
  for (CurvePoint& point : fit.points) point.value -= level;
}

}  // namespace

base::Result<UnitRows> make_rows(const UnitInput& recorded) {
  if (const auto sound = check_readings(recorded); !sound) return base::forward_error(sound);
  const auto [input, findings] = leave_out_rejected(recorded);
  if (input.runs.empty()) {
    return base::bad_input(fmt::format("the data gate rejects every segment of unit {}: {} {}", input.unit,
                                       findings.front().code, findings.front().text));
  }
  const bool by_plateau = std::any_of(input.runs.begin(), input.runs.end(), has_plateaus);
  std::vector<const RunInput*> used;
  for (const RunInput& run : input.runs) {
    if (!by_plateau || has_plateaus(run)) used.push_back(&run);
  }
  UnitRows rows;
  rows.warnings = findings;
  RowCollector collector(rows, run_names(used), by_plateau);
  for (std::size_t r = 0; r < used.size(); ++r) {
    if (by_plateau) {
      collector.add_plateaus(*used[r], static_cast<int>(r), input.type);
    } else {
      collector.add_blocks(*used[r], static_cast<int>(r), input.type);
    }
  }
  for (auto& data : rows.bias) drop_empty_runs(data);
  for (auto& data : rows.scale) drop_empty_runs(data);
  if (std::none_of(rows.bias.begin(), rows.bias.end(), [](const auto& data) { return data.has_value(); })) {
    return base::bad_input(
        fmt::format("the runs of unit {} give no row to fit: all samples are of ramps or moves, or have no "
                    "temperature; 'soak runs show' lists the segments and what the data gate found",
                    input.unit));
  }
  rows.accel_misalignment = collector.mean_coupling(false);
  rows.g_sensitivity = collector.mean_coupling(true);
  rows.relative_accel = !any_position(used);
  collector.state_warnings();
  warn(input, used, rows);
  return rows;
}

base::Result<SensorFit> fit_sensor(const UnitRows& rows, Sensor sensor, const CurveFitOptions& options) {
  const auto& bias = rows.bias[index_of(sensor)];
  const std::string name(name_of(sensor));
  if (!bias) return base::bad_input("no run gives this sensor", name);
  auto fitted = fit_curve(*bias, options, {name, std::string(printed_unit(sensor)), printed_per_si(sensor)});
  if (!fitted) return base::forward_error(fitted);
  SensorFit fit;
  fit.bias = std::move(*fitted);
  fit.warnings = fit.bias.warnings;
  if (rows.relative_accel && !is_gyro(sensor)) {
    fit.relative = true;
    make_relative(fit.bias);
  }
  if (const auto& scale = rows.scale[index_of(sensor)]) {
    auto scale_fit = fit_curve(*scale, {}, {name + " scale", "ppm", 1.0});
    if (!scale_fit) return base::forward_error(scale_fit);
    fit.scale = std::move(*scale_fit);
    for (const Warning& warning : fit.scale->warnings) {
      if (warning.code != "few_runs") fit.warnings.push_back(warning);
    }
  }
  return fit;
}

}  // namespace soak::calib
