// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/sensor.h"

/// Campaigns of one unit made up as segment statistics, from physics written down here anew: what the coverage of
/// stated uncertainties is judged by.
namespace soak::calib::simulated {

/// What nature draws once per campaign from the standard uncertainties that the laboratory states, and how the unit
/// scatters. SI.
struct Scatter {
  double face_tilt_rad = 0.1 * std::numbers::pi / 180.0;  ///< each face about each of its two axes
  double face_lean_rad = 0.1 * std::numbers::pi / 180.0;  ///< beside that, known: it stands in the positions
  double level_rad = 0.05 * std::numbers::pi / 180.0;     ///< of the base, about two axes: common to all positions
  double rate_ppm = 50.0;                                 ///< of the corrected rate
  double rate_correction_ppm = -300.0;                    ///< what the certificate has to say
  double supply_v = 0.05;                                 ///< of the corrected voltage
  double gyro_per_v = 0.1 * std::numbers::pi / 180.0;
  double accel_per_v = 0.05;
  double gravity_mps2 = 3e-4;
  double thermometer_c = 0.1;  ///< temperature of the sensing element at a reading, campaign against deployment
  double gyro_run_rps = 0.02 * std::numbers::pi / 180.0;  ///< bias of one power-on
  double gyro_noise_rps = 0.005 * std::numbers::pi / 180.0;
  double gyro_visit_rps = 0.002 * std::numbers::pi / 180.0;  ///< of one plateau visit, all positions alike
  double accel_run_mps2 = 0.01;
  double accel_noise_mps2 = 0.003;
  double accel_visit_mps2 = 0.001;
  /// Half of the gap between heating and cooling in the middle of the range, a lens that closes where the way turns;
  /// one power-on has more of it than another, by a tenth.
  double gyro_half_gap_rps = 0.006 * std::numbers::pi / 180.0;
  double accel_half_gap_mps2 = 0.003;
};

inline constexpr double kGravity_mps2 = 9.81;
inline constexpr double kLatitude_deg = 51.0;
inline constexpr double kEarth_rps = 7.292115e-5;

/// Smooth saturating stress, a thermally activated part and one local feature, of given span over -30..70 °C.
struct ThermalCurve {
  double level = 0.0;
  double scale = 0.0;
  double centre_c = 0.0;
  double width_c = 30.0;
  double activated = 0.0;
  double feature = 0.0;
  double feature_c = 0.0;
  double feature_width_c = 8.0;

  static ThermalCurve draw(base::Random& random, double level, double span, double feature) {
    ThermalCurve curve;
    curve.level = level * (2.0 * random.uniform() - 1.0);
    curve.scale = span / 2.0 * (random.uniform() < 0.5 ? -1.0 : 1.0);
    curve.centre_c = -15.0 + 70.0 * random.uniform();
    curve.width_c = 18.0 + 27.0 * random.uniform();
    curve.activated = span * (random.uniform() - 0.5);
    curve.feature = feature * (random.uniform() < 0.5 ? -1.0 : 1.0);
    curve.feature_c = -20.0 + 80.0 * random.uniform();
    curve.feature_width_c = 6.0 + 3.0 * random.uniform();
    return curve;
  }

  [[nodiscard]] double at(double temp_c) const {
    constexpr double kBoltzmann_ev = 8.617e-5;
    const double hot = 1.0 / (70.0 + 273.15);
    const double arrhenius = std::exp(-0.25 / kBoltzmann_ev * (1.0 / (temp_c + 273.15) - hot));
    const double z = (temp_c - feature_c) / feature_width_c;
    return level + scale * std::atan((temp_c - centre_c) / width_c) + activated * arrhenius +
           feature * std::exp(-0.5 * z * z);
  }
};

/// One gyro and three accelerometers, and the campaign that they are measured in.
struct Truth {
  ThermalCurve gyro_bias;                 ///< rad/s
  ThermalCurve gyro_scale;                ///< ppm
  ThermalCurve accel_bias;                ///< m/s², of each axis
  ThermalCurve accel_scale;               ///< ppm
  Vector3 g_sensitivity{};                ///< (rad/s)/(m/s²)
  std::array<Vector3, 3> misalignment{};  ///< rad, a row per accelerometer; 0 on the own axis

  static Truth draw(base::Random& random) {
    constexpr double kRad = std::numbers::pi / 180.0;
    Truth truth;
    truth.gyro_bias = ThermalCurve::draw(random, 0.3 * kRad, 0.5 * kRad, 0.1 * kRad);
    truth.accel_bias = ThermalCurve::draw(random, 0.15, 0.3, 0.035);
    truth.accel_scale = ThermalCurve::draw(random, 2000.0, 1200.0, 0.0);
    truth.gyro_scale = ThermalCurve::draw(random, 3000.0, 2000.0, 0.0);
    for (std::size_t j = 0; j < 3; ++j) {
      truth.g_sensitivity[j] = 0.02 * kRad / 9.81 * random.gaussian();
      for (std::size_t i = 0; i < 3; ++i) truth.misalignment[i][j] = i == j ? 0.0 : 0.002 * random.gaussian();
    }
    return truth;
  }
};

inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// `v` turned by the small rotation `by`, exactly enough for tilts of a degree: v + by × v + by × (by × v) / 2.
inline Vector3 turned(const Vector3& v, const Vector3& by) {
  const Vector3 once = cross(by, v);
  const Vector3 twice = cross(by, once);
  return {v[0] + once[0] + twice[0] / 2, v[1] + once[1] + twice[1] / 2, v[2] + once[2] + twice[2] / 2};
}

/// Opening of the loop between heating and cooling: 1 in the middle of the range, 0 where the way turns.
inline double lens(double temp_c) {
  const double z = (temp_c - 20.0) / 50.0;
  return std::max(0.0, 1.0 - z * z);
}

/// How a unit really stands on a face of the fixture, and what the laboratory says of it.
struct Face {
  Position position;
  Vector3 up;  ///< true directions in body axes
  Vector3 north;
};

/// The six faces of a fixture whose base leans: opposite faces are a half turn apart about a horizontal axis of the
/// unit, so that the lean of the base shows in full in some misalignments and not at all in others.
inline std::vector<Face> faces_of(const Scatter& scatter, base::Random& random) {
  const double to_north = scatter.level_rad * random.gaussian();
  const double to_east = scatter.level_rad * random.gaussian();
  std::vector<Face> faces;
  Vector3 ahead{};  // of an upper face, and of the lower one after it
  for (const auto name : kSixPositionLabels) {
    Face face;
    face.position = *position_named(name);
    const Vector3 nominal = face.position.up;
    const std::size_t axis = faces.size() / 2;
    if (faces.size() % 2 == 0) {
      const double heading = 2.0 * std::numbers::pi * random.uniform();
      ahead = {};
      ahead[(axis + 1) % 3] = std::cos(heading);
      ahead[(axis + 2) % 3] = std::sin(heading);
    } else {
      ahead[random.uniform() < 0.5 ? (axis + 1) % 3 : (axis + 2) % 3] *= -1.0;
    }
    Vector3 known;
    Vector3 unknown;
    for (double& angle : known) angle = scatter.face_lean_rad * (2.0 * random.uniform() - 1.0);
    for (double& angle : unknown) angle = scatter.face_tilt_rad * random.gaussian();
    const Vector3 right = cross(ahead, nominal);
    Vector3 lean;
    for (std::size_t k = 0; k < 3; ++k) lean[k] = to_north * ahead[k] + to_east * right[k];
    const Vector3 by_level = cross(nominal, lean);
    const auto really = [&](const Vector3& v) { return turned(turned(turned(v, known), unknown), by_level); };
    face.position.up = turned(nominal, known);
    face.up = really(nominal);
    face.north = really(ahead);
    faces.push_back(face);
  }
  return faces;
}

/// A campaign of `runs` runs over -30..70 °C and back in steps of 5 °C: six positions at rest and, with the gyro's axis
/// up, two rates.
inline UnitInput campaign(const Truth& truth, Sensor gyro, int runs, const Scatter& scatter, base::Random& random) {
  constexpr double kRate_dps = 60.0;
  const std::size_t axis = axis_of(gyro);
  const double g = kGravity_mps2 + scatter.gravity_mps2 * random.gaussian();
  const double element_c = scatter.thermometer_c * random.gaussian();
  const double volts = scatter.supply_v * random.gaussian();
  const double rate_factor = 1.0 + 1e-6 * (scatter.rate_correction_ppm + scatter.rate_ppm * random.gaussian());
  constexpr double kRad = std::numbers::pi / 180.0;
  const double vertical = kEarth_rps * std::sin(kLatitude_deg * kRad);
  const double horizontal = kEarth_rps * std::cos(kLatitude_deg * kRad);
  const std::vector<Face> faces = faces_of(scatter, random);
  UnitInput input;
  input.unit = "U";
  for (int r = 0; r < runs; ++r) {
    RunInput run;
    run.run_id = run.label = "R" + std::to_string(r);
    run.site.gravity_mps2 = kGravity_mps2;
    run.site.latitude_deg = kLatitude_deg;
    const double gyro_offset = scatter.gyro_run_rps * random.gaussian();
    const double accel_offset = scatter.accel_run_mps2 * random.gaussian();
    const double gap = 1.0 + 0.1 * random.gaussian();
    double t_s = 0.0;
    for (int visit = 0; visit < 41; ++visit) {
      const double plateau_c = -30.0 + 5.0 * (visit <= 20 ? visit : 40 - visit);
      const double settled_c = plateau_c + 0.2 * (2.0 * random.uniform() - 1.0);
      const double gyro_visit = scatter.gyro_visit_rps * random.gaussian();
      const double accel_visit = scatter.accel_visit_mps2 * random.gaussian();
      const double loop = gap * lens(plateau_c) * (visit <= 20 ? -1.0 : 1.0);
      const auto stand = [&](const Face& face, double rate_dps) {
        Segment s;
        s.key = {run.run_id, "U", visit, face.position.label, 0};
        s.plateau_c = plateau_c;
        s.sweep = visit <= 20 ? Sweep::up : Sweep::down;
        s.position = face.position;
        if (rate_dps != 0.0) s.position->rate_dps = rate_dps;
        if (rate_dps != 0.0) s.key.position = s.position->label = rate_dps > 0.0 ? "left" : "right";
        s.t_start_s = t_s;
        s.t_end_s = t_s += 600.0;
        s.temp_c = settled_c + 0.02 * random.gaussian();
        s.sensor_temp_c.fill(s.temp_c);
        const double there_c = s.temp_c + element_c;
        Vector3 force = face.up;
        for (double& f : force) f *= g;
        // Over whole turns what lies across the vertical cancels.
        const double turning = rate_factor * rate_dps * kRad * face.up[axis];
        const double rate = vertical * face.up[axis] + (rate_dps == 0.0 ? horizontal * face.north[axis] : 0.0);
        const double gyro_mean = truth.gyro_bias.at(there_c) + gyro_offset + gyro_visit +
                                 (1.0 + 1e-6 * truth.gyro_scale.at(there_c)) * turning + rate +
                                 scatter.gyro_per_v * volts + scatter.gyro_half_gap_rps * loop +
                                 dot(truth.g_sensitivity, force) + scatter.gyro_noise_rps * random.gaussian();
        s.sensor[axis] = {600, gyro_mean, 600 * std::pow(scatter.gyro_noise_rps, 2), scatter.gyro_noise_rps};
        for (std::size_t i = 0; rate_dps == 0.0 && i < 3; ++i) {
          const double accel_mean = truth.accel_bias.at(there_c) + accel_offset + accel_visit +
                                    (1.0 + 1e-6 * truth.accel_scale.at(there_c)) * force[i] +
                                    dot(truth.misalignment[i], force) + scatter.accel_per_v * volts +
                                    scatter.accel_half_gap_mps2 * loop + scatter.accel_noise_mps2 * random.gaussian();
          s.sensor[i + 3] = {600, accel_mean, 600 * std::pow(scatter.accel_noise_mps2, 2), scatter.accel_noise_mps2};
        }
        run.segments.push_back(s);
      };
      for (const Face& face : faces) stand(face, 0.0);
      stand(faces[2 * axis], kRate_dps);
      stand(faces[2 * axis], -kRate_dps);
    }
    input.runs.push_back(std::move(run));
  }
  return input;
}

/// What the laboratory states of a campaign: type of the unit, certificates, and a term of the supply.
inline void state(UnitInput& input, const Scatter& scatter) {
  input.type.temp_repeatability_c = scatter.thermometer_c;
  const auto add = [&](ReferenceKind kind, double standard_uncertainty, std::optional<double> correction = {}) {
    ReferenceUse use;
    use.reference.kind = kind;
    use.reference.standard_uncertainty = standard_uncertainty;
    use.reference.correction = correction;
    input.references.push_back(std::move(use));
  };
  add(ReferenceKind::fixture_squareness, scatter.face_tilt_rad);
  add(ReferenceKind::level, scatter.level_rad);
  add(ReferenceKind::gravity, scatter.gravity_mps2, kGravity_mps2);
  add(ReferenceKind::rate, scatter.rate_ppm, scatter.rate_correction_ppm);
  add(ReferenceKind::supply, scatter.supply_v);
  ModelTerm term;
  term.name = "supply_sensitivity";
  for (const Sensor sensor : kSensors) {
    const double per_v = is_gyro(sensor) ? scatter.gyro_per_v : scatter.accel_per_v;
    TermPart part;
    part.sensors = {sensor};
    part.parameters = {{"per_v", per_v, ""}, {"reference_v", 5.0, "V"}};
    term.parts.push_back(std::move(part));
  }
  input.terms = {std::move(term)};
}

}  // namespace soak::calib::simulated
