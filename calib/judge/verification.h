// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/model/unit_model.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::calib {

/// Outcome of a comparison with a limit. Without a limit it is `info`, never `pass`; with one that the runs say nothing
/// of, or too little, it is `not_measured`.
enum class Verdict : std::uint8_t { info, pass, marginal, fail, not_measured };
inline constexpr std::array<std::string_view, 5> kVerdictNames = {"info", "pass", "marginal", "fail", "not_measured"};
constexpr std::string_view name_of(Verdict verdict) { return kVerdictNames[static_cast<std::size_t>(verdict)]; }

/// Coverage of U in the decision rule: two-sided, half of the rest on the one side that a limit lies on.
inline constexpr double kGuardCoverage = 0.95;
/// Largest chance that an error beyond its limit is measured as a pass (JCGM 106 §9.3: specific consumer's risk), where
/// U leaves nothing out.
inline constexpr double kFalseAcceptance = 0.025;
/// Share of a sensor's valid range that fresh rows must span before it can pass.
inline constexpr double kNeededCoverage = 0.8;

/// Errors of fresh runs against a 95 % band that the file states.
///
/// Errors within one run are anything but independent: a run has one offset, a curve one shape. So nothing is counted
/// as if rows were independent. `ratio` is the root mean square of error over half-width; a sum of squares of Gaussian
/// errors, of whatever correlation, passes a large threshold most often where all of them are one and the same (Székely
/// and Bakirov 2003: from 1.54 times its mean on). Its chance is thus at most that of a single error with Student's t.
/// A verification makes m such comparisons (pi95 and ci95 of each bias, ci95 of each scale), which share the chance of
/// a false alarm evenly (Bonferroni): `ratio_max` = t(1 − 0.01/m, ν)/t(0.95, ν), ν the number of the file's runs less
/// one (1 at least), is passed anywhere by at most one file in a hundred whose bands are right (1.25 of two runs, which
/// hardly know their band).
struct BandComparison {
  double inside = 0.0;  ///< share of the errors inside the band
  double ratio = 0.0;
  double ratio_max = 0.0;

  [[nodiscard]] bool too_narrow() const { return ratio > ratio_max; }
};

/// Errors of one curve of a calibration file (bias in SI, scale in ppm) against runs that no fit has seen.
struct CurveVerification {
  Verdict verdict = Verdict::info;
  std::optional<double> limit;
  std::size_t rows = 0;  ///< estimates inside the file's range; without any the errors below mean nothing
  double worst_abs = 0.0;
  double worst_temp_c = 0.0;
  double rmse_abs = 0.0;
  double rmse_shape = 0.0;              ///< each run's own mean error removed
  double guard = 0.0;                   ///< largest U of a row
  double guard_factor = 0.0;            ///< that U over its standard uncertainty
  std::vector<std::string> not_stated;  ///< contributions of unknown size, not in U: "gravity", "fixture"
  double covered = 0.0;                 ///< share of the file's valid range that the rows span
  std::size_t out_of_range = 0;
  std::vector<double> temps_c;  ///< rising: where it was verified, rows within 1.5 K as one
  /// Absolute errors against pi95, the band of a fresh power-on; bias only.
  std::optional<BandComparison> fresh_band;
  /// Means over runs and sweeps at each temperature, each run's mean error removed, against ci95 of the curve; with two
  /// temperatures or more.
  std::optional<BandComparison> shape_band;
};

/// The bias of a sensor against its limit, and its scale. `verdict` is that of the sensor: the worst of both.
struct SensorVerification : CurveVerification {
  Verdict bias_verdict = Verdict::info;
  bool relative = false;                   ///< one attitude: each run's mean error was taken out before judging
  std::optional<CurveVerification> scale;  ///< where file and runs have it, or a limit is set
};

struct Verification {
  Verdict verdict = Verdict::info;  ///< pass, marginal, fail or info
  std::array<std::optional<SensorVerification>, kSensorCount> sensors;
  std::vector<Warning> warnings;
};

/// Compares a calibration with the plateau (or block) estimates of fresh runs of its unit.
///
/// **Decision rule** (guarded acceptance and rejection, JCGM 106:2012 §8.3.2 and §8.3.3, guard band w = U): U = t u,
/// Student's t for 95 % at effective degrees of freedom (calib/estimate/uncertainty_budget.h), u² = the row's standard
/// error² + the variance of the rows from visit to visit beyond that (from second differences,
/// verification/row_errors.h) + what is common to all rows: the type B inputs of make_rows(), gravity and fixture:
/// u(g)/g in the scale error of accelerometers, the rate of the fixture in that of gyros, tilted faces; in bias gravity
/// cancels between up and down. Of what is not stated nothing is added: `not_stated` names it.
///
/// Pass: |error| + U ≤ limit on every row, over at least 80 % of the valid range (a constant, which was measured at one
/// temperature, anywhere in it). Fail: |error| − U > limit on some
/// row. Marginal: neither. So, as far as U is the whole uncertainty (nothing of weight is not stated), a curve that
/// breaks its limit at any temperature verified passes with a chance of 2.5 % at most, and one that keeps it fails with
/// at most 2.5 % per row whose error is at the limit.
///
/// The unit fails if a sensor fails, is marginal if one is, and passes only if all sensors of the file have a limit of
/// bias and pass; else `info`. Where the runs know one attitude only, accelerometer errors have each run's mean
/// removed. Refuses runs that are among those of the file, and runs that say nothing inside its valid range.
[[nodiscard]] base::Result<Verification> verify(const Calibration& calibration, const UnitInput& runs,
                                                const Limits& limits);

}  // namespace soak::calib
