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

#include "base/text.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr const char* kDocument = "job.json";

bool is_text(const json& job, const char* member) { return job.contains(member) && job[member].is_string(); }

/// The document in a job's folder; nothing where there is none or it is damaged.
std::optional<json> stored_job(const std::filesystem::path& folder) {
  const auto id = base::parse_int(folder.filename().string());
  const auto text = read_text_file(folder / kDocument);
  if (!id || !text) return std::nullopt;
  json job = json::parse(*text, nullptr, false);
  if (!job.is_object() || job.value("id", json()) != *id) return std::nullopt;
  if (!is_text(job, "kind") || !is_text(job, "unit") || !is_text(job, "state")) return std::nullopt;
  return job;
}

bool is_done(const json& job) { return job["state"] == "done"; }

constexpr std::array<std::string_view, 4> kLasting = {"verify", "export", "gap_find", "gap_show"};

/// What the page of a unit goes on showing of it when other jobs have come after: what was done with a model. Values of
/// the noise come from a run, and name none.
bool is_lasting(const json& job) {
  return is_done(job) && std::ranges::find(kLasting, job["kind"].get<std::string>()) != kLasting.end() &&
         job.value("/result/model"_json_pointer, json()).is_number_integer();
}

}  // namespace

std::vector<json> JobShelf::load() {
  std::error_code failure;
  std::vector<json> cut_short;
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(folder_, failure)) folders.push_back(entry.path());
  for (const std::filesystem::path& folder : folders) {
    auto job = stored_job(folder);
    if (!job) {
      std::filesystem::remove_all(folder, failure);
      continue;
    }
    const std::int64_t id = (*job)["id"];
    jobs_[id] = *std::move(job);
    if (jobs_[id]["state"] != "running") continue;
    cut_short.push_back(jobs_[id]);
    cut_short.back()["state"] = "failed";
    cut_short.back()["message"] = "soakd ended meanwhile";
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
    const bool lasts = is_lasting(job->second) && seen.emplace(job->second["unit"], job->second["kind"]).second;
    if (++newer <= kMostJobs || lasts || job->second["state"] == "running") continue;
    remove_folder(job->first);
    job = jobs_.erase(job);
  }
}

json JobShelf::list() const {
  json list = json::array();
  for (auto job = jobs_.rbegin(); job != jobs_.rend() && list.size() < kMostListed; ++job) {
    json entry = job->second;
    // Pages ask for the list every second: the map of a gap is most of its document.
    if (entry["result"].is_object()) entry["result"].erase("map");
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
  }
  return nullptr;
}

}  // namespace soak::station
