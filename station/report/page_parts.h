// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace soak::station {

/// A whole page that needs nothing else: no script, no font, no picture from elsewhere; a content security policy
/// forbids them. `title` is escaped here, `body` is HTML. `simulated`: a bar and a watermark say so.
[[nodiscard]] std::string page_frame(std::string_view title, std::string_view body, std::string_view software,
                                     const nlohmann::json& created_utc_s, bool simulated);

// Parts of the page, each from one section of the document; HTML.

/// Name, verdict, what it is of.
[[nodiscard]] std::string head_part(const nlohmann::json& document);
/// Warnings with their remedies; empty without warnings.
[[nodiscard]] std::string warnings_part(const nlohmann::json& summary);
/// One line per sensor.
[[nodiscard]] std::string overview_part(const nlohmann::json& sensors);
/// Curves, residuals, baselines, uncertainty of one sensor.
[[nodiscard]] std::string sensor_part(std::string_view name, const nlohmann::json& sensor);
/// Accepted effects and the gap that they closed; empty without any.
[[nodiscard]] std::string terms_part(const nlohmann::json& terms);
/// Misalignment and g-sensitivity.
[[nodiscard]] std::string couplings_part(const nlohmann::json& couplings);
/// Allan deviation and noise coefficients.
[[nodiscard]] std::string noise_part(const nlohmann::json& noise);
/// Charts of the check standards that were in the campaigns of the model.
[[nodiscard]] std::string check_part(const nlohmann::json& check_standards);
/// References of the laboratory.
[[nodiscard]] std::string records_part(const nlohmann::json& records);
/// Runs, hashes, what is void.
[[nodiscard]] std::string provenance_part(const nlohmann::json& document);

}  // namespace soak::station
