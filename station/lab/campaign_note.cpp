// SPDX-License-Identifier: Apache-2.0
#include "station/lab/campaign_note.h"

#include <exception>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "db/durable.h"
#include "station/io/host.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

constexpr std::chrono::seconds kNoteRetry{1};
constexpr std::chrono::seconds kNoteIsLate{2};
constexpr double kClockMayDiffer_s = 300.0;

std::string note_text(const CampaignNote& note, double noted_utc_s) {
  const nlohmann::json document = {{"campaign", note.campaign},       {"goes_on", note.goes_on},
                                   {"outputs_off", note.outputs_off}, {"outcome", note.outcome},
                                   {"reason", note.reason},           {"user", note.user},
                                   {"noted_utc_s", noted_utc_s}};
  return document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

FoundNote read_campaign_note(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return {};
  const auto document = nlohmann::json::parse(*text, nullptr, false);
  try {
    return {{document.at("campaign"), document.at("goes_on"), document.at("outputs_off"), document.at("outcome"),
             document.at("reason"), document.at("user")},
            document.at("noted_utc_s")};
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

bool is_recent_break(double noted_utc_s, double now_utc_s) {
  return now_utc_s - noted_utc_s <= kLongestBreak_s && noted_utc_s - now_utc_s <= kClockMayDiffer_s;
}

CampaignNoteKeeper::CampaignNoteKeeper(std::filesystem::path path, std::chrono::milliseconds renewal)
    : path_(std::move(path)), renewal_(renewal), found_(read_campaign_note(path_)), thread_([this] { work(); }) {}

CampaignNoteKeeper::~CampaignNoteKeeper() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CampaignNoteKeeper::keep(CampaignNote note) {
  const std::lock_guard lock(mutex_);
  wanted_ = std::move(note);
  note_change();
}

void CampaignNoteKeeper::withdraw(bool outputs_off) {
  const std::lock_guard lock(mutex_);
  if (!wanted_) wanted_ = found_.note;
  wanted_->goes_on = false;
  is_withdrawn_ = true;
  is_too_hot_ = is_too_hot_ || outputs_off;
  note_change();
}

void CampaignNoteKeeper::allow() {
  const std::lock_guard lock(mutex_);
  is_withdrawn_ = is_too_hot_ = false;
  note_change();
}

void CampaignNoteKeeper::note_change() {
  if (kept_ == allowed()) {
    behind_since_ = {};  // back to what the file holds, before another was written
  } else if (behind_since_ == Clock::time_point{}) {
    behind_since_ = Clock::now();
  }
  changed_.notify_all();
}

bool CampaignNoteKeeper::wait_until_kept(std::chrono::milliseconds longest) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, longest, [this] { return kept_ == allowed(); });
}

std::string CampaignNoteKeeper::trouble() const {
  const std::lock_guard lock(mutex_);
  const bool is_late = behind_since_ != Clock::time_point{} && Clock::now() - behind_since_ > kNoteIsLate;
  return trouble_.empty() && is_late ? "the disk has not taken it yet" : trouble_;
}

std::optional<CampaignNote> CampaignNoteKeeper::allowed() const {
  auto note = wanted_;
  if (note && is_withdrawn_) note->goes_on = false;
  if (note && is_too_hot_) note->outputs_off = true;
  return note;
}

void CampaignNoteKeeper::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    const bool failed = !trouble_.empty();
    const std::chrono::milliseconds pause = failed ? std::chrono::milliseconds(kNoteRetry) : renewal_;
    const bool woken = changed_.wait_for(lock, pause, [&] { return ends_ || (!failed && kept_ != allowed()); });
    const auto note = allowed();
    const bool renews = !woken && note && note->goes_on;
    if (note && (kept_ != note || renews)) {
      kept_.reset();
      lock.unlock();
      std::string trouble = write(*note);
      lock.lock();
      if (trouble.empty()) kept_ = note;
      trouble_ = std::move(trouble);
      if (kept_ == allowed()) behind_since_ = {};
      changed_.notify_all();
    }
    if (ends_ && (kept_ == allowed() || !trouble_.empty())) return;
  }
}

std::string CampaignNoteKeeper::write(const CampaignNote& note) const {
  try {
    const auto kept = write_text_file(path_, note_text(note, now_utc_s()));
    if (kept) return {};
    log_line("what the next soakd is to know of the campaign cannot be noted: " + kept.error().message);
    std::error_code error;
    std::filesystem::remove(path_, error);
    (void)db::sync_name(path_);
    return kept.error().message;
  } catch (const std::exception&) {  // no memory: the next try may have some
    return "no memory";
  }
}

}  // namespace soak::station
