// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/signal/allan/detail/square_sums.h"

namespace soak::calib::signal::allan {

/// Squared differences of one kind at several multiples.
struct KindSums {
  AllanKind kind = AllanKind::overlapping;
  std::vector<SquareSum> sums;
};

/// Sums of squared differences of points that come in piece by piece. Keeps the points from the beginning of the first
/// block that is not added up yet: at most a block and three times the longest multiple.
class BlockWindow {
 public:
  /// Overlapping kinds; multiples up to kBlock.
  BlockWindow(std::span<const AllanKind> kinds, std::span<const std::size_t> multiples);

  void add(std::span<const double> points);
  /// Adds up what is left; no difference reaches on to the points that follow.
  void end_stretch();
  /// Of the blocks that are complete and the stretches that have ended, one entry per kind.
  [[nodiscard]] std::span<const KindSums> sums() const { return sums_; }
  [[nodiscard]] std::span<const std::size_t> multiples() const { return multiples_; }

 private:
  std::vector<std::size_t> multiples_;
  std::size_t capacity_;
  std::vector<KindSums> sums_;
  std::vector<double> window_;
};

}  // namespace soak::calib::signal::allan
