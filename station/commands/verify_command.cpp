// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/deploy/calibration_file.h"
#include "calib/judge/verification.h"
#include "calib/model/model_document.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/commands/verify_text.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_unit.h"
#include "station/records/calibration_reader.h"
#include "station/release/judgement.h"
#include "station/release/release_rule.h"

namespace soak::station {
namespace {

/// soak verify (FILE.blob | --unit SN | --all) --campaign NAME [--limits FILE]
struct VerifyCommand final : CatalogCommand {
  std::string file;
  std::string unit;  ///< its newest model instead of a file
  bool all = false;  ///< those of all units of the campaign
  std::string campaign;
  std::string limits_file;  ///< empty = limits of the unit's type

  void declare(OptionList& options) override;
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

void VerifyCommand::declare(OptionList& options) {
  options.add("file FILE.blob", &file, "Calibration file");
  options.add("--unit SN", &unit, "The newest model of this unit, as its file would be").excludes("file");
  options.add("--all", &all, "The newest models of all units with runs in the campaign")
      .excludes("file")
      .excludes("--unit");
  options.require_one_of({"file", "--unit", "--all"}, "FILE.blob, --unit SN or --all");
  options.add("--campaign NAME", &campaign, "Campaign of the fresh runs").required();
  options.add("--limits FILE", &limits_file,
              "Limits per sensor (TOML; default: those of the unit's type); without limits the verdict is 'info'");
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

/// The newest model of a unit as a device would read it: in float32.
base::Result<calib::Calibration> newest_of(const db::Catalog& catalog, const std::string& unit) {
  const auto model = usable_model(catalog, unit, std::nullopt);
  if (!model) return base::forward_error(model);
  auto calibration = calib::calibration_of(model->document);
  if (!calibration) return calibration;
  const auto bytes = calib::encode(*calibration);
  if (!bytes) return base::forward_error(bytes);
  return calib::decode(*bytes);
}

/// What became of a calibration.
struct Judged {
  Judgement judgement;
  StoredJudgement stored;
  nlohmann::json document;  ///< as --json prints it
};

/// Compares, stores and notes what must be told.
base::Result<Judged> judge(db::Catalog& catalog, const VerifyCommand& command, const calib::Calibration& calibration,
                           Output& output) {
  const std::string of_unit = command.all ? calibration.unit + ": " : "";
  auto limits = limits_for(command, calibration);
  if (!limits) return base::forward_error(limits);
  auto judgement = verify_against(catalog, calibration, command.campaign, *std::move(limits));
  if (!judgement) return base::forward_error(judgement);
  nlohmann::json document = judgement_json(*judgement);
  auto stored = store_judgement(catalog, *judgement, document);
  if (!stored) return base::forward_error(stored);
  note_waivers(calibration.references, output, of_unit);
  if (!output.json()) {
    for (const calib::Warning& warning : judgement->verification.warnings) {
      // note_waivers() has told it.
      if (warning.code != "waiver_signature") output.note(fmt::format("{}warning: {}", of_unit, warning.text));
    }
  }
  document["stored"] = stored->stored;
  document["state"] = stored->state.empty() ? nlohmann::json() : nlohmann::json(stored->state);
  return Judged{*std::move(judgement), *std::move(stored), std::move(document)};
}

base::Status verify_one(db::Catalog& catalog, const VerifyCommand& command, Output& output) {
  base::Result<calib::Calibration> calibration;
  if (command.file.empty()) {
    calibration = newest_of(catalog, command.unit);
  } else {
    auto loaded = read_calibration(command.file);
    if (!loaded) return base::forward_error(loaded);
    calibration = std::move(loaded->calibration);
  }
  if (!calibration) return base::forward_error(calibration);
  const auto judged = judge(catalog, command, *calibration, output);
  if (!judged) return base::forward_error(judged);
  const auto& [judgement, stored, document] = *judged;
  if (output.json()) {
    if (auto printed = output.print_json(document); !printed) return printed;
  } else {
    output.print(verify_text(judgement, stored));
  }
  if (judgement.verification.verdict != calib::Verdict::fail) return {};
  return base::fail(base::ErrorKind::limits, "the unit exceeds its limits", calibration->unit);
}

base::Result<std::vector<std::string>> units_of_campaign(const db::Catalog& catalog, const std::string& campaign) {
  if (auto known = check_campaign_known(catalog, campaign); !known) return base::forward_error(known);
  const auto runs = catalog.runs({.unit = {}, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  std::vector<std::string> units;
  for (const db::RunRow& run : *runs) units.push_back(run.unit);
  std::ranges::sort(units);
  units.erase(std::unique(units.begin(), units.end()), units.end());
  return units;
}

/// Those that could not be compared come before those that fail: nothing is known of them.
base::Status status_of_all(const std::vector<base::Error>& failures, const std::vector<std::string>& failed,
                           std::size_t units) {
  if (!failures.empty()) {
    std::string message = fmt::format("{} of {} units could not be verified:", failures.size(), units);
    for (const base::Error& error : failures) {
      message += fmt::format("\n  {}: {}", error.where, error.message);
    }
    return base::fail(failures.front().kind, std::move(message));
  }
  if (failed.empty()) return {};
  return base::fail(base::ErrorKind::limits, fmt::format("{} of {} units exceed their limits: {}", failed.size(), units,
                                                         fmt::join(failed, ", ")));
}

base::Status verify_all(db::Catalog& catalog, const VerifyCommand& command, Output& output) {
  const auto units = units_of_campaign(catalog, command.campaign);
  if (!units) return base::forward_error(units);
  nlohmann::json documents = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"unit", "model", "verdict", "state", "limits"}};
  std::vector<base::Error> failures;
  std::vector<std::string> failed;
  base::Status ended;
  const auto progress = output.progress("verifying");
  for (std::size_t i = 0; i < units->size(); ++i) {
    if (!progress(static_cast<double>(i) / static_cast<double>(units->size()))) {
      ended = base::fail(base::ErrorKind::internal, "interrupted; the verdicts so far are stored", "verify");
      break;
    }
    const auto calibration = newest_of(catalog, (*units)[i]);
    auto judged = calibration ? judge(catalog, command, *calibration, output) : base::forward_error(calibration);
    if (!judged) {
      base::Error error = judged.error();
      error.where = error.where.empty() ? (*units)[i] : fmt::format("{}, {}", (*units)[i], error.where);
      failures.push_back(std::move(error));
      continue;
    }
    auto& [judgement, stored, document] = *judged;
    const calib::Verdict verdict = judgement.verification.verdict;
    if (verdict == calib::Verdict::fail) failed.push_back((*units)[i]);
    documents.push_back(std::move(document));
    table.push_back({(*units)[i], std::to_string(calibration->model_version), std::string(calib::name_of(verdict)),
                     stored.state, judgement.limits.source.value_or("none")});
  }
  output.end_progress();
  if (output.json()) {
    if (auto printed = output.print_json({{"units", std::move(documents)}}); !printed) return printed;
  } else {
    output.print(text_table(table));
  }
  return ended ? status_of_all(failures, failed, units->size()) : ended;
}

base::Status VerifyCommand::run_with(db::Catalog& catalog, Output& output) {
  return all ? verify_all(catalog, *this, output) : verify_one(catalog, *this, output);
}

}  // namespace

CommandGroup verify_commands() {
  return {
      "",
      "",
      {{"verify", "Compare a calibration with runs that no fit has used, and store the verdict",
        "soak verify --unit SN0042 --campaign check-2027 --limits limits.toml", std::make_shared<VerifyCommand>()}}};
}

}  // namespace soak::station
