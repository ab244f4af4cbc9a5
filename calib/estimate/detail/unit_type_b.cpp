// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/unit_type_b.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/units.h"
#include "calib/estimate/detail/problem.h"
#include "calib/estimate/detail/type_b_inputs.h"
#include "calib/estimate/uncertainty_budget.h"

namespace soak::calib {
namespace {

/// Whether a run has the axis pointing up and down at rest.
bool turned_both_ways(const RunInput& run, std::size_t axis) {
  const auto there = [&](double sign) {
    return std::ranges::any_of(run.segments, [&](const Segment& segment) {
      return segment.position && !turns(segment) && sign * segment.position->up[axis] > six_position::kOnAxis;
    });
  };
  return there(1.0) && there(-1.0);
}

/// Whether every run has: one that has not brings its error of the first order into the mean.
bool turned_both_ways(const std::vector<const RunInput*>& runs, std::size_t axis) {
  return std::ranges::all_of(runs, [axis](const RunInput* run) { return turned_both_ways(*run, axis); });
}

bool any_position(const std::vector<const RunInput*>& runs) {
  return std::ranges::any_of(runs, [](const RunInput* run) {
    return std::ranges::any_of(run->segments, [](const Segment& s) { return s.position.has_value(); });
  });
}

/// The runs' latitude where all have one; the least, which leaves the most of the Earth's rotation horizontal.
std::optional<double> latitude_of(const std::vector<const RunInput*>& runs) {
  std::optional<double> least;
  for (const RunInput* run : runs) {
    if (!run->site.latitude_deg) return std::nullopt;
    const double latitude_deg = std::abs(*run->site.latitude_deg);
    least = std::min(least.value_or(latitude_deg), latitude_deg);
  }
  return least;
}

/// A reference's uncertainty is that of the gravity used only where the two are the same number.
Gravity with_reference_uncertainty(Gravity gravity, const std::vector<ReferenceUse>& references) {
  if (gravity.standard_uncertainty_mps2) return gravity;
  for (const ReferenceUse& use : references) {
    const Reference& reference = use.reference;
    if (reference.kind != ReferenceKind::gravity) continue;
    const double apart = reference.correction ? *reference.correction - gravity.mps2 : 0.0;
    if (std::abs(apart) > 2.0 * reference.standard_uncertainty) {
      gravity.basis = fmt::format("not stated: {} m/s2 is not the {} m/s2 of the reference '{}'", gravity.mps2,
                                  *reference.correction, reference.name);
      continue;
    }
    gravity.standard_uncertainty_mps2 = reference.standard_uncertainty;
    gravity.basis = "local gravity (references)";
    return gravity;
  }
  return gravity;
}

/// |G⊥| of a gyro: the response to force across its axis, which is what tilts turn into it. Where the horizontal
/// rotation of the Earth was not subtracted the estimate holds it, each entry cos φ Ω/√2 (root mean square over
/// headings); as the fixture's line counts that rotation itself, it is taken out here.
double cross_sensitivity(const Circumstances& circumstances, const UnitRows& rows, Sensor sensor) {
  if (!is_gyro(sensor) || !rows.g_sensitivity) return 0.0;
  const std::size_t i = axis_of(sensor);
  const auto& row = (*rows.g_sensitivity)[i];
  const double estimated = std::hypot(row[(i + 1) % 3].value, row[(i + 2) % 3].value);
  if (rows.earth_removed == EarthRemoval::whole) return estimated;
  const double earth = horizontal_earth_rate_rps(circumstances) / circumstances.gravity.mps2;
  return std::sqrt(std::max(0.0, estimated * estimated - earth * earth));
}

/// Half-width from both kinds at effective degrees of freedom; the runs' mean has one less than there are runs.
void state(StatedValue& value, const std::optional<double>& type_b, std::size_t runs) {
  value.type_b = type_b;
  std::vector<Contribution> budget = {{.name = "readings", .u = {value.standard_error}}};
  if (runs > 1) budget[0].degrees_of_freedom = static_cast<double>(runs) - 1.0;
  if (type_b) budget.push_back({.name = "type_b", .type = 'B', .u = {*type_b}});
  value.ci95 = expanded_uncertainty(budget, Band::mean, 0);
}

/// What the faces' tilts make of the level error that was subtracted, the worse of its angles; 0 where none was.
double faces_in_level_rad(const Circumstances& circumstances, const LevelStatement& level) {
  if (!level.to_north_east) return 0.0;
  return face_uncertainty_rad(circumstances).value_or(0.0) * std::ranges::max(level.per_face_tilt);
}

/// Misalignment: half the difference of the tilts of two opposite faces about one axis, and at most the whole error of
/// a level error that was subtracted.
void state_misalignment(const Circumstances& circumstances, double level_rad, std::size_t runs, Coupling& coupling) {
  auto type_b = attitude_uncertainty_rad(circumstances);
  if (type_b) *type_b = std::hypot(*type_b / std::numbers::sqrt2, level_rad);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) state(coupling[i][j], type_b, runs);
    }
  }
}

/// g-sensitivity off a gyro's axis, rad/s: the horizontal rotation of the Earth under an unknown heading (arcsine
/// distribution); where it was subtracted, what errors of the attitude leave of the whole rotation, the heading of each
/// position being known as well as its face, in half the difference of two positions.
std::optional<double> earth_off_axis_rps(const Circumstances& circumstances, EarthRemoval removed) {
  if (removed != EarthRemoval::whole) return horizontal_earth_rate_rps(circumstances) / std::numbers::sqrt2;
  const auto u_rad = attitude_uncertainty_rad(circumstances);
  if (!u_rad) return std::nullopt;
  return base::kEarthRate_rps * *u_rad / std::numbers::sqrt2;
}

/// Along the axis what is not known of the vertical rotation of the Earth.
double earth_on_axis_rps(const Circumstances& circumstances) {
  // sin φ of a place anywhere on the Earth is rectangular on [-1, 1].
  if (!circumstances.latitude_deg) return base::kEarthRate_rps / std::numbers::sqrt3;
  return horizontal_earth_rate_rps(circumstances) * attitude_uncertainty_rad(circumstances).value_or(0.0);
}

/// g-sensitivity, in (rad/s)/(m/s²).
void state_g_sensitivity(const Circumstances& circumstances, EarthRemoval removed, std::size_t runs,
                         Coupling& coupling) {
  const double g = circumstances.gravity.mps2;
  auto across = earth_off_axis_rps(circumstances, removed);
  if (across) *across /= g;
  const double along = earth_on_axis_rps(circumstances) / g;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) state(coupling[i][j], i == j ? along : across, runs);
  }
}

/// Level error: what the faces' own tilts do to it.
void state_level(const Circumstances& circumstances, std::size_t runs, LevelStatement& level) {
  if (!level.to_north_east) return;
  const auto u_rad = face_uncertainty_rad(circumstances);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto type_b = u_rad ? std::optional(*u_rad * level.per_face_tilt[k]) : std::nullopt;
    state((*level.to_north_east)[k], type_b, runs);
  }
}

}  // namespace

void state_type_b(const UnitInput& input, const std::vector<const RunInput*>& used, UnitRows& rows) {
  Circumstances circumstances;
  circumstances.gravity = with_reference_uncertainty(rows.gravity, input.references);
  circumstances.latitude_deg = latitude_of(used);
  circumstances.thermometer_lsb_c = input.type.temp_lsb_c;
  circumstances.thermometer_repeatability_c = input.type.temp_repeatability_c;
  circumstances.references = input.references;
  circumstances.positions = any_position(used);
  rows.gravity = circumstances.gravity;
  const std::size_t runs = used.size();
  const double level_rad = faces_in_level_rad(circumstances, rows.level);
  if (rows.accel_misalignment) state_misalignment(circumstances, level_rad, runs, *rows.accel_misalignment);
  if (rows.g_sensitivity) state_g_sensitivity(circumstances, rows.earth_removed, runs, *rows.g_sensitivity);
  state_level(circumstances, runs, rows.level);
  // The four horizontal faces lean to one side by u/√4 on average.
  auto lean = attitude_uncertainty_rad(circumstances);
  if (lean) *lean = std::hypot(*lean / 2.0, level_rad) / circumstances.gravity.mps2;
  for (auto& even_order : rows.even_order) {
    if (even_order) state(*even_order, lean, runs);
  }
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    rows.bias_type_b[s] = bias_inputs(circumstances, sensor, turned_both_ways(used, axis_of(sensor)),
                                      cross_sensitivity(circumstances, rows, sensor));
    rows.scale_type_b[s] = scale_inputs(circumstances, sensor);
  }
}

}  // namespace soak::calib
