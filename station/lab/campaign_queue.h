// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
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
/// which is written before a change counts: what was queued outlives soakd. One thread uses it.
class CampaignQueue {
 public:
  static constexpr std::size_t kMost = 50;

  /// What the file holds; nothing where there is none. A file that cannot be read is moved aside to PATH.damaged, and
  /// trouble() says so.
  explicit CampaignQueue(std::filesystem::path path);

  [[nodiscard]] const std::vector<QueuedCampaign>& waiting() const { return waiting_; }
  [[nodiscard]] bool holds(const std::string& campaign) const;
  /// Puts it behind all others. Refuses (bad_input) a name that is in the queue, and more than kMost campaigns; fails
  /// (internal) where the file cannot be written. Then nothing has changed.
  [[nodiscard]] base::Status add(QueuedCampaign campaign);
  /// Refuses (bad_input) a name that is not in the queue; fails as add() does.
  [[nodiscard]] base::Status remove(const std::string& campaign);
  /// Why the file of a predecessor could not be read; empty where it could, or there was none.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// For the status: name, procedure, user, queued_utc_s and estimate_s of each.
  [[nodiscard]] nlohmann::json document() const;

 private:
  [[nodiscard]] base::Status keep(std::vector<QueuedCampaign> campaigns);

  std::filesystem::path path_;
  std::vector<QueuedCampaign> waiting_;
  std::string trouble_;
};

}  // namespace soak::station
