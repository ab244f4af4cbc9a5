// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "station/lab/station_service.h"

namespace soak::station {

/// What all event streams share: one thread looks at the laboratory five times a second of host time and writes a
/// changed status out once, however many streams send it.
class EventFeed {
 public:
  explicit EventFeed(const StationService& lab);
  ~EventFeed();

  struct News {
    bool stopped = false;
    std::uint64_t edition = 0;                  ///< rises with each changed status; the first is 1
    std::shared_ptr<const std::string> status;  ///< the status document on one line
    std::int64_t newest_log = 0;                ///< number of the newest log entry, 0 = none
  };

  [[nodiscard]] News latest() const;
  /// Waits until the status is of a later edition, the log has a later entry, or the feed is stopped; `timeout` at
  /// most.
  [[nodiscard]] News wait(std::uint64_t edition, std::int64_t log, std::chrono::milliseconds timeout) const;
  /// Number of the newest log entry, looked up now; `after` where none is later.
  [[nodiscard]] std::int64_t newest_log(std::int64_t after) const;
  /// Ends all waiting, now and later.
  void stop();

 private:
  void look();
  void run();

  const StationService& lab_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  News news_;
  std::uint64_t version_ = 0;  ///< of the status in news_; the feed's thread alone uses it
  std::thread thread_;
};

/// One client's server-sent events.
class EventStream {
 public:
  /// Sends log entries above `last_log`; nothing = those that come from now on. A number from before a new log began
  /// (above the newest) counts as the newest.
  EventStream(const StationService& lab, const EventFeed& feed, std::optional<std::int64_t> last_log);

  /// The next piece to send, waiting a second at most: empty where there is nothing new, a comment line after ten
  /// silent seconds. Nothing once the feed has stopped.
  [[nodiscard]] std::optional<std::string> next();

 private:
  [[nodiscard]] std::string new_log_entries(std::int64_t newest);

  const StationService& lab_;
  const EventFeed& feed_;
  std::uint64_t edition_ = 0;
  std::int64_t last_log_;
  std::chrono::steady_clock::time_point last_sent_;
};

}  // namespace soak::station
