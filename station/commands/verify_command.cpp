// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
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
  std::string keep;         ///< of all: results are appended to it as they are known; empty = nowhere

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
  options
      .add("--keep FILE", &keep,
           "Append to FILE what becomes of each unit as soon as it is known, a JSON document a line: it is "
           "left when the command is killed")
      .needs("--all");
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
  output.begin("verifying");
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

/// Why a unit with runs in the campaign is left out: it cannot be verified as it is, and that is no mistake. Empty: it
/// is not.
base::Result<std::string> why_skipped(const db::Catalog& catalog, const std::string& serial,
                                      const std::vector<db::RunRow>& runs) {
  const auto unit = catalog.unit(serial);
  if (!unit) return base::forward_error(unit);
  const auto model = catalog.model(serial);
  if (!model) return base::forward_error(model);
  if (!*model) return std::string("it has no model yet");
  if ((*model)->epoch != (*unit)->epoch) return std::string("it was repaired or changed after its newest model");
  const bool is_of_now = std::ranges::any_of(
      runs, [&](const db::RunRow& run) { return run.unit == serial && run.epoch == (*unit)->epoch; });
  return std::string(is_of_now ? "" : "it was repaired or changed after its runs in the campaign");
}

base::Result<std::vector<db::RunRow>> runs_of_campaign(const db::Catalog& catalog, const std::string& campaign) {
  if (auto known = check_campaign_known(catalog, campaign); !known) return base::forward_error(known);
  return catalog.runs({.unit = {}, .campaign = campaign, .run = {}});
}

std::vector<std::string> units_of(const std::vector<db::RunRow>& runs) {
  std::vector<std::string> units;
  for (const db::RunRow& run : runs) units.push_back(run.unit);
  std::ranges::sort(units);
  units.erase(std::unique(units.begin(), units.end()), units.end());
  return units;
}

/// What became of all units.
class AllJudged {
 public:
  /// `kept`: each result is appended to this file as it is known, a JSON document a line; empty: to none.
  AllJudged(Output& output, const std::string& kept) : output_(output) {
    if (!kept.empty()) kept_.open(kept, std::ios::app);
  }

  /// Whether what is to be kept can be written.
  [[nodiscard]] bool keeps() const { return kept_.good(); }
  void judged(const Judged& one, std::int32_t version) {
    const auto& [judgement, stored, document] = one;
    const std::string unit = document.at("unit");
    const calib::Verdict verdict = judgement.verification.verdict;
    if (verdict == calib::Verdict::fail) failed_.push_back(unit);
    table_.push_back({unit, std::to_string(version), std::string(calib::name_of(verdict)), stored.state,
                      judgement.limits.source.value_or("none")});
    add("units", document);
  }
  void skipped(const std::string& unit, const std::string& why) {
    if (!output_.json()) output_.note(fmt::format("{}: left out: {}", unit, why));
    add("skipped", {{"unit", unit}, {"message", why}});
  }
  void not_verified(const std::string& unit, base::Error error) {
    add("not_verified", {{"unit", unit}, {"message", error.message}});
    error.where = error.where.empty() ? unit : fmt::format("{}, {}", unit, error.where);
    failures_.push_back(std::move(error));
  }

  [[nodiscard]] base::Status print() const {
    if (output_.json()) return output_.print_json(document_);
    output_.print(text_table(table_));
    return {};
  }
  /// Those that could not be compared come before those that fail: nothing is known of them.
  [[nodiscard]] base::Status status() const {
    const std::size_t units = failures_.size() + document_["units"].size();
    if (!failures_.empty()) {
      std::string message = fmt::format("{} of {} units could not be verified:", failures_.size(), units);
      for (const base::Error& error : failures_) message += fmt::format("\n  {}: {}", error.where, error.message);
      return base::fail(failures_.front().kind, std::move(message));
    }
    if (units == 0 && !document_["skipped"].empty()) {
      return base::bad_input("no unit of the campaign can be verified as it is: each has no model, or was repaired");
    }
    if (failed_.empty()) return {};
    return base::fail(base::ErrorKind::limits, fmt::format("{} of {} units exceed their limits: {}", failed_.size(),
                                                           units, fmt::join(failed_, ", ")));
  }

 private:
  void add(const char* list, nlohmann::json entry) {
    if (kept_.is_open()) {
      const nlohmann::json line = {{list, entry}};
      kept_ << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n' << std::flush;
    }
    document_[list].push_back(std::move(entry));
  }

  Output& output_;
  std::ofstream kept_;
  nlohmann::json document_ = {{"units", nlohmann::json::array()},
                              {"skipped", nlohmann::json::array()},
                              {"not_verified", nlohmann::json::array()}};
  std::vector<std::vector<std::string>> table_ = {{"unit", "model", "verdict", "state", "limits"}};
  std::vector<base::Error> failures_;
  std::vector<std::string> failed_;
};

/// One unit of all: an error is about this one only.
base::Status verify_one_of_all(db::Catalog& catalog, const VerifyCommand& command, const std::string& unit,
                               const std::vector<db::RunRow>& runs, AllJudged& all, Output& output) {
  const auto why = why_skipped(catalog, unit, runs);
  if (!why) return base::forward_error(why);
  if (!why->empty()) {
    all.skipped(unit, *why);
    return {};
  }
  const auto calibration = newest_of(catalog, unit);
  if (!calibration) return base::forward_error(calibration);
  const auto judged = judge(catalog, command, *calibration, output);
  if (!judged) return base::forward_error(judged);
  all.judged(*judged, calibration->model_version);
  return {};
}

base::Status verify_all(db::Catalog& catalog, const VerifyCommand& command, Output& output) {
  const auto runs = runs_of_campaign(catalog, command.campaign);
  if (!runs) return base::forward_error(runs);
  const auto units = units_of(*runs);
  AllJudged all(output, command.keep);
  if (!all.keeps()) return base::fail(base::ErrorKind::internal, "cannot be written", command.keep);
  base::Status ended;
  const auto progress = output.progress("verifying");
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (!progress(static_cast<double>(i) / static_cast<double>(units.size()))) {
      ended = base::fail(base::ErrorKind::internal, "interrupted; the verdicts so far are stored", "verify");
      break;
    }
    if (auto one = verify_one_of_all(catalog, command, units[i], *runs, all, output); !one) {
      all.not_verified(units[i], one.error());
    }
  }
  output.end_progress();
  if (auto printed = all.print(); !printed) return printed;
  return ended ? all.status() : ended;
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
