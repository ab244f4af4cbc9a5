// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

/// The documents of `soak signal` as tables for people.
namespace soak::station {

[[nodiscard]] std::string allan_text(const nlohmann::json& document);
[[nodiscard]] std::string psd_text(const nlohmann::json& document);
[[nodiscard]] std::string acf_text(const nlohmann::json& document);

}  // namespace soak::station
