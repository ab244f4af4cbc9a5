// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/release/release_rule.h"

namespace soak::station {
namespace {

/// soak release (--unit SN | --all) [--user NAME]
struct ReleaseCommand final : CatalogCommand {
  std::string unit;  ///< empty with `all`
  bool all = false;
  std::string user;  ///< who releases; empty = the user that runs the program

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit");
    options.add("--all", &all, "The newest models of all units, those that keep the rule").excludes("--unit");
    options.require_one_of({"--unit", "--all"}, "--unit SN or --all");
    options.add("--user NAME", &user, "Who releases (default: the user that runs the program)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// What is written into the history of a model that is released.
std::string release_reason(const ReleaseCase& release) {
  const auto& [row, campaign, limits, runs] = *release.verification;
  return fmt::format(
      "verified {} against campaign {} with the limits of {}: {}; {}", base::utc_text(row.utc_s), campaign, limits,
      row.verdict, release.expires_utc_s ? "good until " + iso_date(*release.expires_utc_s) : "no reference is stated");
}

/// The newest models of the units that are asked for.
base::Result<std::vector<db::ModelHead>> newest_models(const db::Catalog& catalog, const ReleaseCommand& command) {
  if (!command.all) {
    const auto model = usable_model(catalog, command.unit, std::nullopt);
    if (!model) return base::forward_error(model);
    const auto head = model_head(catalog, command.unit, model->version);
    if (!head) return base::forward_error(head);
    return std::vector{*head};
  }
  const auto heads = catalog.models();
  if (!heads) return base::forward_error(heads);
  std::vector<db::ModelHead> newest;
  for (const db::ModelHead& head : *heads) {
    if (!newest.empty() && newest.back().unit == head.unit) newest.pop_back();
    newest.push_back(head);
  }
  if (newest.empty()) return base::bad_input("no unit has a model yet: run 'soak fit --all' first");
  return newest;
}

/// Judges a model and releases it where it keeps the rule; one that is released stays as it is, unless nothing is in
/// its way but that it has to be released again.
base::Result<ReleaseCase> release_one(db::Catalog& catalog, const db::ModelHead& head, const std::string& user) {
  const double now = now_utc_s();
  base::Result<ReleaseCase> release;
  // One transaction: what others enter meanwhile comes before the judgement or after the release.
  const auto done = catalog.all_or_nothing([&]() -> base::Status {
    const auto now_head = model_head(catalog, head.unit, head.version);
    if (!now_head) return base::forward_error(now_head);
    release = judge_release(catalog, *now_head, now);
    if (!release) return base::forward_error(release);
    const bool is_again = release->is_to_be_released_again && release->obstacles.size() == 1;
    if (!is_again && (!release->obstacles.empty() || now_head->state == "released")) return {};
    if (interrupted()) {
      return base::fail(base::ErrorKind::internal, "interrupted: not released; what was released before it stays so",
                        head.unit);
    }
    release->head.state = "released";
    release->obstacles.clear();
    return catalog.set_model_state({head.unit, head.version, "released", release_reason(*release), user, now});
  });
  if (!done) return base::forward_error(done);
  return release;
}

nlohmann::json release_json(const ReleaseCase& release) {
  return {{"unit", release.head.unit},
          {"model", release.head.version},
          {"state", release.head.state},
          {"simulated", release.calibration.simulated},
          {"expires", release.expires_utc_s ? nlohmann::json(iso_date(*release.expires_utc_s)) : nlohmann::json()},
          {"obstacles", release.obstacles}};
}

/// Of a model whose records cannot be read: that is in the way of this one and of no other.
nlohmann::json damaged_json(const db::ModelHead& head, const base::Error& error) {
  return {{"unit", head.unit},           {"model", head.version},
          {"state", head.state},         {"simulated", nlohmann::json()},
          {"expires", nlohmann::json()}, {"obstacles", nlohmann::json::array({error.message})}};
}

/// What became of the models that a release came to.
class ReleaseTally {
 public:
  void add(const ReleaseCase& release) {
    documents_.push_back(release_json(release));
    table_.push_back(
        {release.head.unit, std::to_string(release.head.version), release.head.state,
         release.expires_utc_s ? iso_date(*release.expires_utc_s) : "-",
         fmt::format("{}{}", release.calibration.simulated ? "SIMULATED " : "", fmt::join(release.obstacles, "; "))});
  }
  void add_damaged(const db::ModelHead& head, const base::Error& error) {
    documents_.push_back(damaged_json(head, error));
    table_.push_back({head.unit, std::to_string(head.version), head.state, "-", error.message});
    damaged_.push_back(head.unit);
  }
  [[nodiscard]] const std::vector<std::string>& damaged() const { return damaged_; }
  [[nodiscard]] base::Status print(Output& output) {
    if (documents_.empty()) return {};
    if (output.json()) return output.print_json({{"units", std::move(documents_)}});
    output.print(text_table(table_));
    return {};
  }

 private:
  nlohmann::json documents_ = nlohmann::json::array();
  std::vector<std::vector<std::string>> table_ = {{"unit", "model", "state", "good until", ""}};
  std::vector<std::string> damaged_;
};

base::Status ReleaseCommand::run_with(db::Catalog& catalog, Output& output) {
  const std::string signer = user_name(user);
  if (auto line = check_text_line(signer, "--user"); !line) return line;
  const auto heads = newest_models(catalog, *this);
  if (!heads) return base::forward_error(heads);
  ReleaseTally tally;
  base::Status ended;
  for (const db::ModelHead& head : *heads) {
    const auto release = release_one(catalog, head, signer);
    if (!release && all && release.error().kind == base::ErrorKind::corrupt) {
      tally.add_damaged(head, release.error());
      continue;
    }
    if (!release) {
      ended = base::forward_error(release);
      break;
    }
    if (!all && !release->obstacles.empty()) {
      return base::bad_input(
          fmt::format("model {} may not be released: {}", head.version, fmt::join(release->obstacles, "; ")),
          head.unit);
    }
    tally.add(*release);
  }
  // What was released stays so, and is told, whatever came after it.
  if (auto printed = tally.print(output); !printed) return printed;
  if (!ended) return ended;
  const std::vector<std::string>& damaged = tally.damaged();
  if (damaged.empty()) return {};
  return base::fail(base::ErrorKind::corrupt,
                    fmt::format("records of {} of {} units are damaged, and these were not released: {}",
                                damaged.size(), heads->size(), fmt::join(damaged, ", ")));
}

}  // namespace

CommandGroup release_commands() {
  return {"",
          "",
          {{"release", "Release models that passed their verification and rest on nothing that was withdrawn since",
            "soak release --all --user eva", std::make_shared<ReleaseCommand>()}}};
}

}  // namespace soak::station
