// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

/// The units of a type beside each other: which curve is not like the others, and what has moved since the model
/// before.
namespace soak::calib {

/// A point of a model's curve; value and band in one unit, whichever it is.
struct FleetPoint {
  double temp_c = 0.0;
  double value = 0.0;
  double ci95 = 0.0;  ///< half-width of the band of the mean curve, 95 %
};

/// A curve over rising temperatures; empty where the unit has none.
using FleetCurve = std::vector<FleetPoint>;

/// One curve of a unit: of its newest model, and of the model before it.
struct FleetMember {
  FleetCurve newest;
  FleetCurve before;
  std::size_t curves = 1;  ///< of this unit whose drift is asked for: they share the chance of a false alarm
};

/// Where a curve moved most between two models, in units of their bands.
struct FleetDrift {
  double temp_c = 0.0;
  double change = 0.0;  ///< newest less before
  double band = 0.0;    ///< root of the sum of squares of both half-widths there, widened, below
  [[nodiscard]] bool is_beyond_band() const { return change > band || change < -band; }
};

/// What the fleet says of one unit's curve.
struct FleetPlace {
  std::vector<std::optional<double>> values;  ///< at the fleet's temperatures; absent outside the curve's range
  std::optional<double> distance;             ///< from the median curve, below; absent of small fleets
  std::optional<double> farthest_c;           ///< where it is farthest from the median
  std::optional<FleetDrift> drift;            ///< absent where there is no model before
  [[nodiscard]] bool is_outlier() const;
};

/// One curve (bias or scale of one sensor) over all units.
struct FleetSpread {
  std::vector<double> temp_c;
  std::vector<std::optional<double>> median;  ///< absent where fewer than half of the curves reach
  std::vector<std::optional<double>> spread;  ///< standard deviation, robust, below; absent of small fleets
  std::vector<FleetPlace> units;              ///< in the order of the members
};

/// Units from which on a spread is stated and outliers are marked: fewer do not tell their own spread well enough.
inline constexpr std::size_t kFewestForSpread = 20;
/// Distance beyond which a curve is an outlier. Twelve curves of a unit are looked at: with 3.5, which Iglewicz and
/// Hoaglin, How to Detect and Handle Outliers (1993), give for one modified z score, 7 % of the units of a normal fleet
/// of 20 would be marked; with 5 it is 1 %, of larger ones less.
inline constexpr double kOutlierDistance = 5.0;

/// At every multiple of 5 °C that a curve reaches: the median over the units, and as spread 1.4826 times the median
/// absolute deviation (the factor makes it the standard deviation of a normal distribution), but no less than half the
/// median 95 % band: what a curve is uncertain by does not set it apart. `distance` is the RMS over those temperatures
/// of a unit's deviation from the median, in spreads; where a spread is 0 a temperature does not count. A curve is held
/// for 2.5 K beyond its ends, as units settle a little off their set points. `drift` is at the temperature where the
/// change is largest in bands. The largest of many changes leaves a 95 % band by chance, so all m comparisons of a unit
/// (its `curves` times the temperatures that both models reach) share the 5 % (Bonferroni): the band is widened by
/// Φ⁻¹(1 − 0.025/m)/Φ⁻¹(0.975). Two models that share runs differ by less than their bands say. Cost n log n of units.
[[nodiscard]] FleetSpread compare_fleet(const std::vector<FleetMember>& members);

}  // namespace soak::calib
