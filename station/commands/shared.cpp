// SPDX-License-Identifier: Apache-2.0
#include "station/commands/shared.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "station/config/unit_type_file.h"
#include "station/fit/reference_rule.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/records/signing.h"

namespace soak::station {

base::Result<db::Catalog> CatalogCommand::open_data() const { return open_existing_catalog(data); }

base::Status CatalogCommand::run(Output& output) {
  auto catalog = open_data();
  if (!catalog) return base::forward_error(catalog);
  catalog->act_as(user_name());
  return run_with(*catalog, output);
}

nlohmann::json warnings_json(const std::vector<calib::Warning>& warnings) {
  nlohmann::json list = nlohmann::json::array();
  for (const calib::Warning& warning : warnings) list.push_back({{"code", warning.code}, {"text", warning.text}});
  return list;
}

void note_waivers(const std::vector<calib::ReferenceUse>& references, Output& output, const std::string& about) {
  std::vector<std::string> texts;
  for (const auto& [reference, waiver, campaigns] : references) {
    if (!waiver) continue;
    texts.push_back(fmt::format("{}, due {}, by a waiver of {}: {}", describe(reference), iso_date(reference.due_utc_s),
                                waiver->signer, waiver->reason));
  }
  if (!texts.empty()) output.note(fmt::format("{}warning: measured with {}", about, fmt::join(texts, "; ")));
  for (const calib::Warning& warning : waiver_warnings(references)) {
    output.note(fmt::format("{}warning: {}", about, warning.text));
  }
}

std::string marks_text(const calib::Calibration& calibration) {
  if (!calibration.simulated && !calibration.unreleased) return "";
  const std::string_view between = calibration.simulated && calibration.unreleased ? ", " : "";
  return fmt::format(" ({}{}{})", calibration.simulated ? "SIMULATED" : "", between,
                     calibration.unreleased ? "NOT RELEASED" : "");
}

OptionReader name_reader(std::string& name) {
  return [&name](const std::string& text) -> base::Status {
    if (auto plain = check_text_line(text, {}); !plain) return plain;
    name = text;
    return {};
  };
}

void declare_run(OptionList& options, db::RunFilter& filter) {
  options.add("run RUN", &filter.run, "Run id, unique beginning of one, or label").required();
  options.add("--unit SN", &filter.unit, "Only runs of this unit");
  options.add("--campaign NAME", &filter.campaign, "Only runs of this campaign");
}

base::Result<calib::UnitType> find_unit_type(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = folder.empty() ? default_unit_type_folder() : std::filesystem::path(folder);
  auto types = read_unit_types(path);
  if (!types) return base::forward_error(types);
  const auto type = std::ranges::find(*types, name, &calib::UnitType::name);
  if (type != types->end()) return std::move(*type);
  return base::bad_input(fmt::format("unknown unit type '{}': 'soak type list' shows all", name), path.string());
}

}  // namespace soak::station
