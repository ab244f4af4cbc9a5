// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/estimate/unit_input.h"
#include "calib/judge/verification.h"
#include "calib/model/deployed_terms.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/nav/free_inertial.h"
#include "station/records/calibration_reader.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

/// soak verify FILE.blob --campaign NAME [--limits FILE]
struct VerifyCommand final : Command {
  std::string file;
  std::string campaign;
  std::string limits_file;  ///< empty = limits of the unit's type

  void declare(OptionList& options) override;
  base::Status run(Output& output) override;
};

void VerifyCommand::declare(OptionList& options) {
  options.add("file FILE.blob", &file, "Calibration file").required();
  options.add("--campaign NAME", &campaign, "Campaign of the fresh runs").required();
  options.add("--limits FILE", &limits_file,
              "Limits per sensor (TOML; default: those of the unit's type); without limits the verdict is 'info'");
}

base::Result<calib::UnitInput> load_campaign(const db::Catalog& catalog, const calib::Calibration& calibration,
                                             const std::string& campaign, std::vector<calib::Warning>& warnings) {
  if (auto known = check_campaign_known(catalog, campaign); !known) return base::forward_error(known);
  const auto runs = catalog.runs({.unit = calibration.unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  auto input = unit_of(calibration);
  if (!input) return base::forward_error(input);
  for (const db::RunRow& run : *runs) {
    // A pre-flight records units that have not settled.
    if (!run.sealed || run.voided || run.epoch != calibration.epoch || run.purpose == "diagnosis") continue;
    auto loaded = load_run(catalog, run, input->type);
    if (!loaded) return base::forward_error(loaded);
    input->runs.push_back(*std::move(loaded));
  }
  if (input->runs.empty()) {
    return base::bad_input(
        fmt::format("campaign '{}' has no usable run of unit {} in epoch {} (sealed, not voided, not for diagnosis; {} "
                    "runs in all): 'soak runs list' shows them",
                    campaign, calibration.unit, calibration.epoch, runs->size()));
  }
  for (calib::Warning& warning : unit_type_warnings(input->type.name)) warnings.push_back(std::move(warning));
  calib::leave_out_copies(input->runs, warnings);
  auto references = references_of_campaigns(catalog, {campaign});
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  return input;
}

/// Those of the file that the user names, else of the unit's type.
base::Result<KnownLimits> limits_for(const VerifyCommand& command, const calib::Calibration& calibration) {
  if (!command.limits_file.empty()) {
    const auto limits = read_limits(command.limits_file);
    if (!limits) return base::forward_error(limits);
    return KnownLimits{*limits, command.limits_file};
  }
  return limits_of_type(calibration.unit_type);
}

/// Contributions that U lacks for some curve.
std::set<std::string> not_stated(const calib::Verification& verification) {
  std::set<std::string> names;
  for (const auto& sensor : verification.sensors) {
    if (!sensor) continue;
    names.insert(sensor->not_stated.begin(), sensor->not_stated.end());
    if (sensor->scale) names.insert(sensor->scale->not_stated.begin(), sensor->scale->not_stated.end());
  }
  return names;
}

/// The rule in words. Its bound of the risk holds only where U is the whole uncertainty.
std::string decision_rule(const calib::Verification& verification) {
  const std::set<std::string> missing = not_stated(verification);
  const std::string condition =
      missing.empty() ? ""
                      : fmt::format(". This probability assumes that what U does not contain ({}) is negligible",
                                    fmt::join(missing, ", "));
  return fmt::format(
      "guard band w = U = t u of each estimate, Student's t for {:g} % at effective degrees of freedom (JCGM 106:2012 "
      "8.3.2, 8.3.3; JCGM 100:2008 G.4): pass where |error| + U <= limit at every temperature, fail where |error| - U "
      "> limit at one, else marginal; an error beyond its limit passes with a probability of at most {:g} %{}",
      100.0 * calib::kGuardCoverage, 100.0 * calib::kFalseAcceptance, condition);
}

nlohmann::json band_document(const std::optional<calib::BandComparison>& band) {
  if (!band) return {};
  return {{"inside", band->inside},
          {"ratio", band->ratio},
          {"ratio_max", band->ratio_max},
          {"too_narrow", band->too_narrow()}};
}

/// A number that is known only where rows are.
nlohmann::json known_value(const calib::CurveVerification& curve, double value) {
  return curve.rows > 0 ? nlohmann::json(value) : nlohmann::json();
}

/// Of bias (in printed units) or scale; `factor` from the inside unit to that of the document.
nlohmann::json curve_document(const calib::CurveVerification& curve, double factor) {
  return {{"verdict", calib::name_of(curve.verdict)},
          {"worst_abs", known_value(curve, curve.worst_abs * factor)},
          {"worst_temp_c", known_value(curve, curve.worst_temp_c)},
          {"rmse_abs", known_value(curve, curve.rmse_abs * factor)},
          {"rmse_shape", known_value(curve, curve.rmse_shape * factor)},
          {"guard", known_value(curve, curve.guard * factor)},
          {"guard_factor", known_value(curve, curve.guard_factor)},
          {"not_stated", curve.not_stated},
          {"limit", curve.limit ? nlohmann::json(*curve.limit * factor) : nlohmann::json()},
          {"rows", curve.rows},
          {"covered", curve.covered},
          {"temps_c", curve.temps_c},
          {"shape_against_ci95", band_document(curve.shape_band)}};
}

nlohmann::json sensor_document(calib::Sensor sensor, const calib::SensorVerification& result) {
  nlohmann::json document = curve_document(result, calib::printed_per_si(sensor));
  document["fresh_against_pi95"] = band_document(result.fresh_band);
  document["bias_verdict"] = calib::name_of(result.bias_verdict);
  document["relative"] = result.relative;
  document["scale"] = result.scale ? curve_document(*result.scale, 1.0) : nlohmann::json();
  return document;
}

nlohmann::json verification_json(const calib::Calibration& calibration, const KnownLimits& limits,
                                 const calib::Verification& verification, const std::vector<calib::ModelTerm>& terms) {
  nlohmann::json corrected = nlohmann::json::array();
  for (const calib::ModelTerm& term : terms) corrected.push_back(term.name);
  nlohmann::json sensors = nlohmann::json::object();

  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (result) sensors[std::string(calib::name_of(sensor))] = sensor_document(sensor, *result);
  }

  return {{"unit", calibration.unit},
          {"model", calibration.model_version},
          {"verdict", calib::name_of(verification.verdict)},
          {"decision_rule",
           {{"guard_coverage", calib::kGuardCoverage},
            {"false_acceptance_max", calib::kFalseAcceptance},
            {"text", decision_rule(verification)}}},
          {"limits", limits.source ? nlohmann::json(*limits.source) : nlohmann::json()},
          {"moving_terms", std::move(corrected)},
          {"impact", impact_json(calibration)},
          {"sensors", std::move(sensors)},
          {"warnings", warnings_json(verification.warnings)}};
}

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

std::string verify_text(const calib::Calibration& calibration, const KnownLimits& limits,
                        const calib::Verification& verification, const std::vector<calib::ModelTerm>& terms) {
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
  for (const calib::ModelTerm& term : terms) corrected += fmt::format("{}{}", corrected.empty() ? "" : ", ", term.name);
  if (!corrected.empty()) {
    corrected = fmt::format("effects corrected as on a device that knows its past: {}\n", corrected);
  }
  return fmt::format("unit {}, model {}: {}\nlimits: {}\n{}{}{}{}{}rule: {}\n", calibration.unit,
                     calibration.model_version, calib::name_of(verification.verdict), limits.source.value_or("none"),
                     corrected, text_table(table), temperatures_text(verification), not_judged_text(verification),
                     not_stated_text(verification), decision_rule(verification));
}

/// What was withdrawn since of the file's data and of the references of the fresh runs, each sentence once.
base::Result<std::vector<calib::Warning>> warnings_since(const db::Catalog& catalog,
                                                         const calib::Calibration& calibration,
                                                         const calib::UnitInput& fresh) {
  auto warnings = withdrawn_since(catalog, calibration);
  if (!warnings) return warnings;
  const auto of_fresh = reference_warnings(catalog, fresh.references);
  if (!of_fresh) return base::forward_error(of_fresh);
  for (const calib::Warning& warning : *of_fresh) {
    if (std::ranges::find(*warnings, warning.text, &calib::Warning::text) == warnings->end()) {
      warnings->push_back(warning);
    }
  }
  return warnings;
}

base::Status VerifyCommand::run(Output& output) {
  const auto loaded = read_calibration(file);
  if (!loaded) return base::forward_error(loaded);
  const auto limits = limits_for(*this, loaded->calibration);
  if (!limits) return base::forward_error(limits);
  const auto catalog = open_existing_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  std::vector<calib::Warning> warnings;
  auto runs = load_campaign(*catalog, loaded->calibration, campaign, warnings);
  if (!runs) return base::forward_error(runs);
  // As soak_apply_history and soak_apply_moving do on the device.
  const std::vector<calib::ModelTerm> terms = calib::moving_terms(loaded->calibration);
  if (const auto taken = take_terms_off(*catalog, terms, *runs, warnings); !taken) return base::forward_error(taken);
  auto verification = calib::verify(loaded->calibration, *runs, limits->limits);
  if (!verification) return base::forward_error(verification);
  const auto since = warnings_since(*catalog, loaded->calibration, *runs);
  if (!since) return base::forward_error(since);
  std::ranges::copy(warnings, std::back_inserter(verification->warnings));
  std::ranges::copy(*since, std::back_inserter(verification->warnings));
  std::ranges::copy(waiver_warnings(loaded->calibration.references), std::back_inserter(verification->warnings));
  note_waivers(loaded->calibration.references, output);
  if (output.json()) {
    if (const auto printed = output.print_json(verification_json(loaded->calibration, *limits, *verification, terms));
        !printed)
      return printed;
  } else {
    for (const calib::Warning& warning : verification->warnings) {
      // note_waivers() has told it.
      if (warning.code != "waiver_signature") output.note("warning: " + warning.text);
    }
    output.print(verify_text(loaded->calibration, *limits, *verification, terms));
  }
  if (verification->verdict == calib::Verdict::fail) {
    return base::fail(base::ErrorKind::limits, "the unit exceeds its limits", loaded->calibration.unit);
  }
  return {};
}

}  // namespace

CommandGroup verify_commands() {
  return {
      "",
      "",
      {{"verify", "Compare a calibration file with runs that no fit has used",
        "soak verify SN0042.soakcal --campaign check-2027 --limits limits.toml", std::make_shared<VerifyCommand>()}}};
}

}  // namespace soak::station
