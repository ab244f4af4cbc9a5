// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

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

}  // namespace soak::calib::signal_json
