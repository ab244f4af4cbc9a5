// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/baselines.h"
#include "calib/curve/curve_fit.h"
#include "calib/curve/variance_components.h"
#include "calib/estimate/curve_data.h"

namespace soak::calib {

/// All families fitted to the same rows; absent where the rows have too few temperatures for one.
struct TrainedFamilies {
  VarianceComponents components;
  std::array<std::optional<FittedCurve>, kFamilyCount> fitted;
  int rules = 0;
  std::string membership;
  std::string training;  ///< one line about the ANFIS' training

  [[nodiscard]] const std::optional<FittedCurve>& operator[](Family family) const {
    return fitted[static_cast<std::size_t>(family)];
  }
};

/// Fits every family to the rows, the ANFIS' rule count chosen by folds inside them: over runs where there are two or
/// more, else over blocks of time.
[[nodiscard]] base::Result<TrainedFamilies> train_families(const CurveData& data, const CurveFitOptions& options);

/// Fold of each row by stretches of time, five folds taken in turn.
[[nodiscard]] std::vector<int> block_folds(const CurveData& data);

/// The rows whose flag is set.
[[nodiscard]] CurveData select(const CurveData& data, const std::vector<bool>& keep);

/// Number of different runs among the rows.
[[nodiscard]] std::size_t count_runs(const CurveData& data);

}  // namespace soak::calib
