// SPDX-License-Identifier: Apache-2.0
#include "station/alarms/courier.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/alarms/alarm_message.h"
#include "station/io/host.h"

namespace soak::station {

Courier::Courier(std::unique_ptr<Delivery> delivery, Note note)
    : delivery_(std::move(delivery)), note_(std::move(note)), thread_([this] { work(); }) {}

Courier::~Courier() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
  for (const Letter& letter : letters_) {
    note_("alarm_not_sent",
          fmt::format("not sent to {}: {}: soakd ends", delivery_->destination(), letter.message.subject));
  }
}

void Courier::add(AlarmMessage message) {
  std::optional<Letter> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (letters_.size() >= kMostWaiting) {
      dropped = std::move(letters_.front());
      letters_.pop_front();
    }
    letters_.push_back({std::move(message), std::chrono::steady_clock::now()});
  }
  changed_.notify_all();
  if (dropped) {
    note_("alarm_not_sent", fmt::format("not sent to {}: {}: newer ones need its room", delivery_->destination(),
                                        dropped->message.subject));
  }
}

base::Status Courier::send_now(const AlarmMessage& message) const { return delivery_->send(message, stop_); }

nlohmann::json Courier::document() const {
  const std::lock_guard lock(mutex_);
  return {{"way", delivery_->way()},
          {"to", delivery_->destination()},
          {"waiting", letters_.size()},
          {"trouble", trouble_.empty() ? nlohmann::json() : nlohmann::json(trouble_)},
          {"sent_utc_s", sent_utc_s_ ? nlohmann::json(*sent_utc_s_) : nlohmann::json()}};
}

void Courier::work() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    if (letters_.empty()) {
      changed_.wait(lock, [this] { return stop_ || !letters_.empty(); });
      continue;
    }
    Letter letter = std::move(letters_.front());
    letters_.pop_front();
    lock.unlock();
    const base::Status sent = delivery_->send(letter.message, stop_);
    const bool stays_here = stays(letter, sent);
    lock.lock();
    trouble_ = sent ? "" : one_line(sent.error().message);
    if (sent) sent_utc_s_ = now_utc_s();
    if (!stays_here) continue;
    letters_.push_front(std::move(letter));
    if (stop_) return;
    const auto pause = kPauses.at(std::min(letters_.front().tries, kPauses.size()) - 1);
    changed_.wait_for(lock, pause, [this] { return stop_.load(); });
  }
}

bool Courier::stays(Letter& letter, const base::Status& sent) {
  const std::string what =
      fmt::format("{} to {}: {}", sent ? "sent" : "not sent", delivery_->destination(), letter.message.subject);
  if (sent) {
    note_("alarm_sent", what);
    return false;
  }
  if (stop_) return true;
  const bool given_up = std::chrono::steady_clock::now() - letter.given > kGivenUpAfter;
  // One event for each message, not for each try: a server that is away for a night would fill the log.
  if (letter.tries++ == 0 || given_up) {
    note_("alarm_not_sent",
          fmt::format("{}: {}; {}", what, one_line(sent.error().message), given_up ? "given up" : "it is tried again"));
  }
  return !given_up;
}

}  // namespace soak::station
