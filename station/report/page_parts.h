// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace soak::station {

/// A page around its body.
struct Frame {
  std::string title;     ///< escaped here
  std::string software;  ///< that made the page; escaped here
  double created_utc_s = 0.0;
  bool simulated = false;  ///< a bar and a watermark say so
  std::string running{};   ///< at the foot of every printed page, beside its number; empty: the number alone
};

/// A whole page that needs nothing else: no font, no picture, no script but its own; a content security policy forbids
/// them. `body` is HTML, `data` what its figures are drawn from (figure_data()).
[[nodiscard]] std::string page_frame(const Frame& frame, std::string_view body, const nlohmann::json& data);

// Figures (figures.cpp). The modules of the station's page draw them (web/report.mjs) when the page is opened.

/// What stands under a figure; without a script it stands alone.
struct Caption {
  std::string title;
  std::string description;  ///< for those who do not see the drawing
};

/// The place of a figure. `chart`: a key of CHARTS in web/report.mjs; `of`: what of its data it shows; `attributes`:
/// HTML, more that the chart wants to know.
[[nodiscard]] std::string figure(std::string_view chart, std::string_view of, const Caption& caption,
                                 std::string_view attributes = {});

/// What the figures of a unit's report are drawn from; `sections` are those of report_document().
[[nodiscard]] nlohmann::json figure_data(const nlohmann::json& sections);

/// The data and the script that draws them, as elements; and the source that the page's policy must allow.
struct Script {
  std::string html;
  std::string policy;
};
[[nodiscard]] Script figure_script(const nlohmann::json& data);

/// The largest of a member over the points of a curve; null where one of them has none.
[[nodiscard]] nlohmann::json largest(const nlohmann::json& curve, const char* key);

// Parts of the page, each from one section of the document; HTML.

/// One page of A4: name, verdict as a whole and sensor by sensor, what it rests on, the gravest warnings. `heading`:
/// "h1", or "h2" where it is one of several on a page; simulated data are then marked here, not by the page.
[[nodiscard]] std::string certificate_part(const nlohmann::json& document, std::string_view id,
                                           std::string_view heading);
/// What tells a certificate from others: serial number, version of the model, date; not escaped.
[[nodiscard]] std::string certificate_number(const nlohmann::json& document);
/// Laboratory, number, who verified and who released, until when; a line to be filled in for what is not known.
[[nodiscard]] std::string certificate_facts(const nlohmann::json& document);
/// Lines for date, name and signature.
[[nodiscard]] std::string signature_part();
/// "NOT JUDGED" for "info": a verdict as it is read; escaped.
[[nodiscard]] std::string verdict_word(const std::string& verdict);
/// A verdict and why, as it stands above everything else; texts are escaped here.
[[nodiscard]] std::string verdict_line(const std::string& verdict, const std::string& sentence);
/// The warnings with their remedies that the certificate has no room for, those with advice that ask for nothing among
/// them; empty without such.
[[nodiscard]] std::string more_warnings_part(const nlohmann::json& summary);
/// One line per sensor.
[[nodiscard]] std::string overview_part(const nlohmann::json& sensors);
/// Curves, residuals, baselines, uncertainty of one sensor.
[[nodiscard]] std::string sensor_part(std::string_view name, const nlohmann::json& sensor);
/// Accepted effects and the gap that they closed; empty without any.
[[nodiscard]] std::string terms_part(const nlohmann::json& terms);
/// Misalignment and g-sensitivity.
[[nodiscard]] std::string couplings_part(const nlohmann::json& couplings);
/// Position errors without satellite navigation, with and without the calibration; null: they are not known.
[[nodiscard]] std::string impact_part(const nlohmann::json& impact);
/// Allan deviation and noise coefficients.
[[nodiscard]] std::string noise_part(const nlohmann::json& noise);
/// Whether a campaign of a check standard is one of the model's; `check_standards`: the section.
[[nodiscard]] bool is_of_model(const nlohmann::json& check_standards, const nlohmann::json& campaign);
/// Charts of the check standards that were in the campaigns of the model.
[[nodiscard]] std::string check_part(const nlohmann::json& check_standards);
/// References of the laboratory.
[[nodiscard]] std::string records_part(const nlohmann::json& records);
/// Runs, hashes, what is void.
[[nodiscard]] std::string provenance_part(const nlohmann::json& document);

}  // namespace soak::station
