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

/// Sends messages one way, in their order, from a thread of its own, which waits for the server: nobody else does. What
/// the server does not take is tried again after kPauses, the last of them again and again, until it is kGivenUpAfter
/// old. Any thread may call.
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
  /// Sends a message at once, from the caller's thread, and does not try again.
  [[nodiscard]] base::Status send_now(const AlarmMessage& message) const;
  [[nodiscard]] const Delivery& delivery() const { return *delivery_; }
  /// {"way", "to", "waiting", "trouble", "sent_utc_s"}: docs/http-api.md.
  [[nodiscard]] nlohmann::json document() const;

 private:
  struct Letter {
    AlarmMessage message;
    std::chrono::steady_clock::time_point given;
    std::size_t tries = 0;
  };

  void work();
  /// Notes what became of a try; whether the letter stays for another one.
  [[nodiscard]] bool stays(Letter& letter, const base::Status& sent);

  std::unique_ptr<Delivery> delivery_;
  Note note_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Letter> letters_;
  std::string trouble_;  ///< of the last try; empty after one that was taken
  std::optional<double> sent_utc_s_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace soak::station
