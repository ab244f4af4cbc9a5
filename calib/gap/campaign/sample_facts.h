// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace soak::calib::gap {

/// What single samples of a sensor say that means of blocks do not.
struct SampleFacts {
  std::size_t count = 0;
  std::optional<double> step;  ///< distance of the lattice that the values lie on, SI; absent = none is seen
  double noise = 0.0;          ///< standard deviation from sample to sample, SI
  double low_rail = 0.0;
  double high_rail = 0.0;
  std::size_t at_rails = 0;  ///< samples that stick at the lowest or highest value; 0 where those are chance

  /// Those of two runs together: the coarser step, the smaller noise, rails added.
  void add(const SampleFacts& other);
};

/// Facts of one sensor's samples in the order of time; NaN = missing. A lattice is seen where distances between
/// neighbouring distinct values are multiples of one step, coarser than the digits that the values have; rails where at
/// least 10 samples are the very lowest (highest) value and ten times as many as the value next to it has. Up to 20000
/// samples, evenly chosen, are looked at for the lattice; all for the rails.
[[nodiscard]] SampleFacts sample_facts(std::span<const double> samples);

}  // namespace soak::calib::gap
