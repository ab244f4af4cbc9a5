// SPDX-License-Identifier: Apache-2.0
#include "station/config/procedure_folder.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "station/config/plan.h"
#include "station/config/procedure.h"
#include "station/config/procedure_changes.h"
#include "station/config/unit_type_file.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t kLongest_bytes = 256 * 1024;

/// File name → path; those of the first folder hide others of the same name.
std::map<std::string, fs::path> files_of(const std::vector<fs::path>& folders) {
  std::map<std::string, fs::path> files;
  for (const fs::path& folder : folders) {
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      std::error_code ignored;
      const fs::path& path = entry->path();
      if (path.extension() == ".toml" && entry->is_regular_file(ignored)) files.emplace(path.filename().string(), path);
    }
  }
  return files;
}

json entry_of(const std::string& file, const fs::path& path, double room_c) {
  json entry = {{"file", file}, {"trouble", nullptr}, {"text", ""}, {"name", file}};
  const auto text = procedure_file_text(path);
  const auto procedure = text ? parse_procedure(*text, file) : base::Result<Procedure>(base::forward_error(text));
  if (!procedure) {
    entry["trouble"] = procedure.error().message;
    return entry;
  }
  const Plan plan = compile_plan(*procedure, room_c);
  entry["text"] = *text;
  entry["name"] = procedure->name;
  entry["description"] = procedure->description;
  entry["purpose"] = name_of(procedure->purpose);
  entry["kind"] = name_of(procedure->kind);
  entry["runs"] = std::ranges::count(plan.runs, false, &PlannedRun::preflight);
  entry["estimate_s"] = plan.estimate_s();
  entry["changeable"] = changeable_document(*procedure);
  return entry;
}

}  // namespace

std::vector<fs::path> procedure_folders(const fs::path& data_folder) {
  return {data_folder / "procedures", shipped_procedures()};
}

std::optional<fs::path> procedure_file(const std::vector<fs::path>& folders, const std::string& file) {
  const auto files = files_of(folders);
  const auto found = files.find(file);
  return found == files.end() ? std::nullopt : std::optional(found->second);
}

base::Result<std::string> procedure_file_text(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (!error && size > kLongest_bytes) {
    return base::bad_input("longer than 256 KiB: this is no procedure", path.string());
  }
  return read_text_file(path);
}

json procedures_document(const std::vector<fs::path>& folders, const std::string& file, double room_c) {
  json list = json::array();
  for (const auto& [name, path] : files_of(folders)) {
    if (!file.empty() && name != file) continue;
    list.push_back(entry_of(name, path, room_c));
    if (!file.empty()) continue;
    list.back().erase("text");
    list.back().erase("changeable");
  }
  return {{"procedures", std::move(list)}};
}

}  // namespace soak::station
