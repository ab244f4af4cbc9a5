// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/estimate/curve_data.h"
#include "calib/estimate/uncertainty_budget.h"
#include "calib/vocabulary/one_way.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// Model families. The first four compete for a curve; the value is the index wherever four things are listed. A
/// `constant` competes with none: it is all that one temperature gives (constant_fit.h).
enum class Family : std::uint8_t { anfis, poly3, poly5, spline, constant };
inline constexpr std::size_t kFamilyCount = 4;
inline constexpr std::array<std::string_view, kFamilyCount> kFamilyNames = {"anfis", "poly3", "poly5", "spline"};
constexpr std::string_view name_of(Family family) {
  return family == Family::constant ? "constant" : kFamilyNames[static_cast<std::size_t>(family)];
}

struct CurveFitOptions {
  std::optional<int> rules;  ///< number of ANFIS rules; absent = chosen (train_families())
};

/// What a curve is of: for messages.
struct CurveSubject {
  std::string name;               ///< "gyro_x", "accel_z scale"
  std::string printed_unit;       ///< unit that messages use
  double printed_per_unit = 1.0;  ///< from the rows' unit to the printed one
};

/// Root mean square error of each family on rows that it did not see; absent where it could not be fitted.
struct FoldErrors {
  std::string fold;  ///< what was held out: run label, branch name or block
  std::array<std::optional<double>, kFamilyCount> rmse;
};

/// Held-out error of one family: absolute, and with each held-out run's own mean error removed.
struct CrossValidationError {
  double rmse_abs = 0.0;
  double rmse_shape = 0.0;
};

/// Point of the deployed curve.
struct CurvePoint {
  double temp_c = 0.0;
  double value = 0.0;
  double ci95 = 0.0;           ///< half-width (two-sided t) for the mean curve over runs; of one run: its noise only
  std::optional<double> pi95;  ///< half-width for one fresh power-on; absent with fewer than two runs
};

/// Difference between heating and cooling that a curve leaves.
struct SweepGap {
  double largest = 0.0;     ///< largest |up − down| over the temperatures visited both ways
  double at_temp_c = 0.0;   ///< where that is
  double noise = 0.0;       ///< standard error of one such difference
  double half_sigma = 0.0;  ///< half the difference, root mean square over the temperatures, less its noise
  double p_value = 1.0;     ///< of seeing such differences by noise alone (chi-squared)
};

/// Thermal model of one quantity of one sensor, and how far it can be trusted. Units: those of the rows.
struct CurveFit {
  int rules = 0;  ///< of the ANFIS, deployed or not
  int order = 1;
  std::string membership;
  std::string training;  ///< one line: epochs, errors, why training stopped
  std::vector<std::string> runs;
  std::string holdout;             ///< "run", "branch", "block" or "none": what the outer folds leave out
  std::vector<FoldErrors> checks;  ///< one per outer fold, absolute
  double train_rmse = 0.0;         ///< of the ANFIS on all rows, absolute
  /// Outer-fold errors over held-out runs; absent under three runs.
  std::array<std::optional<CrossValidationError>, kFamilyCount> cross_validation;
  std::optional<double> run_to_run_sigma;
  double lack_of_fit_sigma = 0.0;
  std::optional<SweepGap> sweeps;  ///< absent: no temperature was visited both ways in one run
  OneWay one_way;                  ///< temperatures that no run visited both ways
  double temp_min_c = 0.0;
  double temp_max_c = 0.0;
  Family deployed = Family::anfis;
  Curve curve;                       ///< the deployed one
  std::vector<CurvePoint> points;    ///< every 1 °C from temp_min_c, and temp_max_c
  std::vector<Contribution> budget;  ///< what the bands of the points are made of
  std::vector<Warning> warnings;

  /// Of the deployed family; absent under three runs, and of a constant.
  [[nodiscard]] std::optional<CrossValidationError> deployed_error() const {
    return deployed == Family::constant ? std::nullopt : cross_validation[static_cast<std::size_t>(deployed)];
  }
};

/// Temperatures of a curve's points: every 1 °C from the least temperature, and the largest.
[[nodiscard]] std::vector<double> temperatures_of(const CurveFit& fit);

/// Number of temperatures that are half a kelvin or more apart. A curve needs kCurveTemperatures.
[[nodiscard]] std::size_t distinct_temperatures(const CurveData& data);
inline constexpr std::size_t kCurveTemperatures = 3;

/// Fits ANFIS and its baselines to the rows under random run offsets, judges them by outer folds (leave one run out),
/// and deploys the ANFIS unless a baseline beats it by more than one standard error on held-out runs, or the ANFIS of
/// all rows fits them worse, by a quarter, than those of the folds fitted the runs they had not seen: then it is
/// another one, and the baseline with the least held-out error is deployed.
///
/// No outer fold trains on the rows that it is judged by, nor does the error on them count where it chooses the number
/// of rules. They bear on it in these ways: of more than three runs the inner folds that are asked for this number, and
/// at one of whose models the ANFIS of the outer fold begins, have been trained once, for all runs; in these trainings
/// the rows' weights, the variance of the offsets and the spline along which rows are moved to be condensed are those
/// of all runs; and the search for the scatter begins at that of all rows. Measured, none of it shows in the error
/// (docs/decisions/0046-fewer-trainings.md). With fewer than three runs the outer folds are branches
/// of the temperature history, or blocks of time, and are reported as checks only. With at most three, too few for such
/// folds to decide, the family with the least expected error on all rows is deployed (detail/family_choice.h). With too
/// few temperatures for an ANFIS of two rules it is left out, with a warning. Refuses rows that do not vary, non-finite
/// values and fewer than three distinct temperatures. `type_b`: contributions to the uncertainty that the rows do not
/// show. `hysteresis`: half the gap between heating and cooling, for temperatures that the rows visited one way only.
[[nodiscard]] base::Result<CurveFit> fit_curve(const CurveData& data, const CurveFitOptions& options,
                                               const CurveSubject& subject, std::span<const TypeBInput> type_b = {},
                                               const KnownHysteresis& hysteresis = {});

}  // namespace soak::calib
