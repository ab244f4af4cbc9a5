// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

/// Shewhart chart of individual values with moving ranges of two [Montgomery, Introduction to Statistical Quality
/// Control, 6.4; ISO 7870-2:2023, 6.5; NIST/SEMATECH e-Handbook 6.3.2.2].
namespace soak::calib {

/// Mean of the range of two values of a standard normal distribution: E|X − Y| = 2/√π.
inline constexpr double kD2 = 1.1283791670955126;
/// Upper limit of a moving range in units of the mean one: 1 + 3 d3/d2, d3² = Var|X − Y| = 2 − 4/π.
inline constexpr double kD4 = 3.2665320;
/// Width of the limits in standard deviations.
inline constexpr double kControlSigmas = 3.0;
/// So many values in a row on one side of the centre are a signal (the fourth rule of the Western Electric handbook,
/// 1956).
inline constexpr std::size_t kControlRun = 8;
/// Fewer earlier values make no limits: with 10, one value in 40 from a process in control lies beyond them, with 5 one
/// in 17 (docs/check-standard.md).
inline constexpr std::size_t kFewestForLimits = 10;
/// From so many on, limits stay as they are: else a slow drift would take them along.
inline constexpr std::size_t kMostForLimits = 25;

enum class ControlVerdict : std::uint8_t {
  not_established,  ///< too few earlier values, or earlier values without any scatter: nothing was judged
  in_control,
  out_of_control,
};

constexpr std::string_view name_of(ControlVerdict verdict) {
  return verdict == ControlVerdict::in_control       ? "in_control"
         : verdict == ControlVerdict::out_of_control ? "out_of_control"
                                                     : "not_established";
}

/// What earlier values say of a process.
struct ControlLimits {
  std::size_t values = 0;          ///< that these come from
  double centre = 0.0;             ///< mean
  double mean_moving_range = 0.0;  ///< of neighbours among these values
  double sigma = 0.0;              ///< mean moving range / d2
  double lower = 0.0;              ///< centre − 3 sigma
  double upper = 0.0;              ///< centre + 3 sigma
  double moving_range_upper = 0.0;
};

/// One value of a chart and what was said of it when it came.
struct ControlPoint {
  double value = 0.0;
  std::optional<double> moving_range;   ///< |value − the one before|; none for the first
  std::optional<ControlLimits> limits;  ///< that it was judged by; none where it was not
  ControlVerdict verdict = ControlVerdict::not_established;
  bool beyond_limits = false;  ///< farther than 3 sigma from the centre
  bool run = false;            ///< the eighth or later in a row on its side of the centre
};

/// Limits from values in the order of time; none for fewer than kFewestForLimits, or values that are all the same.
[[nodiscard]] std::optional<ControlLimits> control_limits(std::span<const double> values);

/// Judges the last of `values` (one at least) by given limits; those before it only tell whether it ends a run.
[[nodiscard]] ControlPoint judge(const ControlLimits& limits, std::span<const double> values);

/// A chart of values in the order of time. Each is judged by limits from accepted values before it, never by itself or
/// what followed: the first kMostForLimits accepted ones, fewer while there are fewer. Accepted is what was not found
/// out of control. A later value changes nothing that was said before. The moving range has its limit for people to
/// look at and no verdict: neighbouring ranges share a value, and a jump shows in the values themselves.
[[nodiscard]] std::vector<ControlPoint> control_chart(std::span<const double> values);

}  // namespace soak::calib
