// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace soak::station {

/// The jobs that are kept, each a document (docs/schema/http-job.schema.json) and a folder of its own with that
/// document and the file that was made: they outlive the daemon. Not for several threads at once.
class JobShelf {
 public:
  /// Kept of all, the newest; of each unit the newest verdict (of its own, or of a verification of all), export, gap
  /// search and comparison too.
  static constexpr std::size_t kMostJobs = 20;
  /// Listed of those.
  static constexpr std::size_t kMostListed = 100;

  explicit JobShelf(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Takes up what a predecessor left; what is no job is removed, a damaged document is put aside (`damaged-ID`) with a
  /// line in the log. The answer are the jobs that it was carrying out, which have failed by now and stand as running
  /// until they are put again; of a verification of all with the verdicts that it came to (kept_verdicts()).
  [[nodiscard]] std::vector<nlohmann::json> load();
  /// A number that no kept job has, rising.
  [[nodiscard]] std::int64_t next_id() const { return jobs_.empty() ? 1 : jobs_.rbegin()->first + 1; }
  [[nodiscard]] std::filesystem::path folder_of(std::int64_t id) const { return folder_ / std::to_string(id); }

  /// Writes a document down; what the shelf answers stays as it is until the job is put. Any thread may call.
  void write(const nlohmann::json& job) const;
  /// Keeps a document anew, and removes the jobs that are too many.
  void put(const nlohmann::json& job);
  /// What a job does and how far it is, 0 to 1 or null, which nobody needs any more once soakd has ended.
  void tell_step(std::int64_t id, const std::string& doing, const nlohmann::json& share) {
    jobs_.at(id)["doing"] = doing;
    jobs_.at(id)["progress"] = share;
  }
  /// The folder of a job that did not come to be.
  void remove_folder(std::int64_t id) const;

  /// {"jobs": the newest kMostListed, newest first, results without the keys `map`, `units`,
  /// `skipped` and `not_verified`, "not_listed": how many
  /// older ones are kept}
  [[nodiscard]] nlohmann::json list() const;
  /// The job that was begun last; null where none is kept.
  [[nodiscard]] nlohmann::json last() const { return jobs_.empty() ? nlohmann::json() : jobs_.rbegin()->second; }
  [[nodiscard]] std::optional<nlohmann::json> find(std::int64_t id) const;
  /// The newest job of a kind that lasts (verify, export, gap_find, gap_show) of a unit that came to its end and names
  /// a model; null where there is none. What a verification of all units said of this one is as if it had been of it
  /// alone: kind "verify" with the unit, and the unit's own result.
  [[nodiscard]] nlohmann::json newest(const std::string& unit, const std::string& kind) const;
  /// Of every unit that has one, newest(unit, "verify"): in one look at all jobs.
  [[nodiscard]] std::map<std::string, nlohmann::json> newest_verdicts() const;

 private:
  void remove_what_is_too_much();

  std::filesystem::path folder_;
  std::map<std::int64_t, nlohmann::json> jobs_;
};

}  // namespace soak::station
