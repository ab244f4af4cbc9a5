// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/lab/run_recorder.h"

namespace soak::station {

/// Seals run files and enters them into the catalog while whoever supervises the chamber goes on: that takes seconds to
/// minutes, on a thread of its own with a connection to the catalog of its own. A run's file goes to that thread whole;
/// nothing of it stays with the caller. One piece of work at a time; all calls from one thread, none of which waits.
class RunSealer {
 public:
  /// What became of a run.
  struct Sealed {
    std::string run_id;
    std::string label;
    RunEnd end;
    std::size_t rejected = 0;  ///< segments
    base::Status status;       ///< where it failed, the run stays here: retry()
  };

  explicit RunSealer(std::filesystem::path data_folder) : data_folder_(std::move(data_folder)) {}
  RunSealer(const RunSealer&) = delete;
  RunSealer& operator=(const RunSealer&) = delete;
  /// Waits for the work to end.
  ~RunSealer() = default;

  /// Takes over a run that has come to its end. Nothing else may be at work; a run that failed before is left.
  void begin(RunRecorder run, RunEnd end);
  /// Tries again what failed. The end stays: a run that was complete is not cut short by what comes after it.
  void retry();
  /// A run is here: at work, or one that failed.
  [[nodiscard]] bool has_run() const { return run_ != nullptr; }
  /// Its id; empty without one.
  [[nodiscard]] std::string run_id() const { return run_ ? run_id_ : ""; }
  [[nodiscard]] bool busy() const { return work_.valid() || lost_runs_.valid(); }
  /// What became of the run, once; nothing while it is at work.
  [[nodiscard]] std::optional<Sealed> take();
  /// Leaves a run that failed: everything that was flushed stays in its file (enter_lost_runs()).
  void leave() { run_.reset(); }

  /// Begins to enter what killed predecessors left behind. Nothing else may be at work.
  void begin_lost_runs(const std::string& aborted_campaign);
  /// What was found, once; nothing while it is at work.
  [[nodiscard]] std::optional<base::Result<std::vector<LostRun>>> take_lost_runs();
  [[nodiscard]] bool enters_lost_runs() const { return lost_runs_.valid(); }

  /// Called on the thread before each piece of work: for tests, which hold it there.
  std::function<void()> before_work;

 private:
  std::filesystem::path data_folder_;
  std::shared_ptr<RunRecorder> run_;
  std::string run_id_;
  std::string label_;
  RunEnd end_;
  std::future<base::Status> work_;  ///< waits when it is destroyed
  std::future<base::Result<std::vector<LostRun>>> lost_runs_;
};

}  // namespace soak::station
