// SPDX-License-Identifier: Apache-2.0
#include "station/commands/verify_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <string_view>
#include <vector>

#include "station/io/output.h"

namespace soak::station {
namespace {

/// Share of errors inside the stated band: that of a fresh power-on, else of the shape.
std::string inside_text(const calib::CurveVerification& curve) {
  const auto& band = curve.fresh_band ? curve.fresh_band : curve.shape_band;
  if (!band) return "-";
  return fmt::format("{:.0f} %{}", 100.0 * band->inside, band->too_narrow() ? " (!)" : "");
}

std::vector<std::string> verify_row(const std::string& name, std::string_view unit,
                                    const calib::CurveVerification& curve, calib::Verdict verdict, double factor,
                                    int digits) {
  const auto number = [&](double value) {
    return curve.rows > 0 ? fmt::format("{:.{}f}", value * factor, digits) : std::string("-");
  };
  return {name,
          std::string(unit),
          std::string(calib::name_of(verdict)),
          number(curve.worst_abs),
          curve.rows > 0 ? fmt::format("{:.1f}", curve.worst_temp_c) : "-",
          number(curve.guard),
          curve.limit ? fmt::format("{:.{}f}", *curve.limit * factor, digits) : "-",
          number(curve.rmse_abs),
          number(curve.rmse_shape),
          inside_text(curve),
          std::to_string(curve.rows)};
}

/// The temperatures of the first sensor that has some; those of the others differ where thermometers do.
std::string temperatures_text(const calib::Verification& verification) {
  for (const auto& sensor : verification.sensors) {
    if (!sensor || sensor->temps_c.empty()) continue;
    if (sensor->temps_c.size() > 60) {
      return fmt::format("compared from {:.1f} to {:.1f} °C\n", sensor->temps_c.front(), sensor->temps_c.back());
    }
    return fmt::format("compared at {:.1f} °C\n", fmt::join(sensor->temps_c, ", "));
  }
  return {};
}

/// Contributions that U lacks, and for which curves.
std::string not_stated_text(const calib::Verification& verification) {
  std::map<std::string, std::vector<std::string>> curves;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (!result) continue;
    const std::string name(calib::name_of(sensor));
    for (const std::string& what : result->not_stated) curves[what].push_back(name);
    if (!result->scale) continue;
    for (const std::string& what : result->scale->not_stated) curves[what].push_back(name + " scale");
  }
  std::string text;
  for (const auto& [what, of] : curves) {
    text += fmt::format("not stated, and therefore not in U: {} ({})\n", what, fmt::join(of, ", "));
  }
  return text;
}

/// The sensors without a limit, which are not judged, and how to set limits.
std::string not_judged_text(const calib::Verification& verification) {
  std::vector<std::string> names;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (result && result->bias_verdict == calib::Verdict::info) names.emplace_back(calib::name_of(sensor));
  }
  if (names.empty()) return {};
  return fmt::format(
      "not judged, as no limit is set: {}; set limits in procedures/units/TYPE.toml or with --limits FILE "
      "(docs/guide.md)\n",
      fmt::join(names, ", "));
}

/// Whether the verdict was stored, and what the model is from now on.
std::string stored_text(const Judgement& judgement, const StoredJudgement& stored) {
  if (!stored.stored) return "the verdict is not stored: " + stored.why;
  const bool breaks_release = stored.state == "released" && judgement.verification.verdict == calib::Verdict::fail;
  return fmt::format("stored; model {} is {}{}", judgement.calibration.model_version, stored.state,
                     breaks_release ? ", though it fails: 'soak model retire' withdraws it" : "");
}

}  // namespace

std::string verify_text(const Judgement& judgement, const StoredJudgement& stored) {
  const calib::Verification& verification = judgement.verification;
  std::vector<std::vector<std::string>> table = {
      {"sensor", "unit", "verdict", "worst", "at °C", "U", "limit", "rmse", "shape", "in band", "rows"}};
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (!result) continue;
    const std::string name(calib::name_of(sensor));
    const calib::Verdict bias = result->bias_verdict;
    table.push_back(verify_row(name, calib::printed_unit(sensor), *result, bias, calib::printed_per_si(sensor), 5));
    if (result->scale)
      table.push_back(verify_row(name + " scale", "ppm", *result->scale, result->scale->verdict, 1.0, 1));
  }
  std::string corrected;
  for (const calib::ModelTerm& term : judgement.terms)
    corrected += fmt::format("{}{}", corrected.empty() ? "" : ", ", term.name);
  if (!corrected.empty()) {
    corrected = fmt::format("effects corrected as on a device that knows its past: {}\n", corrected);
  }
  const calib::Calibration& calibration = judgement.calibration;
  return fmt::format("unit {}, model {}: {}\nlimits: {}\n{}{}{}{}{}rule: {}\n{}\n", calibration.unit,
                     calibration.model_version, calib::name_of(verification.verdict),
                     judgement.limits.source.value_or("none"), corrected, text_table(table),
                     temperatures_text(verification), not_judged_text(verification), not_stated_text(verification),
                     decision_rule(verification), stored_text(judgement, stored));
}

}  // namespace soak::station
