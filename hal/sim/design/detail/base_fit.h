// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/design/detail/block_table.h"

namespace soak::hal::sim {

/// What a refitted model without hidden effects can absorb of block means of one sensor, by least squares:
///
///   one free level per set point (or, instead, a cubic in temperature), one offset per run;
///   accelerometers also one free scale per set point and two constant off-axis terms.
class BaseFit {
 public:
  enum class Temperature { levels, cubic };

  BaseFit(const std::vector<PlannedBlock>& blocks, calib::Sensor sensor, Temperature temperature);

  /// What is left of `values`, one per block.
  [[nodiscard]] std::vector<double> residual(std::vector<double> values) const;

 private:
  void add_column(std::vector<double> column);

  std::vector<std::vector<double>> columns_;  ///< orthonormal
};

}  // namespace soak::hal::sim
