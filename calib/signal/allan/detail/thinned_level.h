// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "calib/signal/allan/detail/block_window.h"

namespace soak::calib::signal::allan {

/// A stretch thinned by a power of two: every 2^j-th phase point for the Allan and Hadamard deviations, the means of
/// 2^j phase points for the modified Allan deviation, whose windows consist of such means.
class ThinnedLevel {
 public:
  /// Multiples in points of this level.
  explicit ThinnedLevel(std::span<const std::size_t> multiples);

  /// Takes the next phase points and means, and leaves in their place what goes on to the next level: every second
  /// point from the first of the stretch on, and the means of pairs.
  void add(std::vector<double>& points, std::vector<double>& means);
  void end_stretch();

  [[nodiscard]] const BlockWindow& phase() const { return phase_; }  ///< overlapping Allan, overlapping Hadamard
  [[nodiscard]] const BlockWindow& means() const { return means_; }  ///< modified Allan

 private:
  BlockWindow phase_;
  BlockWindow means_;
  bool skip_ = false;                 ///< the next phase point
  std::optional<double> first_half_;  ///< of a pair of means that is not complete
};

}  // namespace soak::calib::signal::allan
