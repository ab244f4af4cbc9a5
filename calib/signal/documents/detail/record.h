// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/documents/signal_json.h"

namespace soak::calib::signal_json {

/// The number, or null where it is not finite.
[[nodiscard]] nlohmann::json number(double value);
[[nodiscard]] nlohmann::json numbers(const std::vector<double>& values);

/// What all documents begin with: column, unit, rate and counts.
[[nodiscard]] nlohmann::json header(const SignalRecord& record);

/// The record's values with short gaps filled by straight lines.
[[nodiscard]] std::vector<double> bridged_values(const SignalRecord& record);

/// Samples of the longest stretch without a gap.
[[nodiscard]] std::size_t longest_stretch(const std::vector<double>& values);

/// The denoised signal on the record's own grid, short gaps filled.
[[nodiscard]] base::Result<std::vector<double>> denoised_values(const SignalRecord& record, const WmraRequest& request);

/// What straight lines over short gaps do to white noise. A mean of m samples, m well above the gaps, weighs each
/// present sample by w = 1 + half the bridged samples next to it, and has (1 + excess)/m of the variance, excess =
/// sum(w^2 - w)/sum(w): 1.5 times the share of lost samples if these are single. Differences at averaging times near
/// the gaps lose about as much.
struct Bridging {
  double share = 0.0;  ///< of bridged among all samples
  double excess = 0.0;
  std::size_t samples = 0;

  /// Whether that is less than what the fit knows or claims: an error of 0.1 % of the variance, or a quarter of the
  /// statistical one, sqrt(3/samples).
  [[nodiscard]] bool negligible() const;
  /// From this multiple on the variance of white noise is 1 + excess times what it would be without the lines, with an
  /// error, of about 2 excess/m, below a quarter of the statistical one, sqrt(4 m/(3 samples)); at least 10.
  [[nodiscard]] std::size_t first_multiple() const;
};

/// Of the gaps of up to `longest` missing samples (NaN) between present ones.
[[nodiscard]] Bridging bridging(std::span<const double> values, std::size_t longest);

/// Checks of the samples themselves, NaN where one is missing: what breaks an Allan curve without changing its shape to
/// anything but noise. All are linear in the number of samples.

/// Refuses a record whose samples never change within a stretch (gaps that are bridged do not end one).
[[nodiscard]] base::Status check_changes(std::span<const double> values);

/// Samples far off their neighbours.
struct Outliers {
  std::vector<std::size_t> at;  ///< rising
  double largest_sigma = 0.0;
};

/// Samples more than 8 sigma from the median of the five around them, sigma by the median absolute first difference;
/// none if together they add less than its statistical error to the variance of the noise from sample to sample.
[[nodiscard]] Outliers outliers(std::span<const double> values);

/// The values with the outliers replaced by the median of the five around each.
[[nodiscard]] std::vector<double> without(std::vector<double> values, const Outliers& outliers);

/// A change of level.
struct Step {
  std::size_t at = 0;   ///< index of the first sample behind it, to an eighth of the window that shows it best
  double height = 0.0;  ///< difference of the means behind and before it
};

/// The largest difference between the means of two neighbouring windows, if it stands out from what such differences
/// are in this record: of white and flicker noise and random walk they are all of one size, those of a step are not.
/// Windows of 1/16, 1/64... of the longest stretch.
[[nodiscard]] std::optional<Step> step(std::span<const double> values);

}  // namespace soak::calib::signal_json
