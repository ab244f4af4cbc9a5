// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// `where` of the refusal (internal) while too many questions are being answered.
inline constexpr const char* kBusy = "busy";

/// One unit's part of a stored run.
struct RunName {
  std::string run_id;
  std::string unit;
};

/// A question for channels of a run over a span of time.
struct SeriesRequest {
  RunName run;
  std::string stream = "imu";         ///< a unit's samples, or "chamber"
  std::vector<std::string> channels;  ///< canonical names
  std::optional<double> from_s;       ///< absent = from the first row on
  std::optional<double> to_s;         ///< absent = to the last row
  std::size_t points = 1000;          ///< that a drawing has room for
};

/// What takes too long to be worked out of a catalog for each of a thousand units at every look at their list: each
/// model is read for it. It holds until an event is entered, which everything that bears on it is, or another day
/// begins, when certificates expire.
class WorkedOut {
 public:
  using Work = std::function<base::Result<nlohmann::json>()>;

  /// Forgets all of it where it does not hold any more. Fails where the event log cannot be read.
  [[nodiscard]] base::Status renew(const db::Catalog& catalog, std::string_view day);
  /// What `work` makes of all units: asked once. An error is not kept.
  [[nodiscard]] base::Result<nlohmann::json> of_all(const Work& work);
  /// What `work` makes of a unit and of the newest verification of it, a job or null: asked once for each of the two.
  [[nodiscard]] base::Result<nlohmann::json> of(const std::string& unit, const nlohmann::json& job, const Work& work);

 private:
  struct OfUnit {
    nlohmann::json job;
    nlohmann::json found;
  };

  std::string events_;  ///< hash of all events
  std::string day_;
  nlohmann::json of_all_;  ///< null: not asked yet
  std::map<std::string, OfUnit> of_unit_;
};

/// What was worked out of something that never changes, such as the samples of a sealed run. Any thread may call.
class KeptAnswers {
 public:
  static constexpr std::size_t kMostKept = 64;  ///< the newest

  [[nodiscard]] std::optional<nlohmann::json> find(const std::string& key) const;
  void keep(const std::string& key, nlohmann::json answer);

 private:
  mutable std::mutex mutex_;
  std::deque<std::pair<std::string, nlohmann::json>> kept_;
};

/// The stored runs of a data folder for whoever looks at them beside the engine: over connections to the catalog of its
/// own, one question at a time, so that many of them take one processor at most and recordings and commands go on.
/// A few questions may wait, more are refused (internal, where == kBusy); all of them are while the folder is gone
/// (reopen_catalog()). Only sealed run files are opened: those take
/// no lock, and no recording waits for a reader. Any thread may call. Documents: docs/http-api.md.
class RunArchive {
 public:
  static constexpr std::size_t kMostRuns = 1000;    ///< in one list
  static constexpr std::size_t kMostPoints = 2000;  ///< of one series
  static constexpr std::size_t kMostChannels = 12;  ///< of one series

  /// Opens nothing yet. An empty folder has no runs: every question is refused (bad_input).
  explicit RunArchive(std::filesystem::path data_folder);

  /// The newest runs first; of one unit, of one campaign.
  [[nodiscard]] base::Result<nlohmann::json> list(const db::RunFilter& filter);
  /// A run with its streams, channels, segments (withdrawn ones too) and void records. Refuses (bad_input, where ==
  /// "run") one that is not there or not sealed.
  [[nodiscard]] base::Result<nlohmann::json> show(const RunName& run);
  /// Samples where the span holds at most `points` rows, else minimum, mean and maximum of about so many stretches.
  /// Refuses (bad_input) what show() refuses, a stream or channel that the run does not have, naming those that it has,
  /// more points or channels than the limits above, and a span that ends before it starts.
  [[nodiscard]] base::Result<nlohmann::json> series(const SeriesRequest& request);
  /// Enters a void record for `record.run_id` and `record.unit`, at the host's time. Refuses as void_part()
  /// does.
  [[nodiscard]] base::Result<nlohmann::json> withdraw(db::VoidRecord record);
  /// Any other question to the catalog, in the same turn.
  [[nodiscard]] base::Result<nlohmann::json> in_turn(
      const std::function<base::Result<nlohmann::json>(db::Catalog&)>& work);
  /// Of the units in a list; only for what in_turn() does.
  [[nodiscard]] WorkedOut& worked_out() { return worked_out_; }
  /// What takes long with what a question has found: one at a time, refused like questions, but none of these waits.
  [[nodiscard]] base::Result<nlohmann::json> compute(const std::function<base::Result<nlohmann::json>()>& work);
  /// What `work`, which may ask and compute in many turns, makes of what never changes and has that key: worked out
  /// once, by one thread at a time, and kept (KeptAnswers); refused like questions, but none of these waits. An error
  /// is not kept.
  [[nodiscard]] base::Result<nlohmann::json> once(const std::string& key,
                                                  const std::function<base::Result<nlohmann::json>()>& work);

 private:
  /// What one thread has at a time, for which a few may wait.
  class Turn {
   public:
    /// Fails (internal, where == kBusy) where too many wait, or for too long.
    [[nodiscard]] base::Result<std::unique_lock<std::timed_mutex>> take();

   private:
    std::timed_mutex mutex_;
    std::atomic<int> waiting_ = 0;
  };

  std::filesystem::path data_folder_;
  Turn questions_;
  Turn computations_;
  Turn long_works_;
  KeptAnswers kept_;
  WorkedOut worked_out_;
};

}  // namespace soak::station
