// SPDX-License-Identifier: Apache-2.0
#include "station/release/judgement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "calib/deploy/calibration_file.h"
#include "calib/estimate/unit_input.h"
#include "calib/model/deployed_terms.h"
#include "calib/model/model_document.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/nav/free_inertial.h"
#include "station/records/calibration_reader.h"
#include "station/records/signing.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// The runs of a judgement as input of the comparison; the judgement notes which they are.
base::Result<calib::UnitInput> load_fresh(const db::Catalog& catalog, Judgement& judgement) {
  const calib::Calibration& calibration = judgement.calibration;
  if (auto known = check_campaign_known(catalog, judgement.campaign); !known) return base::forward_error(known);
  const auto runs = catalog.runs({.unit = calibration.unit, .campaign = judgement.campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  auto input = unit_of(calibration);
  if (!input) return base::forward_error(input);
  for (const db::RunRow& run : *runs) {
    // A pre-flight records units that have not settled.
    if (!run.sealed || run.voided || run.epoch != calibration.epoch || run.purpose == "diagnosis") continue;
    if (run.simulated && !calibration.simulated) {
      return base::bad_input(
          fmt::format("model {} of unit {} was measured, and run {} of campaign '{}' is SIMULATED: verify it against "
                      "measured runs, or void the simulated ones",
                      calibration.model_version, calibration.unit, run.label, judgement.campaign));
    }
    auto loaded = load_run(catalog, run, input->type);
    if (!loaded) return base::forward_error(loaded);
    input->runs.push_back(*std::move(loaded));
    judgement.runs.push_back(run);
  }
  if (input->runs.empty()) {
    return base::bad_input(
        fmt::format("campaign '{}' has no usable run of unit {} in epoch {} (sealed, not voided, not for diagnosis; {} "
                    "runs in all): 'soak runs list' shows them",
                    judgement.campaign, calibration.unit, calibration.epoch, runs->size()));
  }
  auto references = references_of_campaigns(catalog, {judgement.campaign});
  if (!references) return base::forward_error(references);
  input->references = *std::move(references);
  return input;
}

/// What was withdrawn since of the file's data and of the references of the fresh runs, each sentence once.
base::Result<std::vector<calib::Warning>> warnings_since(const db::Catalog& catalog, const Judgement& judgement) {
  auto warnings = withdrawn_since(catalog, judgement.calibration);
  if (!warnings) return warnings;
  const auto of_fresh = reference_warnings(catalog, judgement.references);
  if (!of_fresh) return base::forward_error(of_fresh);
  for (const calib::Warning& warning : *of_fresh) {
    if (std::ranges::find(*warnings, warning.text, &calib::Warning::text) == warnings->end()) {
      warnings->push_back(warning);
    }
  }
  return warnings;
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

json band_document(const std::optional<calib::BandComparison>& band) {
  if (!band) return {};
  return {{"inside", band->inside},
          {"ratio", band->ratio},
          {"ratio_max", band->ratio_max},
          {"too_narrow", band->too_narrow()}};
}

/// A number that is known only where rows are.
json known_value(const calib::CurveVerification& curve, double value) { return curve.rows > 0 ? json(value) : json(); }

/// Of bias (in printed units) or scale; `factor` from the inside unit to that of the document.
json curve_document(const calib::CurveVerification& curve, double factor) {
  return {{"verdict", calib::name_of(curve.verdict)},
          {"worst_abs", known_value(curve, curve.worst_abs * factor)},
          {"worst_temp_c", known_value(curve, curve.worst_temp_c)},
          {"rmse_abs", known_value(curve, curve.rmse_abs * factor)},
          {"rmse_shape", known_value(curve, curve.rmse_shape * factor)},
          {"guard", known_value(curve, curve.guard * factor)},
          {"guard_factor", known_value(curve, curve.guard_factor)},
          {"not_stated", curve.not_stated},
          {"limit", curve.limit ? json(*curve.limit * factor) : json()},
          {"rows", curve.rows},
          {"covered", curve.covered},
          {"temps_c", curve.temps_c},
          {"shape_against_ci95", band_document(curve.shape_band)}};
}

json sensor_document(calib::Sensor sensor, const calib::SensorVerification& result) {
  json document = curve_document(result, calib::printed_per_si(sensor));
  document["fresh_against_pi95"] = band_document(result.fresh_band);
  document["bias_verdict"] = calib::name_of(result.bias_verdict);
  document["relative"] = result.relative;
  document["scale"] = result.scale ? curve_document(*result.scale, 1.0) : json();
  return document;
}

json runs_json(const Judgement& judgement) {
  json list = json::array();
  for (const db::RunRow& run : judgement.runs) {
    list.push_back({{"run_id", run.run_id}, {"label", run.label}, {"content_sha256", run.content_sha256}});
  }
  return list;
}

json references_json(const Judgement& judgement) {
  json list = json::array();
  for (const calib::ReferenceUse& use : judgement.references) {
    const calib::Reference& reference = use.reference;
    list.push_back({{"record_id", reference.record_id},
                    {"kind", calib::name_of(reference.kind)},
                    {"name", reference.name},
                    {"certificate", reference.certificate},
                    {"due", iso_date(reference.due_utc_s)}});
  }
  return list;
}

json sensors_json(const calib::Verification& verification) {
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& result = verification.sensors[calib::index_of(sensor)];
    if (result) sensors[std::string(calib::name_of(sensor))] = sensor_document(sensor, *result);
  }
  return sensors;
}

/// The bytes of what is read from a file, without signature and mark.
base::Result<base::Bytes> unmarked_bytes(calib::Calibration as_read) {
  as_read.unreleased = false;
  return calib::encode(as_read);
}

/// What a model in that state becomes by a verdict; nothing where it stays as it is.
std::optional<std::string> next_state(const std::string& state, calib::Verdict verdict) {
  if (state == "fitted" && verdict == calib::Verdict::pass) return "verified";
  if (state == "verified" && verdict != calib::Verdict::pass) return "fitted";
  return std::nullopt;
}

}  // namespace

base::Result<Judgement> verify_against(const db::Catalog& catalog, calib::Calibration calibration,
                                       const std::string& campaign, KnownLimits limits) {
  Judgement judgement{std::move(calibration), std::move(limits), campaign, {}, {}, {}, {}, now_utc_s()};
  std::vector<calib::Warning> warnings;
  auto fresh = load_fresh(catalog, judgement);
  if (!fresh) return base::forward_error(fresh);
  judgement.references = fresh->references;
  for (calib::Warning& warning : unit_type_warnings(fresh->type.name)) warnings.push_back(std::move(warning));
  calib::leave_out_copies(fresh->runs, warnings);
  // As soak_apply_history and soak_apply_moving do on the device.
  judgement.terms = calib::moving_terms(judgement.calibration);
  if (auto taken = take_terms_off(catalog, judgement.terms, *fresh, warnings); !taken)
    return base::forward_error(taken);
  auto verification = calib::verify(judgement.calibration, *fresh, judgement.limits.limits);
  if (!verification) return base::forward_error(verification);
  const auto since = warnings_since(catalog, judgement);
  if (!since) return base::forward_error(since);
  std::ranges::copy(warnings, std::back_inserter(verification->warnings));
  std::ranges::copy(*since, std::back_inserter(verification->warnings));
  std::ranges::copy(waiver_warnings(judgement.calibration.references), std::back_inserter(verification->warnings));
  judgement.verification = *std::move(verification);
  return judgement;
}

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

nlohmann::json judgement_json(const Judgement& judgement) {
  json corrected = json::array();
  for (const calib::ModelTerm& term : judgement.terms) corrected.push_back(term.name);
  json warnings = json::array();
  for (const calib::Warning& warning : judgement.verification.warnings) {
    warnings.push_back({{"code", warning.code}, {"text", warning.text}});
  }
  const std::optional<std::string>& limits = judgement.limits.source;
  return {{"unit", judgement.calibration.unit},
          {"model", judgement.calibration.model_version},
          {"verdict", calib::name_of(judgement.verification.verdict)},
          {"decision_rule",
           {{"guard_coverage", calib::kGuardCoverage},
            {"false_acceptance_max", calib::kFalseAcceptance},
            {"text", decision_rule(judgement.verification)}}},
          {"limits", limits ? json(*limits) : json()},
          {"campaign", judgement.campaign},
          {"runs", runs_json(judgement)},
          {"references", references_json(judgement)},
          {"software", software_version()},
          {"moving_terms", std::move(corrected)},
          {"impact", impact_with_drives_json(judgement.calibration)},
          {"sensors", sensors_json(judgement.verification)},
          {"warnings", std::move(warnings)}};
}

base::Result<std::optional<db::ModelHead>> stored_model_of(const db::Catalog& catalog,
                                                           const calib::Calibration& calibration) {
  const auto heads = catalog.models(calibration.unit);
  if (!heads) return base::forward_error(heads);
  const auto head = std::ranges::find(*heads, calibration.model_version, &db::ModelHead::version);
  if (head == heads->end()) return std::optional<db::ModelHead>();
  const auto model = catalog.model(calibration.unit, calibration.model_version);
  if (!model) return base::forward_error(model);
  const auto stored = calib::calibration_of((*model)->document);
  if (!stored) return base::forward_error(stored);
  // Both once through the format: to encode again what was read need not give the same bytes.
  const auto file = calib::encode(*stored);
  if (!file) return base::forward_error(file);
  const auto as_read = calib::decode(*file);
  if (!as_read) return base::forward_error(as_read);
  const auto there = unmarked_bytes(*as_read);
  if (!there) return base::forward_error(there);
  const auto here = unmarked_bytes(calibration);
  if (!here) return base::forward_error(here);
  return *there == *here ? std::optional(*head) : std::nullopt;
}

base::Result<StoredJudgement> store_judgement(db::Catalog& catalog, const Judgement& judgement,
                                              const nlohmann::json& document) {
  const calib::Calibration& calibration = judgement.calibration;
  StoredJudgement stored{false, "", "the file is not the whole of a model of this data folder"};
  if (catalog.read_only()) {
    const auto head = stored_model_of(catalog, calibration);
    if (!head) return base::forward_error(head);
    return *head ? StoredJudgement{false, (*head)->state, "the data folder can only be read"} : stored;
  }
  const calib::Verdict said = judgement.verification.verdict;
  const std::string name(calib::name_of(said));
  const std::string user = user_name();
  const std::string text = document.dump();
  const auto done = catalog.all_or_nothing([&]() -> base::Status {
    const auto head = stored_model_of(catalog, calibration);
    if (!head) return base::forward_error(head);
    if (!*head) return {};
    const auto& [unit, version, epoch, created_utc_s, state] = **head;
    stored = {true, state, ""};
    if (auto added = catalog.add_verification({unit, version, judgement.read_utc_s, user, name, text}); !added) {
      return added;
    }
    const auto next = next_state(state, said);
    if (!next) return {};
    stored.state = *next;
    return catalog.set_model_state({unit, version, *next,
                                    fmt::format("verification against campaign {}: {}", judgement.campaign, name), user,
                                    now_utc_s()});
  });
  if (!done) return base::forward_error(done);
  return stored;
}

}  // namespace soak::station
