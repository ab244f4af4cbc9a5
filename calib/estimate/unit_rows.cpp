// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/unit_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "base/statistics.h"
#include "calib/estimate/detail/joint_fit.h"
#include "calib/estimate/detail/row_collector.h"
#include "calib/estimate/uncertainty_budget.h"

namespace soak::calib {
namespace {

// Refusals before anything is left out: of runs that no inertial unit can have given.

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
    return base::bad_input(fmt::format("the references of these runs name different gravities, {} m/s2 ('{}') and {} "
                                       "m/s2 ('{}'): give --gravity-mps2 at import, or fit one --campaign at a time",
                                       *first->correction, first->name, *reference.correction, reference.name),
                           input.unit);
  }
  return {};
}

constexpr double kLargestReading = 1e6;  ///< deg/s or m/s²
/// No inertial unit is that far from its nominal scale; a swapped position or sign is off by 2.
constexpr double kLargestScaleError = 0.2;
constexpr double kUpright = 0.9;  ///< cosine beyond which an axis counts as pointing up or down

/// Refuses readings that no inertial sensor gives.
base::Status check_magnitude(const UnitInput& input) {
  for (const RunInput& run : input.runs) {
    for (const Segment& segment : run.segments) {
      for (const Sensor sensor : kSensors) {
        const SensorStatistics& statistics = segment.sensor[index_of(sensor)];
        const double mean = statistics.mean * printed_per_si(sensor);
        if (statistics.count == 0 || std::abs(mean) <= kLargestReading) continue;
        return base::bad_input(fmt::format("{} of unit {} reads {:.3g} {} in run '{}': check the unit in the column's "
                                           "name, void the run and import it again into another campaign",
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
          fmt::format("{} of unit {} reads the constant {} in every one of {} samples of run '{}': a stuck or "
                      "disconnected sensor; void the run ('soak runs void'), or import it without this column",
                      name_of(sensor), input.unit, *means.begin() * printed_per_si(sensor), samples, run.label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

/// Middle reading of an accelerometer over the segments of a run in which its axis points up (or down: `sign` −1).
double typical_reading(const RunInput& run, Sensor sensor, double sign) {
  std::vector<double> means;
  for (const Segment& segment : run.segments) {
    const bool plateau = segment.plateau_c && segment.phase == Phase::soak && segment.position && !turns(segment);
    if (!plateau || segment.sensor[index_of(sensor)].count == 0) continue;
    if (sign * segment.position->up[axis_of(sensor)] > kUpright) means.push_back(segment.sensor[index_of(sensor)].mean);
  }
  return base::median(means);
}

/// Refuses runs whose accelerometers, turned up and down, cannot have read gravity: a wrong sign, unit or position
/// label.
base::Status check_gravity(const UnitInput& input, std::span<const GatedRun> used) {
  for (const GatedRun& run : used) {
    const double g = run.place.gravity.mps2 * input.type.sign_at_rest;
    for (const Sensor sensor : {Sensor::accel_x, Sensor::accel_y, Sensor::accel_z}) {
      const double share =
          (typical_reading(*run.recorded, sensor, 1.0) - typical_reading(*run.recorded, sensor, -1.0)) / (2.0 * g);
      if (!(std::abs(share - 1.0) > kLargestScaleError)) continue;
      return base::bad_input(
          fmt::format("{} of unit {} reads {:.3g} times gravity between its up and down positions in run '{}': check "
                      "the sign of the axis (scale = -1 in a columns map), the position labels and the unit in the "
                      "column's name, then void the run and import it into a new campaign",
                      name_of(sensor), input.unit, share, run.recorded->label),
          std::string(name_of(sensor)));
    }
  }
  return {};
}

base::Status check_readings(const UnitInput& input, std::span<const GatedRun> used) {
  if (input.runs.empty()) {
    return base::bad_input(fmt::format("unit {} has no sealed, unvoided run in its current epoch to fit", input.unit));
  }
  if (auto sane = check_magnitude(input); !sane) return sane;
  if (auto alive = check_stuck(input); !alive) return alive;
  return check_gravity(input, used);
}

// What the runs have in common.

/// Labels for messages and JSON; runs of several campaigns may share a label.
std::vector<std::string> run_names(std::span<const GatedRun> used) {
  std::set<std::string> seen;
  bool clash = false;
  for (const GatedRun& run : used) clash = clash || !seen.insert(run.recorded->label).second;
  std::vector<std::string> names;
  for (const GatedRun& run : used) {
    names.push_back(clash ? run.recorded->campaign + "/" + run.recorded->label : run.recorded->label);
  }
  return names;
}

bool gives(std::span<const Segment> segments, Sensor sensor) {
  return std::ranges::any_of(segments,
                             [&](const Segment& segment) { return segment.sensor[index_of(sensor)].count > 0; });
}

/// States which thermometer each sensor's rows are over. Refuses runs that differ: one curve is over one thermometer.
base::Status state_thermometers(std::span<const GatedRun> used, UnitRows& rows) {
  for (const Sensor sensor : kSensors) {
    const RunInput* first = nullptr;
    for (const GatedRun& run : used) {
      if (!gives(run.segments, sensor)) continue;
      if (first == nullptr) first = run.recorded;
      const bool own = run.recorded->own_thermometer[index_of(sensor)];
      if (own == first->own_thermometer[index_of(sensor)]) continue;
      return base::bad_input(
          fmt::format("run {} has a thermometer of its own for {}, run {} has only the unit's: one curve cannot use "
                      "both; void the runs of one kind, or fit one --campaign at a time",
                      (own ? run.recorded : first)->label, name_of(sensor), (own ? first : run.recorded)->label),
          std::string(name_of(sensor)));
    }
    rows.own_thermometer[index_of(sensor)] = first != nullptr && first->own_thermometer[index_of(sensor)];
  }
  return {};
}

/// Whether a run has the axis pointing up and down at rest.
bool turned_both_ways(std::span<const Segment> segments, std::size_t axis) {
  const auto there = [&](double sign) {
    return std::ranges::any_of(segments, [&](const Segment& segment) {
      return segment.position && !turns(segment) && sign * segment.position->up[axis] > six_position::kOnAxis;
    });
  };
  return there(1.0) && there(-1.0);
}

/// Lowest and highest temperature of each sensor in the runs, and how far beyond the unit's type lets constants hold.
std::array<ConstantValidity, kSensorCount> validity_of(const UnitType& type, std::span<const GatedRun> used) {
  std::array<ConstantValidity, kSensorCount> all;
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    ConstantValidity& validity = all[s];
    validity.temp_min_c = std::numeric_limits<double>::infinity();
    validity.temp_max_c = -validity.temp_min_c;
    const auto add = [&](double temp_c) {
      validity.temp_min_c = std::min(validity.temp_min_c, temp_c);
      validity.temp_max_c = std::max(validity.temp_max_c, temp_c);
    };
    for (const GatedRun& run : used) {
      for (const Segment& segment : run.segments) {
        if (segment.sensor[s].count == 0) continue;
        add(segment.sensor_temp_c[s]);
        for (const Block& block : segment.blocks) add(block.sensor_temp_c[s]);
      }
    }
    validity.within_c = type.constants_within_c;
    validity.bias_per_k = is_gyro(sensor) ? type.gyro_bias_per_k_dps : type.accel_bias_per_k_mps2;
    if (validity.bias_per_k) *validity.bias_per_k /= printed_per_si(sensor);
    validity.scale_per_k = is_gyro(sensor) ? type.gyro_scale_per_k_ppm : type.accel_scale_per_k_ppm;
  }
  return all;
}

/// Half of the largest gap between heating and cooling that the unit's type states, SI.
std::array<KnownHysteresis, kSensorCount> hysteresis_of(const UnitType& type) {
  std::array<KnownHysteresis, kSensorCount> all{};
  for (const Sensor sensor : kSensors) {
    const auto& gap = is_gyro(sensor) ? type.gyro_hysteresis_dps : type.accel_hysteresis_mps2;
    if (gap) all[index_of(sensor)] = {0.5 * *gap / printed_per_si(sensor), HysteresisSource::type};
  }
  return all;
}

/// The runs' latitude where all have one; the least, which leaves the most of the Earth's rotation horizontal. An axis
/// counts as turned where every run turned it: one that has not brings its error of the first order into the mean.
Circumstances circumstances_of(const UnitInput& input, std::span<const GatedRun> used) {
  Circumstances of;
  of.thermometer_lsb_c = input.type.temp_lsb_c;
  of.thermometer_repeatability_c = input.type.temp_repeatability_c;
  of.references = input.references;
  of.runs = used.size();
  of.found_attitudes = std::ranges::all_of(used, &GatedRun::in_found_attitudes);
  of.turned_by_hand = std::ranges::any_of(used, [](const GatedRun& run) {
    return !run.recorded->moves.empty() && std::ranges::none_of(run.segments, turns);
  });
  of.positions = false;
  of.turned.fill(true);
  bool latitudes = true;
  for (const GatedRun& run : used) {
    const std::string& campaign = run.recorded->campaign;
    if (std::ranges::find(of.campaigns, campaign) == of.campaigns.end()) of.campaigns.push_back(campaign);
    of.positions = of.positions || std::ranges::any_of(run.segments, [](const Segment& segment) {
                     return segment.position.has_value();
                   });
    for (std::size_t axis = 0; axis < 3; ++axis) {
      of.turned[axis] = of.turned[axis] && turned_both_ways(run.segments, axis);
    }
    latitudes = latitudes && run.place.latitude_deg;
    if (!latitudes) continue;
    const double latitude_deg = std::abs(*run.place.latitude_deg);
    of.latitude_deg = std::min(of.latitude_deg.value_or(latitude_deg), latitude_deg);
  }
  if (!latitudes) of.latitude_deg.reset();
  return of;
}

/// The least that was subtracted in any run.
EarthRemoval earth_removed_from(std::span<const GatedRun> used) {
  EarthRemoval least = EarthRemoval::whole;
  for (const GatedRun& run : used) {
    const EarthRemoval removed = !run.place.latitude_deg       ? EarthRemoval::none
                                 : run.place.headings.complete ? EarthRemoval::whole
                                                               : EarthRemoval::vertical;
    least = std::min(least, removed);
  }
  return least;
}

/// Sessions in attitudes that nobody knows have axes of their own: they stand alone or not at all.
void leave_out_found_attitudes(std::vector<GatedRun>& used, std::vector<Warning>& warnings) {
  const auto found = std::ranges::count_if(used, &GatedRun::in_found_attitudes);
  const auto all = static_cast<std::ptrdiff_t>(used.size());
  if (found == 0 || found == all) return;
  std::erase_if(used, &GatedRun::in_found_attitudes);
  warnings.push_back({"unnamed_attitudes_excluded",
                      fmt::format("{} of {} runs have rests without a position label, the others have labels: "
                                  "they were left out; fit them in a campaign of their own (--campaign)",
                                  found, all)});
}

// What is told and refused of the rows.

/// `accepted_runs`: how many the gate left something of, `with_plateaus`: how many of them gave the rows.
void warn_of_rows(std::size_t accepted_runs, std::size_t with_plateaus, UnitRows& rows) {
  if (with_plateaus < accepted_runs) {
    rows.warnings.push_back({"runs_without_plateaus", fmt::format("{} of {} runs have no plateaus and were left out",
                                                                  accepted_runs - with_plateaus, accepted_runs)});
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

base::Status check_any_row(const UnitRows& rows) {
  if (std::ranges::any_of(rows.bias, [](const auto& data) { return data.has_value(); })) return {};
  return base::bad_input(
      fmt::format("the runs of unit {} give no row to fit: all samples belong to ramps or moves, or have no "
                  "temperature; 'soak runs show' lists the segments and what the data gate found",
                  rows.unit));
}

/// Rows that are still to be filled, with what they are made from.
UnitRows rows_from(const UnitInput& input) {
  UnitRows rows;
  rows.unit = input.unit;
  rows.unit_type = input.type.name;
  rows.epoch = input.epoch;
  rows.references = input.references;
  rows.terms = input.terms;
  for (const RunInput& run : input.runs) {
    rows.runs.push_back({run.run_id, run.label, run.campaign, run.content_sha256});
    rows.simulated = rows.simulated || run.simulated;
  }
  return rows;
}

}  // namespace

base::Result<UnitRows> make_rows(const UnitInput& input) {
  if (const auto one = check_reference_gravity(input); !one) return base::forward_error(one);
  UnitRows rows = rows_from(input);
  std::vector<GatedRun> used = gate_runs(input, rows.warnings);
  if (const auto sound = check_readings(input, used); !sound) return base::forward_error(sound);
  std::erase_if(used, [](const GatedRun& run) { return run.segments.empty() && !run.recorded->segments.empty(); });
  if (used.empty()) {
    return base::bad_input(
        fmt::format("the data gate rejects every segment of unit {}: {}", input.unit, rows.warnings.front().text));
  }
  const std::size_t accepted_runs = used.size();
  const bool by_plateau = std::ranges::any_of(used, &GatedRun::has_plateaus);
  if (by_plateau) std::erase_if(used, [](const GatedRun& run) { return !run.has_plateaus(); });
  const std::size_t with_plateaus = used.size();
  if (const auto same = state_thermometers(used, rows); !same) return base::forward_error(same);
  leave_out_found_attitudes(used, rows.warnings);
  const Circumstances circumstances = circumstances_of(input, used);
  rows.validity = validity_of(input.type, used);
  rows.hysteresis = hysteresis_of(input.type);
  rows.relative_accel = !circumstances.positions && !circumstances.found_attitudes;
  rows.earth_removed = rows.relative_accel ? EarthRemoval::none : earth_removed_from(used);

  RowCollector collector(rows, run_names(used), by_plateau);
  for (std::size_t r = 0; r < used.size(); ++r) {
    if (const auto added = collector.add(used[r], static_cast<int>(r), input.type); !added) {
      return base::forward_error(added);
    }
  }
  collector.finish();
  if (const auto sane = check_gyro_scale(rows); !sane) return base::forward_error(sane);
  if (const auto any = check_any_row(rows); !any) return base::forward_error(any);
  state_type_b(circumstances, rows);
  warn_of_rows(accepted_runs, with_plateaus, rows);
  return rows;
}

}  // namespace soak::calib
