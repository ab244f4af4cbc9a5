// SPDX-License-Identifier: Apache-2.0
#include "station/http/procedures_api.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "station/config/procedure_changes.h"
#include "station/config/procedure_folder.h"
#include "station/http/members.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

using base::Result;
using nlohmann::json;

struct Asked {
  NewProcedure made;
  std::string user;
  bool is_draft = false;
};

Result<std::optional<int>> runs_member(const json& body) {
  constexpr int kMost = 999;
  const auto runs = count_member(body, "runs");
  if (!runs) return base::forward_error(runs);
  if (*runs && (**runs < 1 || **runs > kMost)) return base::bad_input(fmt::format("1 to {} runs", kMost), "runs");
  return *runs;
}

Result<ProcedureChanges> changes_of(const json& body) {
  auto set_points_c = numbers_member(body, "set_points_c");
  if (!set_points_c) return base::forward_error(set_points_c);
  const auto runs = runs_member(body);
  if (!runs) return base::forward_error(runs);
  const auto dwell_s = number_member(body, "dwell_s");
  if (!dwell_s) return base::forward_error(dwell_s);
  const auto minimum_soak_s = number_member(body, "minimum_soak_s");
  if (!minimum_soak_s) return base::forward_error(minimum_soak_s);
  return ProcedureChanges{*std::move(set_points_c), *runs, *dwell_s, *minimum_soak_s};
}

/// "2026-11-28 07:48 UTC by Eva".
std::string origin_text(double utc_s, const std::string& user) {
  return fmt::format("{:%Y-%m-%d %H:%M} UTC by {}", fmt::gmtime(static_cast<std::time_t>(utc_s)), user);
}

Result<Asked> asked_by(const json& body) {
  if (auto known =
          only_members(body, {"from", "name", "set_points_c", "runs", "dwell_s", "minimum_soak_s", "draft", "user"});
      !known) {
    return base::forward_error(known);
  }
  const auto from = line_member(body, "from", std::nullopt);
  if (!from) return base::forward_error(from);
  const auto name = text_member(body, "name", std::nullopt);
  if (!name) return base::forward_error(name);
  if (auto named = check_procedure_name(*name); !named) return base::forward_error(named);
  auto changes = changes_of(body);
  if (!changes) return base::forward_error(changes);
  const auto draft = body.find("draft");
  if (draft != body.end() && !draft->is_boolean()) return base::bad_input("the member is not true or false", "draft");
  const auto user = carried_member(body, "user");
  if (!user) return base::forward_error(user);
  return Asked{{*from, *name, *std::move(changes), origin_text(now_utc_s(), *user)},
               *user,
               draft != body.end() && draft->get<bool>()};
}

/// A file of which nobody can say later who made it is taken back.
base::Status enter_or_take_back(db::Catalog& catalog, const Asked& asked, const std::filesystem::path& path) {
  const std::string text = fmt::format("from {}: {}", asked.made.from, changes_text(asked.made.changes));
  auto entered = catalog.log_event({now_utc_s(), "procedure_made", asked.made.name, text, asked.user});
  std::error_code ignored;
  if (!entered) std::filesystem::remove(path, ignored);
  return entered;
}

Result<json> carried_out(db::Catalog& catalog, const Asked& asked) {
  const auto folders = procedure_folders(catalog.data_folder());
  const auto source = offered_procedure(folders, asked.made.from);
  if (!source) return base::forward_error(source);
  auto text = changed_procedure(*source, asked.made);
  if (!text) return base::forward_error(text);
  if (auto is_new = check_procedure_is_new(folders, asked.made.name); !is_new) return base::forward_error(is_new);
  if (!asked.is_draft) {
    const auto path = add_procedure(folders, asked.made.name, *text);
    if (!path) return base::forward_error(path);
    if (auto entered = enter_or_take_back(catalog, asked, *path); !entered) return base::forward_error(entered);
  }
  return json{{"file", asked.made.name + ".toml"}, {"text", *std::move(text)}};
}

}  // namespace

Result<json> new_procedure(const StationService&, RunArchive& archive, const json& body) {
  const auto asked = asked_by(body);
  if (!asked) return base::forward_error(asked);
  return archive.in_turn([&](db::Catalog& catalog) { return carried_out(catalog, *asked); });
}

}  // namespace soak::station
