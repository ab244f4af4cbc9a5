// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "calib/vocabulary/sensor.h"

/// Chart of individual values [Montgomery, Introduction to Statistical Quality Control, 6.4; ISO 7870-2:2023, 6.5;
/// NIST/SEMATECH e-Handbook 6.3.2.2] with prediction limits instead of three-sigma limits: these know how little a few
/// earlier values say [Hahn, Meeker and Escobar, Statistical Intervals, 4.8].
namespace soak::calib {

/// Upper limit of a moving range in units of the mean one: 1 + 3 d3/d2, d2 = E|X − Y| = 2/√π and d3² = Var|X − Y| =
/// 2 − 4/π of two values of a standard normal distribution.
inline constexpr double kD4 = 3.2665320;
/// Largest chance that a campaign in which nothing has changed is found out of control.
inline constexpr double kFalseAlarmPerCampaign = 0.01;
/// The same of one test: a campaign is judged by the charts of all sensors, and each chart by two tests.
inline constexpr double kFalseAlarmPerTest = kFalseAlarmPerCampaign / (2.0 * kSensorCount);
/// So many last values are looked at together.
inline constexpr std::size_t kShiftValues = 8;
/// Fewer earlier values make no limits: those of 5 would be 10 standard deviations from the centre.
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

/// What earlier values say of a process, and where the mean of `of` later ones must lie:
/// centre ± t(1 − kFalseAlarmPerTest, n − 1) · sigma · √(1/of + 1/n), two-sided. Exact for independent normal values.
struct ControlLimits {
  std::size_t values = 0;  ///< n, that these come from
  double centre = 0.0;     ///< mean
  double sigma = 0.0;      ///< standard deviation, n − 1 degrees of freedom
  double lower = 0.0;
  double upper = 0.0;
  double moving_range_upper = 0.0;  ///< kD4 times the mean distance of neighbours
};

/// The mean of the last eight values against the values before them.
struct ControlShift {
  double mean = 0.0;
  ControlLimits limits;
  [[nodiscard]] bool beyond_limits() const { return mean < limits.lower || mean > limits.upper; }
};

/// One value of a chart and what was said of it when it came.
struct ControlPoint {
  double value = 0.0;
  std::optional<double> moving_range;   ///< |value − the one before|; none for the first
  std::optional<ControlLimits> limits;  ///< that it was judged by; none where it was not
  std::optional<ControlShift> shift;    ///< none where there were too few values before the last eight
  ControlVerdict verdict = ControlVerdict::not_established;

  [[nodiscard]] bool beyond_limits() const { return limits && (value < limits->lower || value > limits->upper); }
  [[nodiscard]] bool shifted() const { return shift && shift->beyond_limits(); }
};

/// Limits for the mean of `of` (1 at least) later values, from values in the order of time; none for fewer than
/// kFewestForLimits, or values that are all the same.
[[nodiscard]] std::optional<ControlLimits> control_limits(std::span<const double> values, std::size_t of);

/// A chart of values in the order of time. Each is judged by limits from accepted values before it, never by itself or
/// what followed: the first kMostForLimits accepted ones, fewer while there are fewer. Accepted is what was not found
/// out of control. So is the mean of the last eight values, by limits from accepted values before these eight; values
/// beyond their own limits are none of the eight, as they have been told. A later value changes nothing that was said
/// before. The moving range has its limit for people to look at and no verdict: neighbouring ranges share a value, and
/// a jump shows in the values themselves.
[[nodiscard]] std::vector<ControlPoint> control_chart(std::span<const double> values);

}  // namespace soak::calib
