// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/unit_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/statistics.h"
#include "calib/estimate/body_frame.h"
#include "calib/estimate/detail/gated_input.h"
#include "calib/estimate/detail/readings_check.h"
#include "calib/estimate/detail/row_collector.h"
#include "calib/estimate/detail/unit_type_b.h"

namespace soak::calib {
namespace {

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

bool any_position(const std::vector<const RunInput*>& runs) {
  for (const RunInput* run : runs) {
    for (const Segment& segment : run->segments) {
      if (segment.position) return true;
    }
  }
  return false;
}

/// The least that was subtracted in any run.
EarthRemoval earth_removed(const std::vector<const RunInput*>& runs) {
  EarthRemoval least = EarthRemoval::whole;
  for (const RunInput* run : runs) {
    const bool whole = run->site.latitude_deg && headings_of(run->segments, run->site).complete;
    const auto removed = whole                    ? EarthRemoval::whole
                         : run->site.latitude_deg ? EarthRemoval::vertical
                                                  : EarthRemoval::none;
    least = std::min(least, removed);
  }
  return least;
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

/// Refuses gyros whose scale error no inertial unit has: a rate of the fixture with the wrong sign is off by 2.
base::Status check_gyro_scale(const UnitRows& rows) {
  constexpr double kLargest_ppm = 2e5;
  for (const Sensor sensor : {Sensor::gyro_x, Sensor::gyro_y, Sensor::gyro_z}) {
    const auto& scale = rows.scale[index_of(sensor)];
    if (!scale) continue;
    std::vector<double> values;
    for (const CurveRow& row : scale->rows) values.push_back(row.value);
    const double middle_ppm = base::median(values);
    if (std::abs(middle_ppm) <= kLargest_ppm) continue;
    return base::bad_input(
        fmt::format("{} reads {:.3g} times the rate of the fixture: check the sign and the unit of 'rate_dps' "
                    "(counter-clockwise seen from above is positive), then void the runs and import them again",
                    name_of(sensor), 1.0 + 1e-6 * middle_ppm),
        std::string(name_of(sensor)));
  }
  return {};
}

/// Refuses runs that need gravity of the register where that names several.
base::Status check_reference_gravity(const UnitInput& input) {
  const auto needs = [](const RunInput& run) { return !run.site.gravity_mps2; };
  if (std::ranges::none_of(input.runs, needs)) return {};
  const Reference* first = nullptr;
  for (const ReferenceUse& use : input.references) {
    const Reference& reference = use.reference;
    if (reference.kind != ReferenceKind::gravity || !reference.correction) continue;
    if (first == nullptr) first = &reference;
    const double apart = std::abs(*reference.correction - *first->correction);
    if (apart <= 2.0 * std::hypot(reference.standard_uncertainty, first->standard_uncertainty)) continue;
    return base::bad_input(
        fmt::format("the references of these runs name different gravities, {} m/s2 ('{}') and {} m/s2 ('{}'): give "
                    "--gravity-mps2 at import, or fit one --campaign at a time",
                    *first->correction, first->name, *reference.correction, reference.name),
        input.unit);
  }
  return {};
}

bool gives(const RunInput& run, Sensor sensor) {
  return std::ranges::any_of(run.segments,
                             [&](const Segment& segment) { return segment.sensor[index_of(sensor)].count > 0; });
}

/// States which thermometer each sensor's rows are over. Refuses runs that differ: one curve is over one thermometer.
base::Status state_thermometers(const std::vector<const RunInput*>& used, UnitRows& rows) {
  for (const Sensor sensor : kSensors) {
    const RunInput* first = nullptr;
    for (const RunInput* run : used) {
      if (!gives(*run, sensor)) continue;
      if (first == nullptr) first = run;
      const bool own = run->own_thermometer[index_of(sensor)];
      if (own == first->own_thermometer[index_of(sensor)]) continue;
      return base::bad_input(
          fmt::format("run {} has a thermometer of {} alone, run {} knows it by the unit's: one curve cannot be over "
                      "both; void the runs of one kind, or fit one --campaign at a time",
                      (own ? run : first)->label, name_of(sensor), (own ? first : run)->label),
          std::string(name_of(sensor)));
    }
    rows.own_thermometer[index_of(sensor)] = first != nullptr && first->own_thermometer[index_of(sensor)];
  }
  return {};
}

UnitInput at_known_gravity(UnitInput input) {
  for (RunInput& run : input.runs) run.site = with_reference_gravity(run.site, input.references);
  return input;
}

}  // namespace

std::array<bool, kSensorCount> own_thermometers(const std::vector<Segment>& segments) {
  std::array<bool, kSensorCount> own{};
  for (const Segment& segment : segments) {
    for (std::size_t s = 0; s < kSensorCount; ++s) {
      // Without one the unit's mean stands there, the very same number (segmentation.cpp).
      own[s] = own[s] || (segment.sensor[s].count > 0 && segment.sensor_temp_c[s] != segment.temp_c);
    }
  }
  return own;
}

base::Result<UnitRows> make_rows(const UnitInput& stored) {
  if (const auto one = check_reference_gravity(stored); !one) return base::forward_error(one);
  const UnitInput recorded = at_known_gravity(stored);
  if (const auto sound = check_readings(recorded); !sound) return base::forward_error(sound);
  const auto [input, findings] = leave_out_rejected(recorded);
  if (input.runs.empty()) {
    return base::bad_input(
        fmt::format("the data gate rejects every segment of unit {}: {}", input.unit, findings.front().text));
  }
  const bool by_plateau = std::any_of(input.runs.begin(), input.runs.end(), has_plateaus);
  std::vector<const RunInput*> used;
  for (const RunInput& run : input.runs) {
    if (!by_plateau || has_plateaus(run)) used.push_back(&run);
  }
  UnitRows rows;
  rows.warnings = findings;
  if (const auto same = state_thermometers(used, rows); !same) return base::forward_error(same);
  RowCollector collector(rows, run_names(used), by_plateau);
  for (std::size_t r = 0; r < used.size(); ++r) {
    if (by_plateau) {
      collector.add_plateaus(*used[r], static_cast<int>(r), input.type);
    } else {
      collector.add_blocks(*used[r], static_cast<int>(r), input.type);
    }
  }
  collector.finish();
  if (const auto sane = check_gyro_scale(rows); !sane) return base::forward_error(sane);
  if (std::none_of(rows.bias.begin(), rows.bias.end(), [](const auto& data) { return data.has_value(); })) {
    return base::bad_input(
        fmt::format("the runs of unit {} give no row to fit: all samples are of ramps or moves, or have no "
                    "temperature; 'soak runs show' lists the segments and what the data gate found",
                    input.unit));
  }
  rows.relative_accel = !any_position(used);
  rows.earth_removed = rows.relative_accel ? EarthRemoval::none : earth_removed(used);
  state_type_b(input, used, rows);
  warn(input, used, rows);
  return rows;
}

}  // namespace soak::calib
