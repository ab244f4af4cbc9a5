// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/type_b_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/units.h"

namespace soak::calib {
namespace {

constexpr double kPpm = 1e6;

/// The largest standard uncertainty of the references of a kind: a unit's runs may have seen several. A correction that
/// nobody applies is part of it.
std::optional<double> uncertainty_of(const Circumstances& circumstances, ReferenceKind kind) {
  std::optional<double> largest;
  for (const ReferenceUse& use : circumstances.references) {
    if (use.reference.kind != kind) continue;
    const double u = std::hypot(use.reference.standard_uncertainty, use.reference.correction.value_or(0.0));
    largest = std::max(largest.value_or(0.0), u);
  }
  return largest;
}

std::string missing(std::string_view kind, std::string_view what) {
  return fmt::format("not stated: no {} in the register of references ('soak reference add --kind {}')", what, kind);
}

TypeBInput thermometer(const Circumstances& circumstances) {
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

TypeBInput not_stated_fixture() {
  return {.name = "fixture", .stated = false, .basis = missing("fixture_squareness", "squareness of the fixture")};
}

std::string of_faces(double u_rad, std::string_view what) {
  return fmt::format("faces of the fixture, and its level where that is stated, known to {:.2g}° (references): {}",
                     u_rad * base::kDegPerRad, what);
}

TypeBInput gravity_in_bias(const Circumstances& circumstances, Sensor sensor, bool turned) {
  TypeBInput input{.name = "gravity"};
  if (is_gyro(sensor)) {
    input.basis = "none: gyros do not read gravity but by their g-sensitivity";
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
  if (!circumstances.positions) {
    return {.name = "fixture",
            .stated = false,
            .basis = "not stated: in one attitude the Earth's rotation and g-sensitivity stay in the bias"};
  }
  const auto u_rad = attitude_uncertainty_rad(circumstances);
  if (!u_rad) return not_stated_fixture();
  const double g = circumstances.gravity.mps2;
  TypeBInput input{.name = "fixture"};
  const double pair = turned ? std::numbers::sqrt2 : 1.0;
  if (is_gyro(sensor)) {
    input.constant = std::hypot(horizontal_earth_rate_rps(circumstances), g * cross_sensitivity) * *u_rad / pair;
    input.basis = of_faces(*u_rad, "what tilts turn into the axis of the Earth's rotation and of g-sensitivity");
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
    input.constant = kPpm * *circumstances.gravity.standard_uncertainty_mps2 / circumstances.gravity.mps2;
  return input;
}

TypeBInput fixture_in_scale(const Circumstances& circumstances, Sensor sensor) {
  if (is_gyro(sensor)) {
    const auto rate_ppm = uncertainty_of(circumstances, ReferenceKind::rate);
    if (!rate_ppm) return {.name = "fixture", .stated = false, .basis = missing("rate", "rate of the fixture")};
    return {.name = "fixture", .constant = *rate_ppm, .basis = "rate of the fixture (references)"};
  }
  const auto u_rad = attitude_uncertainty_rad(circumstances);
  if (!u_rad) return not_stated_fixture();
  return {.name = "fixture",
          .constant = kPpm * *u_rad * *u_rad * std::sqrt(1.5),
          .basis = of_faces(*u_rad, "second order along gravity")};
}

}  // namespace

std::optional<double> face_uncertainty_rad(const Circumstances& circumstances) {
  return uncertainty_of(circumstances, ReferenceKind::fixture_squareness);
}

double horizontal_earth_rate_rps(const Circumstances& circumstances) {
  if (!circumstances.latitude_deg) return base::kEarthRate_rps;
  return base::kEarthRate_rps * std::abs(std::cos(*circumstances.latitude_deg * base::kRadPerDeg));
}

std::optional<double> attitude_uncertainty_rad(const Circumstances& circumstances) {
  const auto faces = face_uncertainty_rad(circumstances);
  if (!faces) return std::nullopt;
  return std::hypot(*faces, uncertainty_of(circumstances, ReferenceKind::level).value_or(0.0));
}

std::vector<TypeBInput> bias_inputs(const Circumstances& circumstances, Sensor sensor, bool turned,
                                    double cross_g_sensitivity) {
  return {thermometer(circumstances), gravity_in_bias(circumstances, sensor, turned),
          fixture_in_bias(circumstances, sensor, turned, cross_g_sensitivity)};
}

std::vector<TypeBInput> scale_inputs(const Circumstances& circumstances, Sensor sensor) {
  return {thermometer(circumstances), gravity_in_scale(circumstances, sensor), fixture_in_scale(circumstances, sensor)};
}

}  // namespace soak::calib
