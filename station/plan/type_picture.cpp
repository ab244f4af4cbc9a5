// SPDX-License-Identifier: Apache-2.0
#include "station/plan/type_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "base/statistics.h"
#include "calib/curve/curve_fit.h"
#include "calib/estimate/unit_rows.h"
#include "calib/vocabulary/warning.h"
#include "station/config/procedure.h"
#include "station/fit/fit_unit.h"
#include "station/plan/campaign_design.h"

namespace soak::station {
namespace {

/// The stored curves of a type's units, sensor by sensor.
struct StoredCurves {
  std::array<std::vector<calib::StoredCurve>, calib::kSensorCount> sensors;
  std::vector<std::string> units;
  std::vector<double> plateaus_c;
  std::vector<calib::Warning> warnings;
};

/// Typical recording in one position.
double dwell_of(const calib::UnitInput& input) {
  std::vector<double> seconds;
  for (const calib::RunInput& run : input.runs) {
    for (const calib::Segment& segment : run.segments) {
      if (segment.position) seconds.push_back(segment.t_end_s - segment.t_start_s);
    }
  }
  return seconds.empty() ? 0.0 : base::median(seconds);
}

bool shows_curve(const std::optional<calib::CurveData>& bias) {
  return bias && bias->by_plateau && calib::distinct_temperatures(*bias) >= calib::kCurveTemperatures;
}

void add_unit(const calib::UnitInput& input, const calib::UnitRows& rows, const std::vector<calib::Warning>& warnings,
              StoredCurves& stored) {
  const double dwell_s = dwell_of(input);
  // One attitude, or no plateaus: nothing that positions at plateaus would give.
  if (dwell_s <= 0.0 || rows.relative_accel || std::ranges::none_of(rows.bias, shows_curve)) return;
  stored.units.push_back(input.unit);
  for (const calib::Warning& warning : warnings) {
    stored.warnings.push_back({warning.code, fmt::format("{}: {}", input.unit, warning.text)});
  }
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    if (shows_curve(rows.bias[s])) stored.sensors[s].push_back({*rows.bias[s], dwell_s});
  }
  for (const calib::RunInput& run : input.runs) {
    for (const calib::Segment& segment : run.segments) {
      if (segment.plateau_c) stored.plateaus_c.push_back(*segment.plateau_c);
    }
  }
}

/// Whether the unit has a model, and runs for a fit that are simulated, or measured, as asked.
base::Result<bool> is_asked_for(const db::Catalog& catalog, const db::UnitRow& unit, bool simulated) {
  const auto model = catalog.model(unit.serial);
  if (!model) return base::forward_error(model);
  if (!*model) return false;
  const auto runs = catalog.runs({.unit = unit.serial, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  return std::ranges::any_of(
      *runs, [&](const db::RunRow& run) { return is_for_fit(run, unit.epoch) && run.simulated == simulated; });
}

base::Result<StoredCurves> stored_curves(const db::Catalog& catalog, const std::string& type, bool simulated) {
  StoredCurves stored;
  auto units = catalog.units();
  if (!units) return base::forward_error(units);
  std::ranges::reverse(*units);
  for (const db::UnitRow& unit : *units) {
    if (unit.type != type || stored.units.size() == kMostUnitsOfPicture) continue;
    const auto asked = is_asked_for(catalog, unit, simulated);
    if (!asked) return base::forward_error(asked);
    if (!*asked) continue;
    std::vector<calib::Warning> warnings;
    const auto input = load_unit(catalog, unit.serial, std::nullopt, warnings);
    if (!input) return base::forward_error(input);
    const auto rows = calib::make_rows(*input);
    if (rows) add_unit(*input, *rows, warnings, stored);  // what a fit refuses teaches nothing
  }
  return stored;
}

/// Standard deviation of a curve, and of a power-on's level, of which an unknown unit of the type is suspected: the
/// limit holds 95 % of what is wrong with one that is not calibrated, half of its variance over temperature and half
/// between power-ons.
double suspected(double limit) { return limit / (2.0 * std::numbers::sqrt2); }

/// From the limits of the type's file; absent where it has none. Limits of the pre-flight say nothing of the noise:
/// they are there to find broken sensors.
std::optional<calib::SensorPicture> stated_picture(const calib::UnitType& type, calib::Sensor sensor) {
  constexpr double kBends = 4.0;        // lengths in the rated range
  constexpr double kVisitNoise = 0.01;  // of the limit
  const auto limit = type.limits.bias[index_of(sensor)];
  if (!limit) return std::nullopt;
  const auto gap = is_gyro(sensor) ? type.gyro_hysteresis_dps : type.accel_hysteresis_mps2;
  calib::SensorPicture picture;
  picture.smoothness = calib::Smoothness::once;
  picture.length_c = (*type.temp_max_c - *type.temp_min_c) / kBends;
  picture.scale = picture.run_to_run = suspected(*limit);
  picture.half_gap = 0.5 * gap.value_or(0.0) / calib::printed_per_si(sensor);
  picture.noise = kVisitNoise * *limit;
  return picture;
}

/// What a learnt picture lacks, from the type's file, with a remark.
void complete(const calib::UnitType& type, calib::Sensor sensor, const calib::LearntPicture& learnt,
              TypePicture& known) {
  calib::SensorPicture picture = learnt.picture;
  if (!learnt.half_gap_known) {
    const auto gap = is_gyro(sensor) ? type.gyro_hysteresis_dps : type.accel_hysteresis_mps2;
    picture.half_gap = 0.5 * gap.value_or(0.0) / calib::printed_per_si(sensor);
    known.remarks.push_back(fmt::format("{}: no stored unit went both ways; hysteresis {}", name_of(sensor),
                                        gap ? "is what the type states" : "is not known and counts as none"));
  }
  const auto limit = type.limits.bias[index_of(sensor)];
  if (!learnt.run_to_run_known && limit) {
    picture.run_to_run = suspected(*limit);
    known.remarks.push_back(fmt::format(
        "{}: no stored unit has two power-ons; their scatter is assumed from the type's limit", name_of(sensor)));
  }
  if (learnt.run_to_run_known || limit) {
    known.sensors[index_of(sensor)] = picture;
  } else {
    known.remarks.push_back(fmt::format(
        "{}: not planned for, as no stored unit has two power-ons and the type states no limit", name_of(sensor)));
  }
}

/// What the type's file says of a sensor that the stored units do not show, with a remark.
void stand_in(const calib::UnitType& type, calib::Sensor sensor, TypePicture& known) {
  known.sensors[index_of(sensor)] = stated_picture(type, sensor);
  known.remarks.push_back(fmt::format("{}: no stored unit shows a curve of it; {}", name_of(sensor),
                                      known.sensors[index_of(sensor)]
                                          ? "curve and scatter of power-ons are assumed from the type's limit"
                                          : "it is not planned for, as the type states no limit"));
}

/// Nobody knows how slow the noise of these sensors is.
void remark_dwell(const StoredCurves& stored, TypePicture& known) {
  constexpr double kRounding = 0.95;
  double shortest_s = PassDesign().dwell_s;
  for (const auto& curves : stored.sensors) {
    for (const calib::StoredCurve& curve : curves) shortest_s = std::min(shortest_s, curve.dwell_s);
  }
  const double full_s = full_campaign(known.low_c, known.high_c).dwell_s;
  if (shortest_s >= kRounding * full_s) return;
  known.remarks.push_back(fmt::format(
      "stored units dwelt {:.0f} s in a position: a longer dwell, of the full campaign {:.0f} s too, counts "
      "as no better than theirs",
      shortest_s, full_s));
}

base::Status add_learnt(const calib::UnitType& type, const StoredCurves& stored, TypePicture& known) {
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& curves = stored.sensors[index_of(sensor)];
    if (curves.empty()) {
      stand_in(type, sensor, known);
      continue;
    }
    const auto learnt = calib::learn_picture(curves);
    if (!learnt) return base::forward_error(learnt);
    complete(type, sensor, *learnt, known);
  }
  known.units = stored.units;
  known.warnings = stored.warnings;
  const auto [low, high] = std::ranges::minmax(stored.plateaus_c);
  known.low_c = std::max(low, *type.temp_min_c + Procedure().overshoot_c);
  known.high_c = std::min(high, *type.temp_max_c - Procedure().overshoot_c);
  remark_dwell(stored, known);
  return {};
}

void add_stated(const calib::UnitType& type, TypePicture& known) {
  constexpr double kRound_c = 5.0;
  for (const calib::Sensor sensor : calib::kSensors) known.sensors[index_of(sensor)] = stated_picture(type, sensor);
  known.low_c = std::ceil((*type.temp_min_c + Procedure().overshoot_c) / kRound_c) * kRound_c;
  known.high_c = std::floor((*type.temp_max_c - Procedure().overshoot_c) / kRound_c) * kRound_c;
  known.remarks.push_back(
      "no unit of this type is stored with a model: curves and the scatter of power-ons are assumed from the limits of "
      "the type's file, each with half of the variance; calibrate one unit in full, then plan again");
}

/// Whether plateaus fit into the range, and the end of a run into the rating.
base::Status check_range(const calib::UnitType& type, const TypePicture& known) {
  constexpr double kHottestEnd_c = 60.0;  // that a procedure takes
  const double end_c = end_of_runs_c(type);
  if (end_c > kHottestEnd_c || end_c + Procedure().overshoot_c > *type.temp_max_c) {
    return base::bad_input(
        fmt::format(
            "unit type '{}' is rated {:g} to {:g} °C: no run can end there, which takes {:g} to {:g} °C with an "
            "overshoot of {:g} K on either side",
            type.name, *type.temp_min_c, *type.temp_max_c, Procedure().end_c, kHottestEnd_c, Procedure().overshoot_c),
        "--type");
  }
  if (known.high_c - known.low_c >= kNarrowestRange_c) return {};
  return base::bad_input(
      fmt::format("unit type '{}' is rated {:g} to {:g} °C, {}: plateaus of {:g} to {:g} °C, where a plan needs {:g} K",
                  type.name, *type.temp_min_c, *type.temp_max_c,
                  known.units.empty() ? "which leaves, in whole steps of 5 K after an overshoot of 2 K"
                                      : "and the stored runs cover",
                  known.low_c, known.high_c, kNarrowestRange_c),
      "--type");
}

}  // namespace

base::Result<TypePicture> picture_of_type(const db::Catalog& catalog, const calib::UnitType& type) {
  if (!type.temp_min_c || !type.temp_max_c) {
    return base::bad_input(fmt::format("unit type '{}' states no temperature rating: no range to plan for", type.name),
                           "--type");
  }
  TypePicture known;
  for (const bool simulated : {false, true}) {
    const auto stored = stored_curves(catalog, type.name, simulated);
    if (!stored) return base::forward_error(stored);
    if (stored->units.empty()) continue;
    if (const auto added = add_learnt(type, *stored, known); !added) return base::forward_error(added);
    known.simulated = simulated;
    break;
  }
  if (known.units.empty()) add_stated(type, known);
  if (const auto right = check_range(type, known); !right) return base::forward_error(right);
  if (std::ranges::none_of(known.sensors, [](const auto& sensor) { return sensor.has_value(); })) {
    return base::bad_input(
        fmt::format("nothing is known of units of type '{}': none is stored with runs at plateaus and "
                    "a model, and its file has no [limits]",
                    type.name),
        "--type");
  }
  return known;
}

}  // namespace soak::station
