// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/estimate/curve_data.h"
#include "calib/estimate/model_term.h"
#include "calib/estimate/site.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// One line of the uncertainty budget of a curve (JCGM 100:2008, 8): standard uncertainties at each of its points, in
/// its unit. Contributions count as independent.
struct Contribution {
  /// "noise", "run_to_run", "hysteresis", "thermometer", "gravity", "fixture", "model"; "supply" and "narrow_bump"
  /// where the model has a term of that
  std::string name = {};
  char type = 'A';  ///< 'A': from the scatter of these runs; 'B': from elsewhere
  std::optional<double> degrees_of_freedom = std::nullopt;  ///< absent = infinite
  std::vector<double> u = {};        ///< of the mean curve (ci95); empty = not part of it, or not stated
  std::vector<double> u_fresh = {};  ///< of one fresh power-on (pi95); empty = not part of it, or not stated
  std::string basis = {};            ///< where the number comes from, or what is missing to state it

  /// False: nobody has said how large it is, and the bands leave it out.
  [[nodiscard]] bool stated() const { return !u.empty() || !u_fresh.empty(); }
};

/// Which band a contribution goes into.
enum class Band { mean, fresh_power_on };

/// Half-width at point i of the 95 % interval of the sum of contributions: two-sided t at effective degrees of freedom
/// (Welch-Satterthwaite, JCGM 100:2008 G.4, truncated to a whole number as in its H.1: interpolated ones, of few runs
/// beside a type B part half as large, hold the truth in 93.6 %) times the root of the sum of squares. Each point lies
/// in all the vectors that are not empty.
///
/// A part of type A with fewer than three degrees of freedom counts by itself: effective degrees of freedom are
/// computed from variances that are estimated, and where so few squares came out small, they are far too many (beside a
/// known part they hold 87 % at worst of one degree, 92 % of two, 94 % of three). With t_r of all other parts and the
/// part's share a_i = u_i²/(u_i² + ν_i/6 (u² − u_i²)),
///
///     U² = u² (t_r² + Σ (t_i² − t_r²) a_i⁴),  u² = Σ u_j²
///
/// which is t_i² u_i² where that part is alone and t_r² u² where it is small. By simulation over all shares, U holds
/// 94.5 to 96.9 % of one degree of freedom beside a known part, 94.6 to 95.6 % of two, and never less beside parts that
/// are estimated themselves (up to 97.5 % beside ten degrees, 98.5 % beside three).
[[nodiscard]] double expanded_uncertainty(const std::vector<Contribution>& budget, Band band, std::size_t i);

/// What is known of the circumstances under which a sensor was measured, beyond its readings.
struct Circumstances {
  Gravity gravity;
  std::optional<double> latitude_deg;
  std::optional<double> thermometer_repeatability_c;  ///< UnitType
  std::optional<double> thermometer_lsb_c;
  std::vector<ReferenceUse> references;
  std::vector<std::string> campaigns;  ///< of the runs
  bool positions = true;               ///< false: one attitude throughout
  bool found_attitudes = false;        ///< attitudes are known from the readings alone: no fixture, and no tilt of it
  bool turned_by_hand = false;         ///< the gyros' scale is of movements between rests, in some run
  std::array<bool, 3> turned{};        ///< whether in every run the axis pointed up and down at rest
  std::size_t runs = 0;
};

/// Standard uncertainty of the fixture's faces about each axis, rad. Absent where the register has no squareness.
[[nodiscard]] std::optional<double> face_uncertainty_rad(const Circumstances& circumstances);

/// Standard uncertainty of the direction of gravity in the unit's frame, rad: faces of the fixture and its level, each
/// about two axes. A correction of the level has no heading, so that nothing can apply it: it counts as uncertainty.
/// Absent where the register has no squareness.
[[nodiscard]] std::optional<double> attitude_uncertainty_rad(const Circumstances& circumstances);

/// Rotation of the Earth across the vertical, rad/s; all of it where nobody knows the latitude.
[[nodiscard]] double horizontal_earth_rate_rps(const Circumstances& circumstances);

/// Thermometer, gravity and fixture, in this order, for the bias curve of a sensor in SI.
///
/// With the axis' own up/down pair, bias = (up + down)/2: gravity cancels, and tilts ε of the two faces enter an
/// accelerometer by g(cos ε₊ − cos ε₋)/2, of standard deviation g u²/√2, a gyro by the part of the Earth's rotation and
/// of the cross g-sensitivity that they turn into its axis, Ω cos φ u/√2 and g |G⊥| u/√2. `turned`: the pair exists.
/// `cross_g_sensitivity`: |G⊥| in (rad/s)/(m/s²) without the Earth's rotation, 0 for accelerometers.
[[nodiscard]] std::vector<TypeBInput> bias_inputs(const Circumstances& circumstances, Sensor sensor, bool turned,
                                                  double cross_g_sensitivity);

/// The same for the scale curve in ppm. Accelerometer: u(g)/g, and (cos ε₊ + cos ε₋)/2 − 1, of root mean square
/// u²√(3/2). Gyro: the rate of the fixture, the largest uncertainty of the campaigns.
[[nodiscard]] std::vector<TypeBInput> scale_inputs(const Circumstances& circumstances, Sensor sensor);

/// What the voltmeter adds to the bias of a sensor that follows the supply: the curve is that at the term's
/// `reference_v`, known to u(V), so it is off by |per_v| u(V). Absent where no term of the supply acts on the sensor.
[[nodiscard]] std::optional<TypeBInput> supply_input(const Circumstances& circumstances,
                                                     const std::vector<ModelTerm>& terms, Sensor sensor);

struct UnitRows;

/// Adds to the rows what readings do not show of their errors: the type B inputs of each sensor's curves, and those of
/// misalignment, g-sensitivity and even-order terms with the resulting 95 % half-widths. The gravity of `circumstances`
/// is that of the rows, with the uncertainty of the register where that names the same number.
void state_type_b(Circumstances circumstances, UnitRows& rows);

}  // namespace soak::calib
