// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "base/result.h"
#include "calib/calibration.h"
#include "calib/unit_fit.h"

namespace soak::calib {

/// Outcome of a comparison with a limit. Without a limit it is `info`, never `pass`.
enum class Verdict { info, pass, marginal, fail };

constexpr std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::marginal:
      return "marginal";
    case Verdict::fail:
      return "fail";
    case Verdict::info:
      break;
  }
  return "info";
}

/// Largest allowed absolute error of the bias of each sensor, SI.
using Limits = std::array<std::optional<double>, kSensorCount>;

/// Errors of a calibration file's bias of one sensor against runs that no fit has seen, SI.
struct SensorVerification {
  Verdict verdict = Verdict::info;
  double worst_abs = 0.0;
  double worst_temp_c = 0.0;
  double rmse_abs = 0.0;
  double rmse_shape = 0.0;  ///< each run's own mean error removed
  std::size_t rows = 0;
  double covered = 0.0;          ///< share of the file's valid range that the rows span
  std::size_t out_of_range = 0;  ///< rows outside the file's valid range, not counted
  std::optional<double> limit;
};

struct Verification {
  Verdict verdict = Verdict::info;
  std::array<std::optional<SensorVerification>, kSensorCount> sensors;
  std::vector<Warning> warnings;
};

/// Compares a calibration with the plateau (or block) estimates of fresh runs of its unit.
///
/// Decision rule with guard band (JCGM 106 §8.3): U = 1.96 standard errors of the row. Pass: |error| + U ≤ limit on
/// every row. Fail: |error| − U > limit on some row. Else marginal. The unit's verdict is its sensors' worst; it passes
/// only if every sensor of the file has a limit and rows over at least 80 % of its valid range. Where the runs know one
/// attitude only, accelerometer errors have their mean removed. Refuses runs that are among those of the file, and runs
/// that say nothing inside its valid range.
[[nodiscard]] base::Result<Verification> verify(const Calibration& calibration, const UnitInput& runs,
                                                const Limits& limits);

}  // namespace soak::calib
