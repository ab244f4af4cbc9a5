// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace soak::hal::sim {

/// The voltage that feeds the units: 5 V, an offset of its own after each power-on (0.03 V) and a slow wandering of
/// 0.02 V with a correlation time of 400 s. Depends on the seed and on the moments that it is asked for.
class SupplyVoltage {
 public:
  explicit SupplyVoltage(std::uint64_t seed) : seed_(seed) {}

  /// `run` is the ordinal of the power-on.
  [[nodiscard]] double at(double time_s, int run);

 private:
  std::uint64_t seed_;
  std::uint64_t moment_ = 0;
  double time_s_ = 0.0;
  double wandering_ = 0.0;  ///< of unit variance
};

}  // namespace soak::hal::sim
