// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/estimate/body_frame.h"
#include "calib/vocabulary/segment.h"

namespace soak::calib::six_position {

inline constexpr double kOnAxis = 0.999;  ///< |up_i| from which axis i counts as vertical

/// One segment as a row of the joint fit of one sensor.
struct Row {
  std::size_t visit;  ///< index into Problem::visits
  double value;
  double weight;
  double temp_c;
  double tau;  ///< time from the middle of the visit in units of the longest half visit of the run
  Vector3 up;
  Vector3 north;  ///< zero where the headings are not known
  Vector3 east;
  std::string label;
  double scale_input;  ///< what the scale error multiplies: specific force in g, rate in the reference rate; signed
};

/// A plateau visit of the run.
struct VisitInfo {
  std::int32_t visit = 0;
  Sweep sweep = Sweep::unknown;
  std::optional<double> plateau_c;
  double temp_c = 0.0;
  double t_s = 0.0;
  std::size_t rows = 0;
  bool with_scale = false;
};

/// The joint fit of one sensor in one run, posed.
struct Problem {
  Sensor sensor = Sensor::gyro_x;
  double gravity_mps2 = 0.0;
  double reference_rate_rps = 0.0;  ///< largest rate about the gyro's axis; 0 where nothing turns
  std::vector<Row> rows;
  std::vector<VisitInfo> visits;
  std::vector<std::string> nuisance;  ///< labels with their own constant (gyros)
  bool with_coupling = false;         ///< g-sensitivity along the axis is among the shared unknowns (gyros)
  bool with_even = false;             ///< an even-order term is among the shared unknowns (accelerometers)
  bool with_contrast = false;         ///< as is the contrast of the horizontal faces (accelerometers)
  bool with_level = false;            ///< as are two tilts of the vertical, in units of g (accelerometers)
  bool with_position = false;
  /// Median standard error of the segments. 0: none is known, the weights are relative and only the residuals say how
  /// far the estimates can be trusted.
  double typical_se = 0.0;
};

/// What stays the same for all sensors of a run.
struct Circumstances {
  double gravity_mps2 = 0.0;
  EarthRate earth;
  int sign_at_rest = 1;
  std::optional<double> azimuth_deg = std::nullopt;  ///< of the fixture; absent where not all headings are known
  Tilt tilt{};                                       ///< of the vertical against the positions' up vectors
};

/// Reading per unit of scale error and of scale_input: m/s² or rad/s.
[[nodiscard]] inline double scale_unit(const Problem& problem) {
  return is_gyro(problem.sensor) ? problem.reference_rate_rps : problem.gravity_mps2;
}

/// Poses the fit of one sensor: its rows, visits, and the unknowns that the positions of the run can show. Segments in
/// which the fixture turns enter for the gyro along the axis of rotation alone, and there where the visit has another
/// rate to tell scale error from bias.
[[nodiscard]] Problem pose(std::span<const Segment> segments, Sensor sensor, const Circumstances& circumstances);

}  // namespace soak::calib::six_position
