// SPDX-License-Identifier: Apache-2.0
#include "station/lab/event_log.h"

#include <nlohmann/json.hpp>

#include "station/io/host.h"

namespace soak::station {
namespace {

constexpr std::size_t kKept = 2000;
constexpr std::size_t kShown = 500;

}  // namespace

EventLog::EventLog(db::Catalog& catalog)
    : catalog_(catalog), last_number_(static_cast<std::int64_t>(now_utc_s() * 1000.0)) {}

void EventLog::add(const std::string& kind, const std::string& subject, const std::string& text) {
  const db::EventRow row{now_utc_s(), kind, subject, text};
  log_line(kind + ": " + (subject.empty() ? text : subject + ": " + text));
  if (const auto stored = catalog_.log_event(row); !stored) {
    log_line("event log: " + stored.error().where + ": " + stored.error().message);
  }
  const std::lock_guard lock(mutex_);
  entries_.push_back({++last_number_, row});
  if (entries_.size() > kKept) entries_.pop_front();
}

nlohmann::json EventLog::document(std::int64_t after) const {
  const std::lock_guard lock(mutex_);
  std::size_t first = 0;
  while (first < entries_.size() && entries_[first].number <= after) ++first;
  if (entries_.size() - first > kShown) first = entries_.size() - kShown;
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = first; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    list.push_back({{"number", entry.number},
                    {"utc_s", entry.row.utc_s},
                    {"kind", entry.row.kind},
                    {"subject", entry.row.subject},
                    {"text", entry.row.text}});
  }
  return {{"entries", std::move(list)}};
}

}  // namespace soak::station
