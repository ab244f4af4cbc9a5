// SPDX-License-Identifier: Apache-2.0
#include "station/jobs/job_shelf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/text.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/jobs/job.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr const char* kDocument = "job.json";

constexpr std::string_view kAside = "damaged-";  // begins the name of a folder that was put aside

/// Members that a document of an older version may lack.
json complete(const json& stored) {
  json job = {{"model", nullptr},       {"progress", nullptr}, {"doing", nullptr},       {"campaign", nullptr},
              {"format", nullptr},      {"effects", nullptr},  {"user", "unknown"},      {"started_utc_s", 0.0},
              {"ended_utc_s", nullptr}, {"message", nullptr},  {"exit_status", nullptr}, {"result", nullptr},
              {"file", nullptr}};
  job.update(stored);
  return job;
}

bool is_text_or_null(const json& member) { return member.is_string() || member.is_null(); }

bool are_names(const json& effects) {
  return effects.is_null() ||
         (effects.is_array() && std::ranges::all_of(effects, [](const json& name) { return name.is_string(); }));
}

/// Of a kind that says so: [{"code", "text"}].
bool are_warnings(const json& warnings) {
  const auto is_warning = [](const json& warning) {
    return warning.is_object() && warning.value("code", json()).is_string() &&
           warning.value("text", json()).is_string();
  };
  return warnings.is_null() || (warnings.is_array() && std::ranges::all_of(warnings, is_warning));
}

/// Of a job of all units: what became of each.
bool are_units(const json& units) {
  const auto is_unit = [](const json& unit) {
    return unit.is_object() && unit.value("unit", json()).is_string() && are_warnings(unit.value("warnings", json()));
  };
  return units.is_null() || (units.is_array() && std::ranges::all_of(units, is_unit));
}

bool is_sound_result(const json& result) {
  return result.is_null() || (result.is_object() && are_warnings(result.value("warnings", json())) &&
                              are_units(result.value("units", json())));
}

bool is_made_file(const json& file) { return file.is_object() && file.contains("name") && file["name"].is_string(); }

constexpr std::array<std::string_view, 4> kStates = {"running", "done", "failed", "cancelled"};

/// Whether a complete() document has the types that everybody relies on; a file may have been changed or torn.
bool is_sound(const json& job, std::int64_t id) {
  for (const char* text : {"kind", "unit", "state", "user"}) {
    if (!job.contains(text) || !job[text].is_string()) return false;
  }
  return job.contains("id") && job["id"] == id &&
         std::ranges::find(kStates, job["state"].get<std::string>()) != kStates.end() &&
         is_text_or_null(job["campaign"]) && is_text_or_null(job["format"]) && is_text_or_null(job["message"]) &&
         are_names(job["effects"]) && job["started_utc_s"].is_number() && is_sound_result(job["result"]) &&
         (job["file"].is_null() || is_made_file(job["file"]));
}

/// The document in the folder of a job; nothing where it is damaged.
std::optional<json> stored_job(const std::filesystem::path& folder, std::int64_t id) {
  const auto text = read_text_file(folder / kDocument);
  if (!text) return std::nullopt;
  const json stored = json::parse(*text, nullptr, false);
  if (!stored.is_object()) return std::nullopt;
  json job = complete(stored);
  if (!is_sound(job, id)) return std::nullopt;
  return job;
}

/// Out of the way of later jobs, for people to look at.
void put_aside(const std::filesystem::path& folder) {
  const auto aside = folder.parent_path() / (std::string(kAside) + folder.filename().string());
  std::error_code failure;
  std::filesystem::remove_all(aside, failure);
  std::filesystem::rename(folder, aside, failure);
  log_line(fmt::format("{}: damaged, the job is not taken up; {}", (folder / kDocument).string(),
                       failure ? "it cannot be moved: " + failure.message() : "it is now in " + aside.string()));
}

/// Units that a verification of all has judged, also where it was cancelled afterwards.
const json& judged_units(const json& job) {
  static const json none = json::array();
  if (job["kind"] != kVerifyAll || job["state"] == "running" || !job["result"].is_object()) return none;
  const auto units = job["result"].find("units");
  return units != job["result"].end() && units->is_array() ? *units : none;
}

bool is_done(const json& job) { return job["state"] == "done"; }

constexpr std::array<std::string_view, 4> kLasting = {"verify", "export", "gap_find", "gap_show"};

/// What the page of a unit goes on showing of it when other jobs have come after: what was done with a model. Values of
/// the noise come from a run, and name none.
bool is_lasting(const json& job) {
  return is_done(job) && std::ranges::find(kLasting, job["kind"].get<std::string>()) != kLasting.end() &&
         job.value("/result/model"_json_pointer, json()).is_number_integer();
}

/// Of a verification of all, what it is to one unit.
json as_if_alone(const json& job, const json& judged) {
  json own = json::object();
  for (const auto& [name, member] : job.items()) {
    if (name != "result") own[name] = member;  // that of all units is large
  }
  const json verdict = judged.value("verdict", json());
  own.update({{"kind", "verify"},
              {"unit", judged["unit"]},
              {"model", judged.value("model", json())},
              {"state", "done"},
              {"exit_status", verdict == "fail" ? static_cast<int>(base::ErrorKind::limits) : 0},
              {"message", nullptr},
              {"result", judged}});
  return own;
}

}  // namespace

std::vector<json> JobShelf::load() {
  std::error_code failure;
  std::vector<json> cut_short;
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, failure)) folders.push_back(entry.path());
  for (const std::filesystem::path& folder : folders) {
    const auto id = base::parse_int(folder.filename().string());
    if (folder.filename().string().starts_with(kAside)) continue;
    if (!id || !std::filesystem::exists(folder / kDocument, failure)) {
      std::filesystem::remove_all(folder, failure);
      continue;
    }
    auto job = stored_job(folder, *id);
    if (!job) {
      put_aside(folder);
      continue;
    }
    jobs_[*id] = *std::move(job);
    if (jobs_[*id]["state"] != "running") continue;
    cut_short.push_back(jobs_[*id]);
    cut_short.back()["state"] = "failed";
    cut_short.back()["message"] = "soakd ended meanwhile";
    if (const json kept = kept_verdicts(folder); is_sound_result(kept)) cut_short.back()["result"] = kept;
  }
  remove_what_is_too_much();
  return cut_short;
}

void JobShelf::put(const json& job) {
  jobs_[job["id"].get<std::int64_t>()] = job;
  write(job);
  remove_what_is_too_much();
}

void JobShelf::write(const json& job) const {
  const auto path = folder_of(job["id"].get<std::int64_t>()) / kDocument;
  const auto text = job.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
  if (const auto written = write_text_file(path, text); !written) {
    log_line(
        fmt::format("a job will be forgotten when soakd ends: {}: {}", written.error().where, written.error().message));
  }
}

void JobShelf::remove_folder(std::int64_t id) const {
  std::error_code failure;
  std::filesystem::remove_all(folder_of(id), failure);
}

void JobShelf::remove_what_is_too_much() {
  std::size_t newer = 0;
  std::set<std::pair<std::string, std::string>> seen;  // unit and kind of a newer one that lasts
  for (auto job = jobs_.end(); job != jobs_.begin();) {
    --job;
    bool lasts = is_lasting(job->second) && seen.emplace(job->second["unit"], job->second["kind"]).second;
    for (const json& unit : judged_units(job->second)) lasts |= seen.emplace(unit.value("unit", ""), "verify").second;
    if (++newer <= kMostJobs || lasts || job->second["state"] == "running") continue;
    remove_folder(job->first);
    job = jobs_.erase(job);
  }
}

json JobShelf::list() const {
  json list = json::array();
  for (auto job = jobs_.rbegin(); job != jobs_.rend() && list.size() < kMostListed; ++job) {
    json entry = job->second;
    // Pages ask for the list every second: the map of a gap and what became of each unit are most of their documents.
    for (const char* large : {"map", "units", "skipped", "not_verified"}) {
      if (entry["result"].is_object()) entry["result"].erase(large);
    }
    list.push_back(std::move(entry));
  }
  const std::size_t not_listed = jobs_.size() - list.size();
  return {{"jobs", std::move(list)}, {"not_listed", not_listed}};
}

std::optional<json> JobShelf::find(std::int64_t id) const {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return std::nullopt;
  return found->second;
}

json JobShelf::newest(const std::string& unit, const std::string& kind) const {
  for (auto job = jobs_.rbegin(); job != jobs_.rend(); ++job) {
    if (is_lasting(job->second) && job->second["unit"] == unit && job->second["kind"] == kind) return job->second;
    if (kind != "verify") continue;
    for (const json& judged : judged_units(job->second)) {
      if (judged.value("unit", "") == unit) return as_if_alone(job->second, judged);
    }
  }
  return nullptr;
}

std::map<std::string, json> JobShelf::newest_verdicts() const {
  std::map<std::string, json> found;
  for (auto job = jobs_.rbegin(); job != jobs_.rend(); ++job) {
    if (job->second["kind"] == "verify" && is_lasting(job->second)) found.try_emplace(job->second["unit"], job->second);
    for (const json& judged : judged_units(job->second)) {
      const std::string unit = judged.value("unit", "");
      if (!found.contains(unit)) found[unit] = as_if_alone(job->second, judged);
    }
  }
  return found;
}

}  // namespace soak::station
