// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/catalog/catalog.h"

namespace soak::station {

/// What happened, for people: to the catalog's append-only log, to the program's own log, and to those who listen. Any
/// thread may read.
class EventLog {
 public:
  explicit EventLog(db::Catalog& catalog);

  /// `kind`: "campaign", "step", "device", "alarm", "unit", "segment"...; `subject`: what it is about.
  void add(const std::string& kind, const std::string& subject, const std::string& text);
  /// {"entries": [...]}: those with a number above `after`, at most 500, the newest where there are more.
  [[nodiscard]] nlohmann::json document(std::int64_t after) const;

 private:
  struct Entry {
    std::int64_t number;
    db::EventRow row;
  };

  db::Catalog& catalog_;
  mutable std::mutex mutex_;
  std::deque<Entry> entries_;
  std::int64_t last_number_;  ///< begins at the host's clock: numbers rise from one soakd to the next
};

}  // namespace soak::station
