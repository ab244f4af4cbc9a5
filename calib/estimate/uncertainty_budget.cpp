// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/uncertainty_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/statistics.h"
#include "base/units.h"
#include "calib/estimate/certificates.h"
#include "calib/estimate/unit_rows.h"

namespace soak::calib {
namespace {

// Type B inputs of the curves.

constexpr double kPpmPerOne = 1e6;

/// The largest standard uncertainty of the references of a kind that corrects nothing: a unit's runs may have seen
/// several. A correction is part of it.
std::optional<double> reference_uncertainty(const Circumstances& circumstances, ReferenceKind kind) {
  std::optional<double> largest;
  for (const ReferenceUse& use : circumstances.references) {
    if (use.reference.kind != kind) continue;
    const double u = std::hypot(use.reference.standard_uncertainty, use.reference.correction.value_or(0.0));
    largest = std::max(largest.value_or(0.0), u);
  }
  return largest;
}

/// As good as the readings of a kind are known in the worst of the campaigns that have a reference of it.
CertifiedReading worst_reading(const Circumstances& circumstances, ReferenceKind kind) {
  CertifiedReading worst;
  std::vector<std::string> campaigns = circumstances.campaigns;
  if (campaigns.empty()) campaigns.emplace_back();
  for (const std::string& campaign : campaigns) {
    const CertifiedReading reading = certified_reading(circumstances.references, kind, campaign);
    if (reading.standard_uncertainty.value_or(-1.0) > worst.standard_uncertainty.value_or(-1.0)) worst = reading;
  }
  return worst;
}

std::string how_corrected(const CertifiedReading& reading) {
  if (reading.undecided) return "not corrected, as the references differ: their corrections count";
  return reading.correction == 0.0 ? "references" : "corrected by the references";
}

std::string missing_reference(std::string_view kind, std::string_view what) {
  return fmt::format("not stated: no {} in the register of references ('soak reference add --kind {}')", what, kind);
}

TypeBInput thermometer_input(const Circumstances& circumstances) {
  const auto& lsb = circumstances.thermometer_lsb_c;
  const auto& repeatability = circumstances.thermometer_repeatability_c;
  TypeBInput input{.name = "thermometer", .stated = lsb || repeatability};
  if (!input.stated) {
    input.basis = "not stated: the unit's type names neither 'repeatability_c' nor 'lsb_c' of its thermometers";
    return input;
  }
  // A step of the output is a rectangular distribution.
  const double step_c = lsb.value_or(0.0) / std::sqrt(12.0);
  input.temperature_c = std::hypot(step_c, repeatability.value_or(0.0));
  input.basis = fmt::format("{:.2g} K ({}) times the slope of the curve", input.temperature_c,
                            repeatability && lsb ? "repeatability and output step of the unit's type"
                            : repeatability      ? "repeatability of the unit's type"
                                                 : "output step alone: the unit's type states no 'repeatability_c'");
  return input;
}

TypeBInput fixture_not_stated() {
  return {.name = "fixture",
          .stated = false,
          .basis = missing_reference("fixture_squareness", "squareness of the fixture")};
}

std::string of_faces(double u_rad, std::string_view what) {
  return fmt::format("faces of the fixture, and its level where that is stated, known to {:.2g}° (references): {}",
                     u_rad * base::kDegPerRad, what);
}

/// Of attitudes that are known from the readings alone.
TypeBInput no_fixture() {
  return {.name = "fixture", .basis = "none: no direction but that of gravity itself was used"};
}

TypeBInput gravity_in_bias(const Circumstances& circumstances, Sensor sensor, bool turned) {
  TypeBInput input{.name = "gravity"};
  if (circumstances.found_attitudes && !is_gyro(sensor)) {
    input.basis = "none: another gravity changes the scale alone";
  } else if (is_gyro(sensor)) {
    input.basis = "none: gravity affects gyros only through their g-sensitivity";
  } else if (turned) {
    input.basis = "none: cancels between up and down";
  } else if (!circumstances.positions) {
    input.basis = "none: the curve has no level of its own";
  } else if (const auto& u = circumstances.gravity.standard_uncertainty_mps2) {
    input.constant = *u;
    input.basis = circumstances.gravity.basis + "; the axis was not turned both up and down";
  } else {
    input.stated = false;
    input.basis = circumstances.gravity.basis;
  }
  return input;
}

TypeBInput fixture_in_bias(const Circumstances& circumstances, Sensor sensor, bool turned, double cross_sensitivity) {
  if (circumstances.found_attitudes) return no_fixture();
  if (!circumstances.positions) {
    return {.name = "fixture",
            .stated = false,
            .basis = "not stated: in one attitude the Earth's rotation and g-sensitivity stay in the bias"};
  }
  const auto u_rad = attitude_uncertainty_rad(circumstances);
  if (!u_rad) return fixture_not_stated();
  const double g = circumstances.gravity.mps2;
  TypeBInput input{.name = "fixture"};
  const double pair = turned ? std::numbers::sqrt2 : 1.0;
  if (is_gyro(sensor)) {
    input.constant = std::hypot(horizontal_earth_rate_rps(circumstances), g * cross_sensitivity) * *u_rad / pair;
    input.basis =
        of_faces(*u_rad, "the part of the Earth's rotation and of g-sensitivity that a tilt adds to the axis");
  } else {
    input.constant = turned ? g * *u_rad * *u_rad / pair : g * *u_rad;
    input.basis = of_faces(*u_rad, turned ? "second order along gravity" : "first order across gravity");
  }
  return input;
}

TypeBInput gravity_in_scale(const Circumstances& circumstances, Sensor sensor) {
  TypeBInput input{.name = "gravity"};
  if (is_gyro(sensor)) {
    input.basis = "none: the scale of gyros comes from rates";
    return input;
  }
  input.basis = circumstances.gravity.basis;
  input.stated = circumstances.gravity.standard_uncertainty_mps2.has_value();
  if (input.stated)
    input.constant = kPpmPerOne * *circumstances.gravity.standard_uncertainty_mps2 / circumstances.gravity.mps2;
  return input;
}

TypeBInput fixture_in_scale(const Circumstances& circumstances, Sensor sensor) {
  if (is_gyro(sensor) && circumstances.turned_by_hand) {
    return {.name = "fixture", .basis = "none: included in the scatter of the turns by hand"};
  }
  if (!is_gyro(sensor) && circumstances.found_attitudes) return no_fixture();
  if (is_gyro(sensor)) {
    const CertifiedReading rate = worst_reading(circumstances, ReferenceKind::rate);
    if (!rate.standard_uncertainty)
      return {.name = "fixture", .stated = false, .basis = missing_reference("rate", "rate of the fixture")};
    return {.name = "fixture",
            .constant = *rate.standard_uncertainty,
            .basis = fmt::format("rate of the fixture ({})", how_corrected(rate))};
  }
  const auto u_rad = attitude_uncertainty_rad(circumstances);
  if (!u_rad) return fixture_not_stated();
  return {.name = "fixture",
          .constant = kPpmPerOne * *u_rad * *u_rad * std::sqrt(1.5),
          .basis = of_faces(*u_rad, "second order along gravity")};
}

// Type B of what is constant over the runs.

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
void complete_value(StatedValue& value, const std::optional<double>& type_b, std::size_t runs) {
  value.type_b = value.by_choice ? 0.0 : type_b;
  if (value.by_choice) return;
  std::vector<Contribution> budget = {{.name = "readings", .u = {value.standard_error}}};
  if (value.freedoms > 0.0) budget[0].degrees_of_freedom = value.freedoms;
  if (runs > 1) budget[0].degrees_of_freedom = static_cast<double>(runs) - 1.0;
  if (type_b) budget.push_back({.name = "type_b", .type = 'B', .u = {*type_b}});
  value.ci95 = expanded_uncertainty(budget, Band::mean, 0);
}

/// What the faces' tilts make of the level error that was subtracted, the worse of its angles; 0 where none was.
double faces_in_level_rad(const Circumstances& circumstances, const LevelStatement& level) {
  if (!level.to_north_east) return 0.0;
  return face_uncertainty_rad(circumstances).value_or(0.0) * std::ranges::max(level.per_face_tilt);
}

/// Standard uncertainty of the level error by the register, rad; 0 where it was estimated in every run and subtracted.
/// It is common to all positions, so that no mean over them lessens it.
double level_uncertainty_rad(const Circumstances& circumstances, const LevelStatement& level) {
  if (level.in_every_run) return 0.0;
  return reference_uncertainty(circumstances, ReferenceKind::level).value_or(0.0);
}

/// Misalignment: half the difference of the tilts of two opposite faces about one axis; of the level error between
/// nothing (an axis of the same heading with the other one up and down) and all of it (opposite headings, as a half
/// turn about a horizontal axis leaves them); and at most the whole error of a level error that was subtracted.
void state_misalignment(const Circumstances& circumstances, const LevelStatement& level, Coupling& coupling) {
  auto type_b = face_uncertainty_rad(circumstances);
  if (type_b) {
    *type_b = std::hypot(*type_b / std::numbers::sqrt2, level_uncertainty_rad(circumstances, level),
                         faces_in_level_rad(circumstances, level));
  }
  if (circumstances.found_attitudes) type_b = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) complete_value(coupling[i][j], type_b, circumstances.runs);
    }
  }
}

/// Even-order term, 1/(m/s²). The four horizontal faces lean to one side by u/√4 on average. Of the level error an axis
/// has all of it in the mean of two opposite faces, if their headings are the same, and the two pairs have headings of
/// their own: u/√2, root mean square over the angle between them.
std::optional<double> even_order_type_b(const Circumstances& circumstances, const LevelStatement& level) {
  const auto faces = face_uncertainty_rad(circumstances);
  if (!faces) return std::nullopt;
  const double lean = std::hypot(*faces / 2.0, level_uncertainty_rad(circumstances, level) / std::numbers::sqrt2,
                                 faces_in_level_rad(circumstances, level));
  return lean / circumstances.gravity.mps2;
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

/// Misalignment of the gyros, against the axes that the accelerometers' calibration defines: known positions make those
/// the fixture's.
void state_gyro_misalignment(const Circumstances& circumstances, Coupling& coupling) {
  auto type_b = attitude_uncertainty_rad(circumstances);
  if (type_b) *type_b /= std::numbers::sqrt2;
  if (circumstances.found_attitudes) type_b = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) complete_value(coupling[i][j], type_b, circumstances.runs);
    }
  }
}

/// g-sensitivity, in (rad/s)/(m/s²).
void state_g_sensitivity(const Circumstances& circumstances, EarthRemoval removed, Coupling& coupling) {
  const double g = circumstances.gravity.mps2;
  auto across = earth_off_axis_rps(circumstances, removed);
  if (across) *across /= g;
  const double along = earth_on_axis_rps(circumstances) / g;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) complete_value(coupling[i][j], i == j ? along : across, circumstances.runs);
  }
}

/// Level error: what the faces' own tilts do to it.
void state_level(const Circumstances& circumstances, LevelStatement& level) {
  if (!level.to_north_east) return;
  const auto u_rad = face_uncertainty_rad(circumstances);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto type_b = u_rad ? std::optional(*u_rad * level.per_face_tilt[k]) : std::nullopt;
    complete_value((*level.to_north_east)[k], type_b, circumstances.runs);
  }
}

// Expanded uncertainty.

constexpr double kManyFreedoms = 1e6;
/// Scatter of this many degrees of freedom is known well enough for those of a sum to be computed from it.
constexpr double kFreedomsForSum = 3.0;

double squared_t(double degrees_of_freedom) {
  return std::pow(base::student_t_two_sided(0.95, std::clamp(degrees_of_freedom, 1.0, kManyFreedoms)), 2);
}

/// Degrees of freedom of a type B part say how far its number is to be relied on, those of type A how it scatters.
bool has_factor_of_its_own(const Contribution& part) {
  return part.type == 'A' && part.degrees_of_freedom && *part.degrees_of_freedom < kFreedomsForSum;
}

/// How far the factor of a part of few degrees of freedom counts, by its share of the whole variance: hardly where it
/// is small beside what is known, for then it cannot matter by how much it is underestimated. The slope and the power
/// hold the coverage within the limits that the header states.
double weight_of_own_factor(double variance, double degrees_of_freedom, double all) {
  if (variance <= 0.0) return 0.0;
  const double share = variance / (variance + std::max(1.0, degrees_of_freedom) / 6.0 * (all - variance));
  return std::pow(share, 4);
}

/// Parts whose variances add, with effective degrees of freedom.
struct SumOfParts {
  double variance = 0.0;
  double denominator = 0.0;  ///< Σ u_i⁴/ν_i

  void add(double squared, const std::optional<double>& degrees) {
    variance += squared;
    if (degrees) denominator += squared * squared / std::max(1.0, *degrees);
  }
  /// ν_eff = u_c⁴ / Σ u_i⁴/ν_i, too many to matter where no part is estimated.
  [[nodiscard]] double degrees_of_freedom() const {
    constexpr double kRounding = 1e-9;
    return denominator > 0.0 ? std::floor(variance * variance / denominator * (1.0 + kRounding)) : kManyFreedoms;
  }
};

}  // namespace

double expanded_uncertainty(const std::vector<Contribution>& budget, Band band, std::size_t i) {
  SumOfParts rest;
  SumOfParts all;
  for (const Contribution& part : budget) {
    const std::vector<double>& u = band == Band::mean ? part.u : part.u_fresh;
    if (u.empty()) continue;
    all.add(u[i] * u[i], part.degrees_of_freedom);
    if (!has_factor_of_its_own(part)) rest.add(u[i] * u[i], part.degrees_of_freedom);
  }
  if (all.variance <= 0.0) return 0.0;
  const double of_rest = squared_t(rest.degrees_of_freedom());
  double factor = of_rest;
  for (const Contribution& part : budget) {
    const std::vector<double>& u = band == Band::mean ? part.u : part.u_fresh;
    if (u.empty() || !has_factor_of_its_own(part)) continue;
    const double more = std::max(0.0, squared_t(*part.degrees_of_freedom) - of_rest);
    factor += more * weight_of_own_factor(u[i] * u[i], *part.degrees_of_freedom, all.variance);
  }
  return std::sqrt(all.variance * factor);
}

std::optional<double> face_uncertainty_rad(const Circumstances& circumstances) {
  return reference_uncertainty(circumstances, ReferenceKind::fixture_squareness);
}

double horizontal_earth_rate_rps(const Circumstances& circumstances) {
  if (!circumstances.latitude_deg) return base::kEarthRate_rps;
  return base::kEarthRate_rps * std::abs(std::cos(*circumstances.latitude_deg * base::kRadPerDeg));
}

std::optional<double> attitude_uncertainty_rad(const Circumstances& circumstances) {
  const auto faces = face_uncertainty_rad(circumstances);
  if (!faces) return std::nullopt;
  return std::hypot(*faces, reference_uncertainty(circumstances, ReferenceKind::level).value_or(0.0));
}

std::vector<TypeBInput> bias_inputs(const Circumstances& circumstances, Sensor sensor, bool turned,
                                    double cross_g_sensitivity) {
  return {thermometer_input(circumstances), gravity_in_bias(circumstances, sensor, turned),
          fixture_in_bias(circumstances, sensor, turned, cross_g_sensitivity)};
}

std::vector<TypeBInput> scale_inputs(const Circumstances& circumstances, Sensor sensor) {
  return {thermometer_input(circumstances), gravity_in_scale(circumstances, sensor),
          fixture_in_scale(circumstances, sensor)};
}

std::optional<TypeBInput> supply_input(const Circumstances& circumstances, const std::vector<ModelTerm>& terms,
                                       Sensor sensor) {
  double per_v = 0.0;
  bool acts = false;
  for (const ModelTerm& term : terms) {
    const TermPart* part = term.name == "supply_sensitivity" ? term.part_of(sensor) : nullptr;
    if (part == nullptr) continue;
    acts = true;
    per_v += part->value("per_v").value_or(0.0);
  }
  if (!acts) return std::nullopt;
  const CertifiedReading supply = worst_reading(circumstances, ReferenceKind::supply);
  if (!supply.standard_uncertainty)
    return TypeBInput{
        .name = "supply", .stated = false, .basis = missing_reference("supply", "voltage of the units' supply")};
  return TypeBInput{.name = "supply",
                    .constant = std::abs(per_v) * *supply.standard_uncertainty,
                    .basis = fmt::format("{:.2g} V of the supply's voltage ({}) times the sensitivity to it",
                                         *supply.standard_uncertainty, how_corrected(supply))};
}

void state_type_b(Circumstances circumstances, UnitRows& rows) {
  circumstances.gravity = with_reference_uncertainty(rows.gravity, circumstances.references);
  rows.gravity = circumstances.gravity;
  if (rows.accel_misalignment) state_misalignment(circumstances, rows.level, *rows.accel_misalignment);
  if (rows.gyro_misalignment) state_gyro_misalignment(circumstances, *rows.gyro_misalignment);
  if (rows.g_sensitivity) state_g_sensitivity(circumstances, rows.earth_removed, *rows.g_sensitivity);
  state_level(circumstances, rows.level);
  const auto lean = even_order_type_b(circumstances, rows.level);
  for (auto& even_order : rows.even_order) {
    if (even_order) complete_value(*even_order, lean, circumstances.runs);
  }
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    rows.bias_type_b[s] = bias_inputs(circumstances, sensor, circumstances.turned[axis_of(sensor)],
                                      cross_sensitivity(circumstances, rows, sensor));
    if (auto supply = supply_input(circumstances, rows.terms, sensor)) {
      rows.bias_type_b[s].push_back(*std::move(supply));
    }
    rows.scale_type_b[s] = scale_inputs(circumstances, sensor);
  }
}

}  // namespace soak::calib
