// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/text.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/release/release_rule.h"

namespace soak::station {
namespace {

/// soak model list [--unit SN]
struct ModelList final : CatalogCommand {
  std::optional<std::string> unit;

  void declare(OptionList& options) override { options.add("--unit SN", &unit, "Only models of this unit"); }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak model show --unit SN [--model V]
struct ModelShow final : CatalogCommand {
  std::string unit;
  std::optional<int> model;  ///< version; absent = the newest

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit").required();
    options.add("--model V", &model, "Model version (default: the newest)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

/// soak model retire --unit SN --model V --reason TEXT [--user NAME]
struct ModelRetire final : CatalogCommand {
  std::string unit;
  int model = 0;
  std::string reason;
  std::string user;  ///< empty = the user that runs the program

  void declare(OptionList& options) override {
    options.add("--unit SN", &unit, "Serial number of the unit").required();
    options.add("--model V", &model, "Model version").required();
    options.add("--reason TEXT", &reason, "Why nobody may use it any more").required();
    options.add("--user NAME", &user, "Name for the record (default: the user that runs the program)");
  }
  base::Status run_with(db::Catalog& catalog, Output& output) override;
};

nlohmann::json head_json(const db::ModelHead& head) {
  return {{"unit", head.unit},
          {"model", head.version},
          {"epoch", head.epoch},
          {"created_utc", base::utc_text(head.created_utc_s)},
          {"state", head.state}};
}

base::Status ModelList::run_with(db::Catalog& catalog, Output& output) {
  if (unit) {
    if (const auto known = find_unit(catalog, *unit); !known) return base::forward_error(known);
  }
  const auto heads = catalog.models(unit);
  if (!heads) return base::forward_error(heads);
  nlohmann::json list = nlohmann::json::array();
  std::vector<std::vector<std::string>> table = {{"unit", "model", "epoch", "fitted", "state"}};
  for (const db::ModelHead& head : *heads) {
    list.push_back(head_json(head));
    table.push_back({head.unit, std::to_string(head.version), std::to_string(head.epoch),
                     base::utc_text(head.created_utc_s), head.state});
  }
  if (output.json()) return output.print_json({{"models", std::move(list)}});
  output.print(text_table(table));
  return {};
}

nlohmann::json history_json(const std::vector<db::ModelStateRow>& history) {
  nlohmann::json list = nlohmann::json::array();
  for (const db::ModelStateRow& row : history) {
    list.push_back(
        {{"state", row.state}, {"utc", base::utc_text(row.utc_s)}, {"user", row.user}, {"reason", row.reason}});
  }
  return list;
}

/// Each verification as it was stored, with when and by whom it was made.
nlohmann::json verifications_json(const std::vector<db::VerificationRow>& verifications) {
  nlohmann::json list = nlohmann::json::array();
  for (const db::VerificationRow& row : verifications) {
    const auto document = nlohmann::json::parse(row.document, nullptr, false);
    list.push_back(
        {{"utc", base::utc_text(row.utc_s)},
         {"user", row.user},
         {"verdict", row.verdict},
         {"campaign", document.is_object() ? document.value("campaign", nlohmann::json()) : nlohmann::json()},
         {"document", document.is_discarded() ? nlohmann::json() : document}});
  }
  return list;
}

std::string show_text(const nlohmann::json& document) {
  std::vector<std::vector<std::string>> table = {{"utc", "by", "", ""}};
  for (const auto& row : document["history"]) table.push_back({row["utc"], row["user"], row["state"], row["reason"]});
  std::vector<std::vector<std::string>> verifications = {{"verified", "by", "verdict", "campaign"}};
  for (const auto& row : document["verifications"]) {
    const auto& campaign = row["campaign"];
    verifications.push_back({row["utc"], row["user"], row["verdict"], campaign.is_string() ? campaign : ""});
  }
  return fmt::format("unit {}, model {}, epoch {}: {}\n{}{}", document["unit"].get<std::string>(),
                     document["model"].get<int>(), document["epoch"].get<int>(), document["state"].get<std::string>(),
                     text_table(table), verifications.size() > 1 ? text_table(verifications) : "never verified\n");
}

base::Status ModelShow::run_with(db::Catalog& catalog, Output& output) {
  if (!model) {
    const auto newest = usable_model(catalog, unit, std::nullopt);
    if (!newest) return base::forward_error(newest);
    model = newest->version;
  }
  const auto head = model_head(catalog, unit, *model);
  if (!head) return base::forward_error(head);
  const auto history = catalog.model_history(unit, *model);
  if (!history) return base::forward_error(history);
  const auto verifications = catalog.verifications(unit, *model);
  if (!verifications) return base::forward_error(verifications);
  nlohmann::json document = head_json(*head);
  document["history"] = history_json(*history);
  document["verifications"] = verifications_json(*verifications);
  if (output.json()) return output.print_json(document);
  output.print(show_text(document));
  return {};
}

base::Status ModelRetire::run_with(db::Catalog& catalog, Output& output) {
  const std::string name = user_name(user);
  if (auto line = check_text_line(reason, "--reason"); !line) return line;
  if (auto line = check_text_line(name, "--user"); !line) return line;
  const auto head = model_head(catalog, unit, model);
  if (!head) return base::forward_error(head);
  auto done = catalog.set_model_state({unit, head->version, "withdrawn", reason, name, now_utc_s()});
  if (!done) return done;
  db::ModelHead withdrawn = *head;
  withdrawn.state = "withdrawn";
  if (output.json()) return output.print_json(head_json(withdrawn));
  output.print(fmt::format("unit {}, model {}: withdrawn (it was {})\n", unit, head->version, head->state));
  return {};
}

}  // namespace

CommandGroup model_commands() {
  return {"model",
          "Versions of the units' models, and what became of them",
          {{"list", "List the models with their states: fitted, verified, released, withdrawn", "soak model list",
            std::make_shared<ModelList>()},
           {"show", "Show what became of a model: changes of its state, verifications", "soak model show --unit SN0042",
            std::make_shared<ModelShow>()},
           {"retire", "Withdraw a model: nobody may use it any more",
            "soak model retire --unit SN0042 --model 2 --reason 'chamber door was open'",
            std::make_shared<ModelRetire>()}}};
}

}  // namespace soak::station
