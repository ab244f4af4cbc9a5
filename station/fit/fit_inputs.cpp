// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_inputs.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/hash.h"
#include "base/text.h"
#include "calib/model/document_parts.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_unit.h"
#include "station/fit/reference_rule.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Raised with each change of the program that makes another model of the same inputs.
constexpr int kFitRevision = 1;

std::string digest_of(const json& inputs) {
  base::Sha256 hash;
  hash.update(inputs.dump());
  return base::to_hex(hash.finish());
}

/// Of the file of a type; null where it has none.
base::Result<json> type_digest(const std::string& name) {
  const std::filesystem::path file = default_unit_type_folder() / (name + ".toml");
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return json();
  const auto text = read_text_file(file);
  if (!text) return base::forward_error(text);
  base::Sha256 hash;
  hash.update(*text);
  return json(base::to_hex(hash.finish()));
}

json void_json(const db::VoidRecord& record) {
  return {record.visit ? json(*record.visit) : json(), record.position ? json(*record.position) : json(),
          record.attempt ? json(*record.attempt) : json()};
}

base::Result<json> run_json(const db::Catalog& catalog, const db::RunRow& run) {
  const auto voids = catalog.voids(run.run_id);
  if (!voids) return base::forward_error(voids);
  json withdrawn = json::array();
  for (const db::VoidRecord& record : *voids) {
    if (record.unit == run.unit) withdrawn.push_back(void_json(record));
  }
  return json{{"id", run.run_id},
              {"numbers", run.numbers_sha256},
              {"dropped", run.samples_dropped.has_value()},
              {"voids", std::move(withdrawn)}};
}

}  // namespace

base::Result<FitInputs> fit_inputs_now(const db::Catalog& catalog, const std::string& unit,
                                       const std::optional<std::string>& campaign,
                                       const std::vector<calib::ModelTerm>& terms,
                                       const calib::CurveFitOptions& options) {
  const double seen_utc_s = now_utc_s();
  const auto row = catalog.unit(unit);
  if (!row) return base::forward_error(row);
  if (!*row) return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", unit));
  const auto type = type_digest((*row)->type);
  if (!type) return base::forward_error(type);
  const auto runs = catalog.runs({.unit = unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  json taken = json::array();
  std::vector<std::string> campaigns;
  for (const db::RunRow& run : *runs) {
    if (!is_for_fit(run, (*row)->epoch)) continue;
    auto described = run_json(catalog, run);
    if (!described) return base::forward_error(described);
    taken.push_back(*std::move(described));
    campaigns.push_back(run.campaign);
  }
  const auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  const std::string digest = digest_of({{"software", software_version()},
                                        {"revision", kFitRevision},
                                        {"unit", unit},
                                        {"type", (*row)->type},
                                        {"type_file", *type},
                                        {"epoch", (*row)->epoch},
                                        {"runs", std::move(taken)},
                                        {"references", calib::stored_references(*references)},
                                        {"terms", calib::terms_json(terms)},
                                        {"rules", options.rules ? json(*options.rules) : json()}});
  return FitInputs{digest, seen_utc_s};
}

}  // namespace soak::station
