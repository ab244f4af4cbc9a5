// SPDX-License-Identifier: Apache-2.0
#include "station/http/event_feed.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "station/http/api.h"

namespace soak::station {
namespace {

constexpr std::chrono::milliseconds kLookEvery{200};
constexpr std::chrono::milliseconds kStreamWait{1000};
constexpr std::chrono::seconds kKeepAlive{10};

}  // namespace

EventFeed::EventFeed(const StationService& lab) : lab_(lab) {
  look();
  thread_ = std::thread([this] { run(); });
}

EventFeed::~EventFeed() {
  stop();
  thread_.join();
}

std::int64_t EventFeed::newest_log(std::int64_t after) const {
  for (;;) {
    const nlohmann::json page = lab_.log(after);
    const auto& entries = page.at("entries");
    if (entries.empty()) return after;
    after = entries.back().at("number").get<std::int64_t>();
  }
}

void EventFeed::look() {
  // The number is read before the document: a change in between is seen at the next look.
  const std::uint64_t version = lab_.status_version();
  std::shared_ptr<const std::string> status;
  if (news_.edition == 0 || version != version_) status = std::make_shared<std::string>(compact(lab_.status()));
  version_ = version;
  const std::int64_t log = newest_log(news_.newest_log);
  if (!status && log == news_.newest_log) return;
  {
    const std::lock_guard lock(mutex_);
    if (status) {
      news_.status = std::move(status);
      ++news_.edition;
    }
    news_.newest_log = log;
  }
  changed_.notify_all();
}

void EventFeed::run() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, kLookEvery, [this] { return news_.stopped; })) return;
    }
    look();
  }
}

EventFeed::News EventFeed::latest() const {
  const std::lock_guard lock(mutex_);
  return news_;
}

EventFeed::News EventFeed::wait(std::uint64_t edition, std::int64_t log, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return news_.stopped || news_.edition != edition || news_.newest_log > log; });
  return news_;
}

void EventFeed::stop() {
  {
    const std::lock_guard lock(mutex_);
    news_.stopped = true;
  }
  changed_.notify_all();
}

EventStream::EventStream(const StationService& lab, const EventFeed& feed, std::optional<std::int64_t> last_log)
    : lab_(lab), feed_(feed), last_sent_(std::chrono::steady_clock::now()) {
  std::int64_t newest = feed.latest().newest_log;
  // The feed looks some times a second: a client may have seen more than it has. Only a number of another log is none.
  if (last_log && *last_log > newest) newest = feed.newest_log(newest);
  last_log_ = std::min(last_log.value_or(newest), newest);
}

std::string EventStream::new_log_entries(std::int64_t newest) {
  std::string text;
  while (last_log_ < newest) {
    const nlohmann::json page = lab_.log(last_log_);
    for (const auto& entry : page.at("entries")) {
      last_log_ = std::min(entry.at("number").get<std::int64_t>(), newest);
      if (entry.at("number") > newest) return text;  // what the feed has not seen follows once it has
      text += "id: " + std::to_string(last_log_) + "\nevent: log\ndata: " + compact(entry) + "\n\n";
    }
    if (page.at("entries").empty()) last_log_ = newest;
  }
  return text;
}

std::optional<std::string> EventStream::next() {
  const EventFeed::News news = feed_.wait(edition_, last_log_, kStreamWait);
  if (news.stopped) return std::nullopt;
  std::string text;
  // A stream begins with what holds now, not with what the feed saw last: the caller may just have changed it.
  const bool begins = edition_ == 0;
  if (begins) text = "event: status\ndata: " + compact(lab_.status()) + "\n\n";
  if (!begins && news.edition != edition_) text = "event: status\ndata: " + *news.status + "\n\n";
  edition_ = news.edition;
  text += new_log_entries(news.newest_log);
  const auto now = std::chrono::steady_clock::now();
  if (text.empty() && now - last_sent_ >= kKeepAlive) text = ": still here\n\n";
  if (!text.empty()) last_sent_ = now;
  return text;
}

}  // namespace soak::station
