// SPDX-License-Identifier: Apache-2.0
#include "station/release/release_rule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calib/model/model_document.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/io/text.h"
#include "station/records/calibration_reader.h"
#include "station/release/fitted_runs.h"
#include "station/report/unit_overview.h"

namespace soak::station {
namespace {

/// What a record says, each member of its type; nothing for one that is damaged.
std::optional<LastVerification> read_record(db::VerificationRow row) {
  const auto document = nlohmann::json::parse(row.document, nullptr, false);
  if (!document.is_object()) return std::nullopt;
  const nlohmann::json campaign = document.value("campaign", nlohmann::json());
  const nlohmann::json limits = document.value("limits", nlohmann::json());
  const nlohmann::json runs = document.value("runs", nlohmann::json());
  if (!campaign.is_string() || !(limits.is_string() || limits.is_null()) || !runs.is_array()) return std::nullopt;
  LastVerification last{
      std::move(row), campaign.get<std::string>(), limits.is_string() ? limits.get<std::string>() : "", {}};
  for (const auto& run : runs) {
    if (!run.is_object() || !run.contains("run_id") || !run["run_id"].is_string()) return std::nullopt;
    last.runs.push_back(run["run_id"]);
  }
  return last;
}

base::Result<std::optional<LastVerification>> last_verification(const db::Catalog& catalog, const db::ModelHead& head) {
  auto rows = catalog.verifications(head.unit, head.version);
  if (!rows) return base::forward_error(rows);
  if (rows->empty()) return std::optional<LastVerification>();
  auto last = read_record(std::move(rows->back()));
  if (!last) {
    return base::corrupt(fmt::format("the last verification of model {} of unit {} is damaged: verify it again",
                                     head.version, head.unit),
                         catalog.data_folder().string());
  }
  return last;
}

/// Whether it passed.
std::optional<std::string> not_passed(const ReleaseCase& release) {
  const db::ModelHead& head = release.head;
  if (!release.verification) {
    return fmt::format("it was never verified: 'soak verify --unit {} --campaign NAME'", head.unit);
  }
  const auto& [row, campaign, limits, runs] = *release.verification;
  if (row.verdict == "pass") return std::nullopt;
  const std::string remedy = row.verdict == "info" ? "set limits for every sensor and verify it again"
                                                   : "fit again, or verify it against other fresh runs";
  return fmt::format("its last verification, against campaign '{}', says {}, not pass: {}", campaign, row.verdict,
                     remedy);
}

/// A release ends with the first verification after it that does not pass, whatever the next one says.
base::Status add_release_again(const db::Catalog& catalog, ReleaseCase& release) {
  const db::ModelHead& head = release.head;
  if (head.state != "released" || !release.verification || release.verification->row.verdict != "pass") return {};
  const auto history = catalog.model_history(head.unit, head.version);
  if (!history) return base::forward_error(history);
  const auto given = std::find_if(history->rbegin(), history->rend(),
                                  [](const db::ModelStateRow& row) { return row.state == "released"; });
  if (given == history->rend()) return {};
  const auto rows = catalog.verifications(head.unit, head.version);
  if (!rows) return base::forward_error(rows);
  const auto failed = std::find_if(rows->rbegin(), rows->rend(), [&](const db::VerificationRow& row) {
    return row.utc_s > given->utc_s && row.verdict != "pass";
  });
  if (failed == rows->rend()) return {};
  release.is_to_be_released_again = true;
  release.obstacles.push_back(
      fmt::format("a verification on {}, after its release, said {}: release it again ('soak release --unit {}')",
                  iso_date(failed->utc_s), failed->verdict, head.unit));
  return {};
}

/// What was withdrawn of the data of the model, in the words of its warnings, and what was not used.
base::Status add_withdrawn(const db::Catalog& catalog, ReleaseCase& release) {
  auto withdrawn = withdrawn_since(catalog, release.calibration);
  if (!withdrawn) return base::forward_error(withdrawn);
  for (const calib::Warning& warning : *withdrawn) release.obstacles.push_back(warning.text + ": fit again");
  const auto runs = compare_fitted_runs(catalog, release.calibration);
  if (!runs) return base::forward_error(runs);
  const bool is_told =
      std::ranges::any_of(*withdrawn, [](const auto& warning) { return warning.code == "voided_since"; });
  if (runs->gone > 0 && !is_told) {
    release.obstacles.push_back(fmt::format(
        "{} of the runs that it was fitted to are withdrawn or not in this data folder: fit again", runs->gone));
  }
  if (!runs->left_out.empty()) {
    release.obstacles.push_back(fmt::format("runs for calibration are not in it: {}: fit again with all of them",
                                            fmt::join(runs->left_out, ", ")));
  }
  return {};
}

/// What was withdrawn of the data of its verification, and what never counted for it.
base::Status add_withdrawn_of_verification(const db::Catalog& catalog, ReleaseCase& release) {
  if (!release.verification) return {};
  const std::string& campaign = release.verification->campaign;
  const auto runs = catalog.runs({.unit = release.head.unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  const auto judged_by = [&](const db::RunRow& run) {
    return std::ranges::find(release.verification->runs, run.run_id) != release.verification->runs.end();
  };
  if (!release.calibration.simulated &&
      std::ranges::any_of(*runs, [&](const db::RunRow& run) { return run.simulated && judged_by(run); })) {
    release.obstacles.push_back(fmt::format(
        "it was measured, and runs of campaign '{}' are SIMULATED: verify it against measured runs", campaign));
  }
  const auto since = withdrawn_since_start(catalog, release.head.unit, campaign, release.verification->row.utc_s);
  if (!since) return base::forward_error(since);
  if (*since || std::ranges::any_of(*runs, [&](const db::RunRow& run) { return run.voided && judged_by(run); })) {
    release.obstacles.push_back(fmt::format(
        "runs of campaign '{}' were withdrawn after it was verified against them: verify it again", campaign));
  }
  const auto references = references_of_campaigns(catalog, {campaign});
  if (!references) return base::forward_error(references);
  const auto warnings = reference_warnings(catalog, *references);
  if (!warnings) return base::forward_error(warnings);
  for (const calib::Warning& warning : *warnings) {
    const auto is_told = [&](const std::string& told) { return told.starts_with(warning.text); };
    if (std::ranges::any_of(release.obstacles, is_told)) continue;
    release.obstacles.push_back(warning.text + ": verify it against newer runs");
  }
  return {};
}

/// A waiver has taken the place of the due date of its reference.
void add_expiry(ReleaseCase& release, double now_utc_s) {
  const calib::Reference* first = nullptr;
  for (const calib::ReferenceUse& use : release.calibration.references) {
    if (!use.waiver && (first == nullptr || use.reference.due_utc_s < first->due_utc_s)) first = &use.reference;
  }
  if (first == nullptr) return;
  release.expires_utc_s = first->due_utc_s;
  if (first->due_utc_s > now_utc_s) return;
  release.obstacles.push_back(fmt::format("{} was due on {}: record with a newer certificate and fit again",
                                          describe(*first), iso_date(first->due_utc_s)));
}

/// What its state and its epoch say.
base::Status add_of_unit(const db::Catalog& catalog, ReleaseCase& release) {
  const db::ModelHead& head = release.head;
  if (head.state == "withdrawn") release.obstacles.emplace_back("it is withdrawn: fit again");
  const auto unit = find_unit(catalog, head.unit);
  if (!unit) return base::forward_error(unit);
  if (unit->epoch != head.epoch) {
    release.obstacles.push_back(
        fmt::format("it belongs to epoch {}, the unit is in epoch {}: fit again", head.epoch, unit->epoch));
  }
  return {};
}

}  // namespace

base::Result<db::ModelRow> usable_model(const db::Catalog& catalog, const std::string& unit,
                                        std::optional<std::int32_t> version) {
  const auto known = find_unit(catalog, unit);
  if (!known) return base::forward_error(known);
  auto row = catalog.model(unit, version);
  if (!row) return base::forward_error(row);
  if (!*row) {
    return base::bad_input(version
                               ? fmt::format("unit {} has no model version {}", unit, *version)
                               : fmt::format("unit {} has no model yet; run 'soak fit --unit {}' first", unit, unit));
  }
  if ((*row)->epoch != known->epoch) {
    return base::bad_input(
        fmt::format("model {} of unit {} belongs to epoch {}, but the unit is now in epoch {}: fit "
                    "again",
                    (*row)->version, unit, (*row)->epoch, known->epoch));
  }
  return **std::move(row);
}

base::Result<db::ModelHead> model_head(const db::Catalog& catalog, const std::string& unit, std::int32_t version) {
  if (const auto known = find_unit(catalog, unit); !known) return base::forward_error(known);
  const auto heads = catalog.models(unit);
  if (!heads) return base::forward_error(heads);
  const auto head = std::ranges::find(*heads, version, &db::ModelHead::version);
  if (head != heads->end()) return *head;
  return base::bad_input(
      fmt::format("unit {} has no model version {}: 'soak model list --unit {}' shows them", unit, version, unit));
}

base::Result<std::optional<db::ModelHead>> newest_released(const db::Catalog& catalog, const std::string& unit) {
  const auto heads = catalog.models(unit);
  if (!heads) return base::forward_error(heads);
  std::optional<db::ModelHead> newest;
  for (const db::ModelHead& head : *heads) {
    if (head.state == "released") newest = head;
  }
  return newest;
}

base::Result<std::string> not_released_text(const db::Catalog& catalog, const db::ModelHead& head) {
  const auto released = newest_released(catalog, head.unit);
  if (!released) return base::forward_error(released);
  const std::string way =
      head.state == "fitted"
          ? fmt::format("verify it and release it ('soak verify', 'soak release --unit {}')", head.unit)
      : head.state == "verified" ? fmt::format("release it ('soak release --unit {}')", head.unit)
                                 : std::string("fit again");
  return fmt::format(
      "model {} of unit {} is {}, not released: {}{}, or export it with --unreleased, which marks the "
      "file",
      head.version, head.unit, head.state, way,
      *released ? fmt::format(", take the released one (--model {})", (*released)->version) : "");
}

base::Result<ReleaseCase> judge_release(const db::Catalog& catalog, const db::ModelHead& head, double now_utc_s) {
  const auto model = catalog.model(head.unit, head.version);
  if (!model) return base::forward_error(model);
  auto calibration = calib::calibration_of((*model)->document);
  if (!calibration) return base::forward_error(calibration);
  auto verification = last_verification(catalog, head);
  if (!verification) return base::forward_error(verification);
  ReleaseCase release{head, *std::move(calibration), *std::move(verification), {}, {}, false};
  if (auto added = add_of_unit(catalog, release); !added) return base::forward_error(added);
  if (auto what = not_passed(release)) release.obstacles.push_back(*std::move(what));
  if (auto added = add_release_again(catalog, release); !added) return base::forward_error(added);
  if (auto added = add_withdrawn(catalog, release); !added) return base::forward_error(added);
  if (auto added = add_withdrawn_of_verification(catalog, release); !added) return base::forward_error(added);
  add_expiry(release, now_utc_s);
  return release;
}

base::Result<std::vector<db::ModelHead>> released_with(const db::Catalog& catalog, const std::string& record_id,
                                                       double now_utc_s) {
  const auto heads = catalog.models();
  if (!heads) return base::forward_error(heads);
  const auto has_entry = [&](const std::vector<calib::ReferenceUse>& uses) {
    return std::ranges::any_of(uses,
                               [&](const calib::ReferenceUse& use) { return use.reference.record_id == record_id; });
  };
  std::vector<db::ModelHead> found;
  for (const db::ModelHead& head : *heads) {
    if (head.state != "released") continue;
    const auto release = judge_release(catalog, head, now_utc_s);
    if (!release && release.error().kind != base::ErrorKind::corrupt) return base::forward_error(release);
    if (!release || !release->obstacles.empty()) continue;
    const auto of_check = references_of_campaigns(catalog, {release->verification->campaign});
    if (!of_check) return base::forward_error(of_check);
    if (has_entry(release->calibration.references) || has_entry(*of_check)) found.push_back(head);
  }
  return found;
}

}  // namespace soak::station
