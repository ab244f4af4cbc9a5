// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/estimate/unit_rows.h"

namespace soak::calib {

/// Averages over runs of what a run's six-position estimation finds constant: couplings, even-order terms, level error.
/// Weighted means, their errors inflated where the runs scatter by more than theirs. Only standard errors; type B is
/// added by whoever knows the circumstances.
class SharedTerms {
 public:
  void add(const SixPositionEstimate& run);

  /// Misalignment of the accelerometers, or g-sensitivity of the gyros; absent unless all three sensors have all
  /// entries.
  [[nodiscard]] std::optional<Coupling> coupling(bool gyros) const;
  [[nodiscard]] std::optional<StatedValue> even_order(Sensor accel) const;
  /// Mean over the runs that show it; the reason of the first where none does.
  [[nodiscard]] LevelStatement level() const;
  [[nodiscard]] std::size_t runs() const { return runs_[0].size(); }

 private:
  std::array<std::vector<SensorEstimate>, kSensorCount> runs_;
  std::vector<LevelError> levels_;
  std::vector<std::string> no_level_;  ///< reasons of the other runs
  bool with_headings_ = false;
};

}  // namespace soak::calib
