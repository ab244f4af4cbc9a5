// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace soak::calib {

/// One line of the uncertainty budget of a curve (JCGM 100:2008, 8): standard uncertainties at each of its points, in
/// its unit. Contributions count as independent.
struct Contribution {
  std::string name = {};  ///< "noise", "run_to_run", "hysteresis", "thermometer", "gravity", "fixture", "model"
  char type = 'A';        ///< 'A': from the scatter of these runs; 'B': from elsewhere
  std::optional<double> degrees_of_freedom = std::nullopt;  ///< absent = infinite
  std::vector<double> u = {};        ///< of the mean curve (ci95); empty = not part of it, or not stated
  std::vector<double> u_fresh = {};  ///< of one fresh power-on (pi95); empty = not part of it, or not stated
  std::string basis = {};            ///< where the number comes from, or what is missing to state it

  /// False: nobody has said how large it is, and the bands leave it out.
  [[nodiscard]] bool stated() const { return !u.empty() || !u_fresh.empty(); }
};

/// Which band a contribution goes into.
enum class Band { mean, fresh_power_on };

/// Half-width at point i of the 95 % interval of the sum of contributions: two-sided t at effective degrees of freedom
/// (Welch-Satterthwaite, JCGM 100:2008 G.4) times the root of the sum of squares. Each point lies in all the vectors
/// that are not empty.
[[nodiscard]] double expanded_uncertainty(const std::vector<Contribution>& budget, Band band, std::size_t i);

}  // namespace soak::calib
