// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calib/unit_rows.h"

namespace soak::calib {

/// Averages over runs of what a run's six-position estimation finds constant: couplings and even-order terms. Weighted
/// means, their errors inflated where the runs scatter by more than theirs. Only standard errors; type B is added by
/// whoever knows the circumstances.
class SharedTerms {
 public:
  void add(const SixPositionEstimate& run);

  /// Misalignment of the accelerometers, or g-sensitivity of the gyros; absent unless all three sensors have all
  /// entries.
  [[nodiscard]] std::optional<Coupling> coupling(bool gyros) const;
  [[nodiscard]] std::optional<StatedValue> even_order(Sensor accel) const;
  [[nodiscard]] std::size_t runs() const { return runs_[0].size(); }

 private:
  std::array<std::vector<SensorEstimate>, kSensorCount> runs_;
};

}  // namespace soak::calib
