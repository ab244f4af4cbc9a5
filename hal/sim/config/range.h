// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "settings/reader.h"

namespace soak::hal::sim {

/// Bounds of a uniform draw.
struct Range {
  double low = 0.0;
  double high = 0.0;
};

/// What the configuration may ask for where nothing narrower is said.
inline constexpr settings::Limits kAnyTemperature_c = {-200.0, 300.0};
inline constexpr settings::Limits kAnyMagnitude = {0.0, 1e6};

/// The pair [low, high] under a required key, low ≤ high.
[[nodiscard]] Range read_range(const settings::Table& table, std::string_view key, settings::Limits limits);

/// As read_range(), both ends whole.
[[nodiscard]] Range read_whole_range(const settings::Table& table, std::string_view key, settings::Limits limits);

/// The list under a required key: at least one number.
[[nodiscard]] std::vector<double> read_some_numbers(const settings::Table& table, std::string_view key,
                                                    settings::Limits limits);

}  // namespace soak::hal::sim
