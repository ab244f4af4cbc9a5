// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>

#include "base/result.h"
#include "station/alarms/delivery.h"

namespace soak::station {

/// Sends messages one way, from a thread of its own, which waits for the server: nobody else does. A new message is
/// tried at once, those that are new in their order. What the server does not take is tried again after kPauses, the
/// last of them again and again, and as soon as the server takes another one, until it is kGivenUpAfter old. A delivery
/// that throws is a try that failed. Any thread may call.
class Courier {
 public:
  static constexpr std::size_t kMostWaiting = 100;  ///< the oldest one makes room for one more
  static constexpr std::array<std::chrono::seconds, 5> kPauses = {std::chrono::seconds(2), std::chrono::seconds(10),
                                                                  std::chrono::seconds(60), std::chrono::seconds(300),
                                                                  std::chrono::seconds(900)};
  static constexpr std::chrono::hours kGivenUpAfter{24};

  /// Takes note of what became of a message: kind of event, text.
  using Note = std::function<void(const std::string& kind, const std::string& text)>;

  Courier(std::unique_ptr<Delivery> delivery, Note note);
  Courier(const Courier&) = delete;
  Courier& operator=(const Courier&) = delete;
  /// Ends the thread; what waits is not sent, which is noted.
  ~Courier();

  void add(AlarmMessage message);
  /// Breaks off what is being sent; nothing is sent any more.
  void stop();
  /// Sends a message of `user`'s at once, from the caller's thread, and does not try again.
  [[nodiscard]] base::Status test(const AlarmMessage& message, const std::string& user);
  [[nodiscard]] const Delivery& delivery() const { return *delivery_; }
  /// {"way", "to", "waiting", "trouble", "sent_utc_s", "test"}: docs/http-api.md.
  [[nodiscard]] nlohmann::json document() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Letter {
    AlarmMessage message;
    Clock::time_point given;
    Clock::time_point due = Clock::time_point::min();  ///< of one that is new: before those that are tried again
    std::size_t tries = 0;
  };

  /// The last one that somebody asked for.
  struct Test {
    double utc_s = 0.0;
    std::string user;
    std::string trouble;  ///< empty: the server took it
  };

  /// A delivery that throws has failed.
  [[nodiscard]] base::Status send(const AlarmMessage& message) const;
  /// With the mutex locked: what became of a try that ended at that time. A server that takes one may take others.
  void note_try(const base::Status& sent, double utc_s);
  void work();
  /// Waits for a letter that is due, and tries it; false once the thread is to end.
  [[nodiscard]] bool deliver_next();
  /// Notes what became of a try; whether the letter stays for another one.
  [[nodiscard]] bool stays(Letter& letter, const base::Status& sent);

  std::unique_ptr<Delivery> delivery_;
  Note note_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Letter> letters_;
  std::string trouble_;  ///< of the last try; empty after one that was taken
  std::optional<double> sent_utc_s_;
  std::optional<Test> test_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace soak::station
