// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/lab/station_service.h"

namespace soak::station {

/// A campaign that waits for its turn. It was checked when it was queued, and is again when it begins.
struct QueuedCampaign {
  StartRequest request = {};
  std::string procedure = {};  ///< the procedure's own name
  double estimate_s = 0.0;     ///< of process time
  double queued_utc_s = 0.0;
};

/// Campaigns that begin one after another, in the order in which they were queued. Kept in a file beside the catalog,
/// which is written and synced before a change counts: what was queued outlives soakd. Any thread may call; who changes
/// the queue waits for the disk, who reads it does not.
class CampaignQueue {
 public:
  static constexpr std::size_t kMost = 50;

  /// What the file holds; nothing where there is none. A file that cannot be read is moved aside to PATH.damaged, and
  /// trouble() says so.
  explicit CampaignQueue(std::filesystem::path path);

  [[nodiscard]] bool empty() const;
  [[nodiscard]] std::size_t size() const;
  /// The one that begins next; nothing where none waits.
  [[nodiscard]] std::optional<QueuedCampaign> front() const;
  [[nodiscard]] bool holds(const std::string& campaign) const;
  /// Process time that all of them take.
  [[nodiscard]] double estimate_s() const;
  /// Puts it behind all others. Refuses (bad_input) a name that is in the queue, and more than kMost campaigns; fails
  /// (internal) where the file cannot be written. Then this queue has not changed.
  [[nodiscard]] base::Status add(QueuedCampaign campaign);
  /// Refuses (bad_input) a name that is not in the queue; fails as add() does.
  [[nodiscard]] base::Status remove(const std::string& campaign);
  /// Takes one out that has begun: also where the file cannot be written, which then fails (internal).
  [[nodiscard]] base::Status take_out(const std::string& campaign);
  /// Why the file of a predecessor could not be read; empty where it could, or there was none.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// For the status: name, procedure, user, queued_utc_s and estimate_s of each.
  [[nodiscard]] nlohmann::json document() const;

 private:
  [[nodiscard]] std::vector<QueuedCampaign> waiting() const;
  void set(std::vector<QueuedCampaign> campaigns);
  [[nodiscard]] base::Status write(const std::vector<QueuedCampaign>& campaigns) const;

  std::filesystem::path path_;
  std::string trouble_;
  std::mutex change_;  ///< held while somebody changes the queue and writes the file
  mutable std::mutex waiting_mutex_;
  std::vector<QueuedCampaign> waiting_;
};

}  // namespace soak::station
