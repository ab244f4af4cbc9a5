// SPDX-License-Identifier: Apache-2.0
#include "station/lab/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <utility>

#include "station/io/host.h"

namespace soak::station {
namespace {

constexpr std::chrono::seconds kJournalRetry{1};

base::Status enter(db::Catalog& catalog, const db::EventRow& event) { return catalog.log_event(event); }

base::Status enter(db::Catalog& catalog, const db::StepRow& step) { return catalog.complete_step(step); }

base::Status enter(db::Catalog& catalog, const Journal::State& state) {
  return catalog.set_campaign_state(state.campaign, state.state, state.reason, state.user);
}

}  // namespace

base::Result<std::unique_ptr<Journal>> Journal::open(const std::filesystem::path& data_folder,
                                                     std::function<void()> written, std::size_t most_events) {
  auto catalog = db::Catalog::open(data_folder);
  if (!catalog) return base::forward_error(catalog);
  return std::unique_ptr<Journal>(new Journal(*std::move(catalog), std::move(written), most_events));
}

Journal::Journal(db::Catalog catalog, std::function<void()> written, std::size_t most_events)
    : catalog_(std::move(catalog)), tell_(std::move(written)), most_events_(most_events), thread_([this] { work(); }) {}

void Journal::end() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

Journal::Ticket Journal::add_entry(Row row) {
  const std::lock_guard lock(mutex_);
  if (std::holds_alternative<db::EventRow>(row) && queue_.size() >= most_events_) {
    ++discarded_;
    return last_;
  }
  note_discarded();
  queue_.push_back({++last_, std::move(row), std::chrono::steady_clock::now()});
  changed_.notify_all();
  return last_;
}

/// A gap in the log says how long it is, in its place.
void Journal::note_discarded() {
  if (discarded_ == discarded_noted_ || queue_.size() >= most_events_) return;
  const std::string text = fmt::format(
      "{} events found no room while the catalog could not be written: see soakd's log", discarded_ - discarded_noted_);
  discarded_noted_ = discarded_;
  queue_.push_back({++last_, db::EventRow{now_utc_s(), "journal", "", text}, std::chrono::steady_clock::now()});
}

void Journal::work() {
  std::size_t most = kMostInBatch;
  while (true) {
    try {
      if (!write_batch(most)) return;
    } catch (const std::exception&) {  // no memory: the next try may have some
      std::unique_lock lock(mutex_);
      trouble_ = "no memory";
      changed_.wait_for(lock, kJournalRetry, [this] { return ends_; });
    }
  }
}

bool Journal::write_batch(std::size_t& most) {
  const std::vector<Entry> entries = next_batch(most);
  if (entries.empty()) return false;
  most = kMostInBatch;
  std::size_t at = 0;
  if (const auto stored = enter_all(entries, at); stored) {
    note_written(entries.size());
  } else if (stored.error().kind != base::ErrorKind::bad_input) {
    note_trouble(stored.error().where + ": " + stored.error().message);
    return true;
  } else if (at > 0) {
    most = at;  // those before the one that is refused come first
    return true;
  } else {
    note_refused(stored.error().where + ": " + stored.error().message);
  }
  tell_();
  return true;
}

std::vector<Journal::Entry> Journal::next_batch(std::size_t most) const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ends_ || !queue_.empty(); });
  if (ends_) return {};
  const auto count = static_cast<std::ptrdiff_t>(std::min(most, queue_.size()));
  return {queue_.begin(), queue_.begin() + count};
}

base::Status Journal::enter_all(const std::vector<Entry>& entries, std::size_t& at) {
  return catalog_.all_or_nothing([&]() -> base::Status {
    for (at = 0; at < entries.size(); ++at) {
      auto entered = std::visit([this](const auto& row) { return enter(catalog_, row); }, entries[at].row);
      if (!entered) return entered;
    }
    return {};
  });
}

void Journal::note_written(std::size_t count) {
  const std::lock_guard lock(mutex_);
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(count));
  trouble_.clear();
  changed_.notify_all();
}

void Journal::note_refused(std::string why) {
  log_line("the journal refuses an entry: " + why);
  const std::lock_guard lock(mutex_);
  if (!std::holds_alternative<db::EventRow>(queue_.front().row)) {
    refused_.insert(queue_.front().ticket);
    refusal_ = std::move(why);
  }
  queue_.pop_front();
  trouble_.clear();
  changed_.notify_all();
}

void Journal::note_trouble(std::string why) {
  log_line("the journal cannot be written: " + why);
  std::unique_lock lock(mutex_);
  trouble_ = std::move(why);
  changed_.wait_for(lock, kJournalRetry, [this] { return ends_; });
}

Journal::Written Journal::written(Ticket ticket) const {
  const std::lock_guard lock(mutex_);
  if (!queue_.empty() && queue_.front().ticket <= ticket) return Written::not_yet;
  return refused_.contains(ticket) ? Written::refused : Written::yes;
}

std::string Journal::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

Journal::Standing Journal::standing() const {
  const std::lock_guard lock(mutex_);
  Standing standing{queue_.size(), discarded_, 0.0, trouble_};
  if (queue_.empty()) return standing;
  standing.behind_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - queue_.front().given).count();
  return standing;
}

bool Journal::wait_until_written(std::chrono::milliseconds longest) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, longest, [this] { return queue_.empty(); });
}

}  // namespace soak::station
