// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>

#include "base/result.h"
#include "station/jobs/job.h"
#include "station/jobs/job_shelf.h"

namespace soak::station {

/// The program `soak` beside the one that runs.
[[nodiscard]] std::filesystem::path soak_beside_this_program();

/// Does for people at the page what they would do with `soak`: fit, verify, report, release, export, gap of a unit; one
/// job at a time, each a process of its own (run_child()), so that recording goes on whatever becomes of it. Beginning
/// and end of each are in the event log with the user. Jobs live in the data folder, in `jobs`. Any thread may call;
/// documents: docs/http-api.md.
class JobRunner {
 public:
  /// Takes up the jobs that are kept; the end of one that a predecessor left running, or ended without saying so,
  /// enters the event log, once. An empty folder has no jobs: every start is refused (bad_input).
  explicit JobRunner(std::filesystem::path data_folder, std::filesystem::path program = soak_beside_this_program());
  /// Ends the job that is under way, and its process with it.
  ~JobRunner();
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  /// Begins a job and answers with its document. Refuses what check_job() and job_command() refuse, and (where ==
  /// "state") a second job beside one that runs.
  [[nodiscard]] base::Result<nlohmann::json> start(const JobRequest& request);
  /// Ends a job; the answer comes when its process has ended: "done" where it had come to its end already. Refuses
  /// (where == "state") one that does not run.
  [[nodiscard]] base::Result<nlohmann::json> cancel(std::int64_t id, const std::string& user);

  /// No job begins any more, until end_hold(). Refuses (where == "state") while one runs.
  [[nodiscard]] base::Status hold();
  void end_hold();

  /// The kept jobs, as JobShelf::list() gives them.
  [[nodiscard]] nlohmann::json list() const;
  /// Refuses (where == "id") a job that is not kept; so does file().
  [[nodiscard]] base::Result<nlohmann::json> show(std::int64_t id) const;
  /// The newest job of that kind that came to its end; null where none is kept.
  [[nodiscard]] nlohmann::json newest(const std::string& unit, const std::string& kind) const;
  /// Of every unit that has one, newest(unit, "verify").
  [[nodiscard]] std::map<std::string, nlohmann::json> newest_verdicts() const;

  struct MadeFile {
    std::string name;
    std::string content;
  };
  /// What a job has made. Refuses (where == "id") one that made no file.
  [[nodiscard]] base::Result<MadeFile> file(std::int64_t id) const;

 private:
  /// A job between its start and its end.
  struct UnderWay {
    nlohmann::json document;
    JobCommand command;
  };

  [[nodiscard]] base::Result<UnderWay> prepare(const JobRequest& request, std::int64_t id);
  void note(const std::string& kind, const nlohmann::json& job, const std::string& text, const std::string& user) const;
  void note_end(const nlohmann::json& job, const std::string& user) const;
  void end_those_cut_short();
  void work();
  void carry_out(UnderWay job);
  void finish(nlohmann::json& document, const JobCommand& command, const ChildEnd& end) const;

  std::filesystem::path data_folder_;
  std::filesystem::path program_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  JobShelf shelf_;
  bool held_ = false;                ///< no job begins
  bool busy_ = false;                ///< a job is being prepared or carried out
  std::optional<UnderWay> waiting_;  ///< for the thread to take
  std::string cancelled_by_;
  bool quits_ = false;
  std::atomic<bool> stop_child_ = false;
  std::thread thread_;  ///< the child dies with it
};

}  // namespace soak::station
