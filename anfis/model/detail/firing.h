// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "anfis/model/model.h"

namespace soak::anfis::inference {

/// Below this sum of firing strengths the strengths may be zero or rough: their logarithms decide.
inline constexpr double kSmallestSum = 1e-200;

/// Layers 1 to 3 at one point, with the memory that they need.
class Firing {
 public:
  explicit Firing(const Model& model);

  /// Normalised firing strengths at the scaled inputs u [AH05 eq. 5.5-5.9], valid until the next call. Where no rule
  /// fires they keep their ratios in the limit: the nearest rules remain.
  std::span<const double> at(std::span<const double> u);

  /// Whether some rule fired at the point of the last call.
  [[nodiscard]] bool fired() const { return fired_; }

 private:
  void set_degrees(std::span<const double> u);
  [[nodiscard]] double strength(const Rule& rule) const;

  const Model& model_;
  std::vector<std::size_t> first_;  ///< index of the first membership of each input in degree_
  std::vector<double> degree_;
  std::vector<double> strength_;
  bool fired_ = false;
};

/// Normalises logarithms of firing strengths in place: their largest one becomes the measure.
void normalise_logarithms(std::span<double> log_strengths);

/// ln w of a rule at the scaled inputs u: the sum or the least of the logarithms of its degrees.
[[nodiscard]] double log_strength(const Model& model, const Rule& rule, std::span<const double> u);

}  // namespace soak::anfis::inference
