// SPDX-License-Identifier: Apache-2.0
#include "station/alarms/courier.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "station/alarms/alarm_message.h"
#include "station/io/host.h"

namespace soak::station {

using nlohmann::json;

Courier::Courier(std::unique_ptr<Delivery> delivery, Note note)
    : delivery_(std::move(delivery)), note_(std::move(note)), thread_([this] { work(); }) {}

Courier::~Courier() {
  stop();
  thread_.join();
  for (const Letter& letter : letters_) {
    note_("alarm_not_sent",
          fmt::format("not sent to {}: {}: soakd ends", delivery_->destination(), letter.message.subject));
  }
}

void Courier::stop() {
  const std::lock_guard lock(mutex_);
  stop_ = true;
  changed_.notify_all();
}

void Courier::add(AlarmMessage message) {
  std::optional<Letter> dropped;
  {
    const std::lock_guard lock(mutex_);
    if (letters_.size() >= kMostWaiting) {
      const auto oldest = std::ranges::min_element(letters_, {}, &Letter::given);
      dropped = std::move(*oldest);
      letters_.erase(oldest);
    }
    letters_.push_back({std::move(message), Clock::now()});
  }
  changed_.notify_all();
  if (dropped) {
    note_("alarm_not_sent", fmt::format("not sent to {}: {}: newer ones need its room", delivery_->destination(),
                                        dropped->message.subject));
  }
}

base::Status Courier::test(const AlarmMessage& message, const std::string& user) {
  const base::Status sent = send(message);
  const double utc_s = now_utc_s();
  const std::lock_guard lock(mutex_);
  note_try(sent, utc_s);
  test_ = {utc_s, user, trouble_};
  changed_.notify_all();
  return sent;
}

base::Status Courier::send(const AlarmMessage& message) const {
  try {
    return delivery_->send(message, stop_);
  } catch (const std::exception& error) {
    return base::fail(base::ErrorKind::internal, std::string("the try broke off: ") + error.what(),
                      delivery_->destination());
  }
}

void Courier::note_try(const base::Status& sent, double utc_s) {
  trouble_ = sent ? "" : one_line(sent.error().message);
  if (!sent) return;
  sent_utc_s_ = utc_s;
  for (Letter& other : letters_) other.due = std::min(other.due, Clock::now());
}

nlohmann::json Courier::document() const {
  const auto null_if_empty = [](const std::string& text) { return text.empty() ? json() : json(text); };
  const std::lock_guard lock(mutex_);
  json test;
  if (test_) test = {{"utc_s", test_->utc_s}, {"user", test_->user}, {"trouble", null_if_empty(test_->trouble)}};
  return {{"way", delivery_->way()},
          {"to", delivery_->destination()},
          {"waiting", letters_.size()},
          {"trouble", null_if_empty(trouble_)},
          {"sent_utc_s", sent_utc_s_ ? json(*sent_utc_s_) : json()},
          {"test", std::move(test)}};
}

void Courier::work() {
  while (true) {
    try {
      if (!deliver_next()) return;
    } catch (const std::exception& error) {  // no memory: the next try may have some
      log_line(fmt::format("a message to {} was lost: {}", delivery_->destination(), error.what()));
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kPauses.front(), [this] { return stop_.load(); });
    }
  }
}

bool Courier::deliver_next() {
  std::unique_lock lock(mutex_);
  const auto next = [this] { return std::ranges::min_element(letters_, {}, &Letter::due); };
  while (!stop_ && (letters_.empty() || next()->due > Clock::now())) {
    if (letters_.empty()) {
      changed_.wait(lock);
    } else {
      const Clock::time_point due = next()->due;  // the letter itself may make room meanwhile
      changed_.wait_until(lock, due);
    }
  }
  if (stop_) return false;
  Letter letter = std::move(*next());
  letters_.erase(next());
  lock.unlock();
  const base::Status sent = send(letter.message);
  const bool stays_here = stays(letter, sent);
  lock.lock();
  note_try(sent, now_utc_s());
  if (stays_here) letters_.push_back(std::move(letter));
  return true;
}

bool Courier::stays(Letter& letter, const base::Status& sent) {
  const std::string what =
      fmt::format("{} to {}: {}", sent ? "sent" : "not sent", delivery_->destination(), letter.message.subject);
  if (sent) {
    note_("alarm_sent", what);
    return false;
  }
  if (stop_) return true;
  const bool given_up = Clock::now() - letter.given > kGivenUpAfter;
  // One event for each message, not for each try: a server that is away for a night would fill the log.
  if (letter.tries == 0 || given_up) {
    note_("alarm_not_sent",
          fmt::format("{}: {}; {}", what, one_line(sent.error().message), given_up ? "given up" : "it is tried again"));
  }
  letter.due = Clock::now() + kPauses.at(std::min(letter.tries++, kPauses.size() - 1));
  return !given_up;
}

}  // namespace soak::station
