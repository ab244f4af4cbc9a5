// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_log.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/io/host.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

constexpr std::size_t kEventsKept = 2000;
constexpr std::size_t kEventsShown = 500;
/// Numbers of all points together, so that the page's first view stays small however long the campaign is.
constexpr std::size_t kMostNumbers = 8192;
/// A curve of fewer says nothing: of more than 29 units there are more numbers in all, 17 152 of the 64 that a station
/// has at most.
constexpr std::size_t kFewestPoints = 256;

std::size_t most_points(std::size_t units) {
  constexpr std::size_t kOthers = 3;  // time, chamber, set point
  return std::max(kFewestPoints, kMostNumbers / (units + kOthers));
}

/// To 0.01, which is all that a chart shows.
nlohmann::json rounded(const std::optional<double>& value) {
  return value ? number_or_null(std::round(100.0 * *value) / 100.0) : nlohmann::json();
}

}  // namespace

EventLog::EventLog(std::function<void(const db::EventRow&)> store)
    : store_(std::move(store)), last_number_(static_cast<std::int64_t>(now_utc_s() * 1000.0)) {}

EventLog::EventLog(db::Catalog& catalog)
    : EventLog([&catalog](const db::EventRow& row) {
        const auto stored = catalog.log_event(row);
        if (!stored) log_line("event log: " + stored.error().where + ": " + stored.error().message);
      }) {}

EventLog::EventLog(Journal& journal) : EventLog([&journal](const db::EventRow& row) { journal.add(row); }) {}

void EventLog::add(const std::string& kind, const std::string& subject, const std::string& text,
                   const std::string& user) {
  const db::EventRow row{now_utc_s(), kind, subject, text, user};
  log_line(kind + ": " + (subject.empty() ? text : subject + ": " + text));
  store_(row);
  const std::lock_guard lock(mutex_);
  entries_.push_back({++last_number_, row});
  if (entries_.size() > kEventsKept) entries_.pop_front();
}

nlohmann::json EventLog::document(std::int64_t after) const {
  const std::lock_guard lock(mutex_);
  std::size_t first = 0;
  while (first < entries_.size() && entries_[first].number <= after) ++first;
  if (entries_.size() - first > kEventsShown) first = entries_.size() - kEventsShown;
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

void TemperatureLog::begin(std::vector<std::string> serials) {
  const std::lock_guard lock(mutex_);
  serials_ = std::move(serials);
  points_.clear();
  spacing_s_ = 1.0;
}

void TemperatureLog::add(double t_s, std::optional<double> chamber_c, std::optional<double> set_point_c,
                         const std::vector<std::optional<double>>& units_c) {
  const std::lock_guard lock(mutex_);
  if (!points_.empty() && t_s - points_.back().t_s < spacing_s_) return;
  points_.push_back({t_s, chamber_c, set_point_c, units_c});
  if (points_.size() < most_points(serials_.size())) return;
  for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = std::move(points_[2 * i]);
  points_.resize((points_.size() + 1) / 2);
  spacing_s_ *= 2.0;
}

nlohmann::json TemperatureLog::document(double after_s) const {
  const std::lock_guard lock(mutex_);
  nlohmann::json t_s = nlohmann::json::array();
  nlohmann::json chamber_c = nlohmann::json::array();
  nlohmann::json set_point_c = nlohmann::json::array();
  std::vector<nlohmann::json> units(serials_.size(), nlohmann::json::array());
  for (const Point& point : points_) {
    if (point.t_s <= after_s) continue;
    t_s.push_back(point.t_s);
    chamber_c.push_back(rounded(point.chamber_c));
    set_point_c.push_back(rounded(point.set_point_c));
    for (std::size_t u = 0; u < units.size(); ++u) {
      units[u].push_back(u < point.units_c.size() ? rounded(point.units_c[u]) : nlohmann::json());
    }
  }
  nlohmann::json named = nlohmann::json::object();
  for (std::size_t u = 0; u < units.size(); ++u) named[serials_[u]] = std::move(units[u]);
  return {{"t_s", std::move(t_s)},
          {"chamber_c", std::move(chamber_c)},
          {"set_point_c", std::move(set_point_c)},
          {"units", std::move(named)}};
}

void Prompts::ask(Question question) {
  open_ = Prompt{std::move(question), ++last_id_};
  answered_ = false;
}

bool Prompts::take_answer() {
  if (!answered_) return false;
  open_.reset();
  answered_ = false;
  return true;
}

bool Prompts::answer(std::int64_t id) {
  if (!open_ || open_->id != id || answered_) return false;  // two windows of the page answer at once
  answered_ = true;
  return true;
}

}  // namespace soak::station
