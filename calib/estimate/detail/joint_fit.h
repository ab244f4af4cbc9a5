// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/estimate/site.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"

/// The weighted fit of one sensor over all segments of a run (joint_fit.cpp), and that of the level error over three
/// accelerometers (level_fit.cpp). six_position.h has the model.
namespace soak::calib::six_position {

inline constexpr double kOnAxis = 0.999;  ///< |up_i| from which axis i counts as vertical

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

/// One segment as a row of the joint fit of one sensor.
struct Row {
  std::size_t visit = 0;  ///< index into Problem::visits
  double mean = 0.0;      ///< reading
  double weight = 0.0;
  double temp_c = 0.0;
  double tau = 0.0;       ///< time from the middle of the visit in units of the longest half visit of the run
  double rate_rps = 0.0;  ///< of the fixture along the sensor's axis
  bool turning = false;
  std::string label;
  std::optional<Position> position;

  // Under a tilt (pose()):
  double value = 0.0;  ///< the mean less gravity, the Earth's rotation and the fixture's
  Vector3 up{};
  Vector3 north{};  ///< zero where the headings are not known
  Vector3 east{};
  double scale_input =
      0.0;  ///< what the scale error multiplies: specific force in g, rate in the reference rate; signed
};

/// The joint fit of one sensor in one run.
struct Problem {
  Sensor sensor = Sensor::gyro_x;
  double gravity_mps2 = 0.0;  ///< as the sensor reads it: with its sign at rest
  EarthRate earth;
  std::optional<double> azimuth_deg;  ///< of the fixture; absent where not all headings are known
  double reference_rate_rps = 0.0;    ///< largest rate about the gyro's axis; 0 where nothing turns
  /// Median standard error of the segments. 0: none is known, the weights are relative and only the residuals say how
  /// far the estimates can be trusted.
  double typical_se = 0.0;
  bool with_position = false;
  std::vector<Row> rows;
  std::vector<VisitInfo> visits;

  // Unknowns that the positions show (pose()):
  std::vector<std::string> nuisance;  ///< labels with their own constant (gyros)
  bool with_coupling = false;         ///< g-sensitivity along the axis is among the shared unknowns (gyros)
  bool with_even = false;             ///< an even-order term is among the shared unknowns (accelerometers)
  bool with_contrast = false;         ///< as is the contrast of the horizontal faces (accelerometers)
  bool with_level = false;            ///< as are two tilts of the vertical, in units of g (accelerometers)
};

/// The rows of a sensor. Segments in which the fixture turns enter for the gyro along the axis of rotation alone, and
/// there where the visit has another rate to tell scale error from bias.
[[nodiscard]] Problem rows_of(std::span<const Segment> segments, Sensor sensor, const Place& place,
                              const UnitType& type);

/// Poses the fit of these rows under a tilt of the vertical against the positions' up vectors.
[[nodiscard]] Problem pose(Problem problem, const Tilt& tilt);

/// Reading per unit of scale error and of scale_input: m/s² or rad/s.
[[nodiscard]] inline double scale_unit(const Problem& problem) {
  return is_gyro(problem.sensor) ? problem.reference_rate_rps : problem.gravity_mps2;
}

/// Unknowns of one visit, in this order.
enum Local : int { kBias, kDrift, kScale, kLocalCount };

using LocalVector = Eigen::Matrix<double, kLocalCount, 1>;

/// Degrees of freedom of variances that a wander is part of, which is estimated; of the shared unknowns the least.
struct WanderFreedoms {
  double bias = 0.0;
  double scale = 0.0;
  double shared = 0.0;
};

/// What the joint fit says; variances are those of noise as large as the rows' weights say.
struct Solution {
  std::vector<LocalVector> local;
  std::vector<LocalVector> local_variance;  ///< diagonal of the covariance
  std::vector<bool> bias_known;
  std::vector<bool> scale_known;
  Eigen::VectorXd shared;
  Eigen::MatrixXd shared_covariance;
  Eigen::MatrixXd open;         ///< one column per direction of `shared` that the segments do not show
  double drift_variance = 0.0;  ///< of the visits' drifts, estimated
  double wander = 0.0;          ///< variance of a gyro's random walk over a session of one visit, estimated; 0 = none
  WanderFreedoms wander_freedoms;
  double reduced_chi_squared = 0.0;
};

/// Index of the even-order term among the shared unknowns, K₂·g².
inline constexpr Eigen::Index kEven = 2;
/// The last unknowns of a problem with_level: tilts of the vertical to north and east, times g.
inline constexpr int kLevelCount = 2;

/// Whether the segments show the combination `weights`·shared.
[[nodiscard]] bool shows(const Solution& solution, const Eigen::VectorXd& weights);

/// Weighted least squares over all segments of the run, each visit's drift a random quantity of zero mean whose
/// variance is estimated from the run (expectation-maximisation). Cost linear in the number of segments.
[[nodiscard]] Solution solve(const Problem& problem);

/// Normal equations of the shared unknowns, those of the visits eliminated: matrix · shared = right.
struct SharedNormal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

/// The shared unknowns' part of the same fit, drifts of that variance; `right` is linear in the rows' values.
[[nodiscard]] SharedNormal shared_normal(const Problem& problem, double drift_variance);

/// What standard errors are multiplied by: residuals larger than the segments' own errors promise inflate them; where
/// those are not known, the residuals alone are the measure.
[[nodiscard]] double inflation_of(const Problem& problem, const Solution& solution);

/// The tilt of the vertical to north and to east, in that order, rad.
struct LevelFit {
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< from the readings
  /// Standard uncertainty per that of the faces, each of them tilted about two axes by its own.
  Eigen::Vector2d per_face_tilt = Eigen::Vector2d::Zero();
};

/// What fit_level() says: the tilt, or why the segments do not show it.
struct LevelAnswer {
  std::optional<LevelFit> fit;
  std::string reason;  ///< empty where there is a fit
};

/// One weighted least squares over all accelerometers of a run: the two tilts in common, every other unknown of the
/// joint fits (bias, scale error and drift of each visit, misalignment, even-order term) each accelerometer's own.
///
/// A body's misalignment turns with the body, the vertical does not: so what a tilt does to the readings changes with
/// the heading. Where the headings allow it (a face at several of them) the contrasts of the horizontal faces are among
/// the unknowns, and no error of a face reaches the tilt. Else they count as 0, since with them the four horizontal
/// readings of an accelerometer have four unknowns of their own; the faces' errors then reach it by `per_face_tilt`.
///
/// Not shown where less than 2 % of what the readings know of some direction is left beside the other unknowns.
[[nodiscard]] LevelAnswer fit_level(std::span<const Problem> accelerometers);

}  // namespace soak::calib::six_position
