// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/estimate/model_term.h"
#include "calib/gap/observations/observations.h"
#include "calib/gap/observations/temperature_history.h"

namespace soak::calib::gap {

/// What runs must agree on for a term to be believed: most effects are the same in each run; one that is drawn anew
/// with every mounting must agree between the plateaus instead.
enum class Folds { runs, levels };

/// One shape of a term: its regressors in every sensor that it can act on. Sensors have parameters of their own, or,
/// where `shared`, one set for all.
struct Candidate {
  std::string shape = {};                 ///< "tau 120 s", "" where the effect has one shape only
  std::vector<double> shape_values = {};  ///< the numbers in `shape`
  bool shared = false;
  Folds folds = Folds::runs;
  std::array<Eigen::MatrixXd, kSensorCount> columns = {};  ///< one row per observation; empty = does not act on it
  /// On ramps: the column is the kelvins by which the curve is read elsewhere, not a regressor.
  bool shifts = false;
};

/// What the parameters of a candidate say whatever the campaign: how `gap accept` keeps them.
struct Meaning {
  struct Estimated {
    std::string name;
    std::string unit;
    double per_parameter = 1.0;  ///< value in `unit` = parameter times this
  };
  std::vector<Estimated> estimated;  ///< in the order of the columns
  std::vector<TermParameter> given;  ///< numbers of the shape, and the point that others are relative to
};

/// How an effect shows in a recording in one attitude without plateaus (ramps/), where every block follows the
/// temperature history.
struct OnRamps {
  /// How its magnitude is read off the parameters of a candidate: the first, the most that it adds anywhere, or the
  /// number in its shape, seconds.
  enum class Size { first, largest, time_constant };
  std::vector<Candidate> candidates = {};
  std::string_view per = {};  ///< what follows the printed unit in its magnitude, "/V"
  Size size = Size::first;
  /// What the parameters of a candidate say. Good as long as the observations are.
  std::function<Meaning(const Candidate&, Sensor)> meaning = {};
};

/// All that an effect may look at to make its regressors.
struct RegressorInputs {
  const Observations& observations;
  const TemperatureHistory& history;
  /// Slope of the present model against temperature at each observation, SI per kelvin: what a wrong temperature costs.
  /// Empty for a sensor without readings.
  const std::array<Eigen::VectorXd, kSensorCount>& slope;
  /// What a sensor with readings would read beyond the present model, had its base always been one of these
  /// temperatures (one per observation) and been fitted as such, SI. Absent where nothing was read: then the slope is
  /// all that is known.
  std::function<Eigen::VectorXd(Sensor, const std::vector<double>& temp_c)> read_at = {};
};

/// Size of an effect as the design page names it.
struct Magnitude {
  double value = 0.0;
  std::string unit;
};

/// An entry of the library: a mechanism with its physics, its regressors, what it can be confused with, and the
/// experiment that would tell. The list grows by adding one file.
struct Effect {
  std::string_view name = {};
  std::string_view physics = {};
  std::vector<std::string_view> twins = {};
  std::string_view experiment = {};  ///< what tells it from its twins
  /// Why this campaign cannot show the effect; nothing where it can.
  std::function<std::optional<std::string>(const RegressorInputs&)> missing = {};
  std::function<std::vector<Candidate>(const RegressorInputs&)> candidates = {};
  /// The candidates of one value of the shape, for a value between those of the grid; absent = there is no such number.
  std::function<std::vector<Candidate>(const RegressorInputs&, double shape_value)> of_shape = {};
  /// Whether a mechanism of this kind can have such parameters (of one sensor, of all where shared) with that
  /// covariance; absent = any.
  std::function<bool(const RegressorInputs&, const Candidate&, const Eigen::VectorXd& parameters,
                     const Eigen::MatrixXd& covariance)>
      plausible = {};
  /// From the parameters of one sensor (of all, where shared), SI.
  std::function<Magnitude(const RegressorInputs&, const Candidate&, Sensor, const Eigen::VectorXd& parameters)>
      magnitude = {};
  /// Of the parameters of one sensor (of all, where shared).
  std::function<Meaning(const RegressorInputs&, const Candidate&, Sensor)> meaning = {};
  /// Its candidates on ramps, none where its channel was not recorded; absent = it needs positions, plateaus or runs.
  std::function<OnRamps(const Observations&, const TemperatureHistory&)> on_ramps = {};
  /// Whether its regressors follow the history of temperature or time by a shape that the mechanism need not have: then
  /// a small share that a twin takes beside it means that it is neither.
  bool follows_history = false;
  bool lab_only = true;  ///< cannot be evaluated from the course of the unit's own temperature
};

/// Version of the library: rises when what an effect's name or parameters mean changes.
inline constexpr std::string_view kLibraryVersion = "2";

/// The effects that show in the mean of blocks, in the order of design.
[[nodiscard]] const std::vector<Effect>& library();

/// Whether one of the two names the other as its twin.
[[nodiscard]] bool are_twins(const Effect& a, const Effect& b);

}  // namespace soak::calib::gap
