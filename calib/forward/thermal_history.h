// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/campaign/campaign.h"

namespace soak::calib::forward {

/// A quantity over device time: linear between its points, held beyond them. `values` has the length of `t_s`.
struct Series {
  std::vector<double> t_s;  ///< rising
  std::vector<double> values;

  [[nodiscard]] bool empty() const { return t_s.empty(); }
  [[nodiscard]] double at(double t_s_wanted) const;
  /// Mean of the points from `from_s` to `to_s`; the value in the middle where none lies there.
  [[nodiscard]] double mean(double from_s, double to_s) const;
};

/// A logged channel without its holes; empty where nobody logged it.
[[nodiscard]] Series series_of(const gap::RunLog& log, const std::vector<double>& channel);

/// Slope of the straight line through the series within two minutes to both sides, K/s; 0 where fewer than three
/// points are near.
[[nodiscard]] Series rate_of(const Series& temp_c);

/// Temperature of an element that follows `temp_c` with the time constant `tau_s`: dTe/dt = (T − Te)/τ. It starts at
/// the first temperature or, `under_way`, as far behind it as if the slope of the first two minutes had gone on for
/// long.
[[nodiscard]] Series follower_of(const Series& temp_c, double tau_s, bool under_way = false);

/// Memory of the branch that a unit came from, −1 (cooling) to 1 (heating): h tends to the sign of the way with each
/// kelvin, dh = (±1 − h)(1 − e^{−|dT|/w}), w = `width_c`. Turns of less than 0.5 K do not count. It starts at the
/// branch that leads from room temperature (23 °C) to the first temperature or, with `along`, on the branch of the
/// first movement (1), the opposite one (−1) or between them (0).
[[nodiscard]] Series branch_memory_of(const Series& temp_c, double width_c, std::optional<double> along = {});

/// Water left in a package, 1 at the first temperature, that dries with the time constant `tau_s` at 50 °C and faster
/// the hotter by Arrhenius' law, `activation_k` over the absolute temperature.
[[nodiscard]] Series water_of(const Series& temp_c, double tau_s, double activation_k);

}  // namespace soak::calib::forward
