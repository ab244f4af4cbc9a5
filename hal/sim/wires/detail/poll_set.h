// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <functional>
#include <utility>
#include <vector>

namespace soak::hal::sim {

/// What to wait for, and whom to tell. Built anew for each wait.
class PollSet {
 public:
  using Handler = std::function<void(short events)>;

  void add(int fd, short events, Handler handler) {
    entries_.push_back({fd, events, 0});
    handlers_.push_back(std::move(handler));
  }

  /// Waits for at most `timeout_ns` (negative: without limit) and calls the handlers of all descriptors that something
  /// has happened to.
  void wait(std::int64_t timeout_ns) {
    const timespec timeout = {timeout_ns / 1'000'000'000, timeout_ns % 1'000'000'000};
    if (ppoll(entries_.data(), entries_.size(), timeout_ns < 0 ? nullptr : &timeout, nullptr) <= 0) return;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (entries_[i].revents != 0) handlers_[i](entries_[i].revents);
    }
  }

 private:
  std::vector<pollfd> entries_;
  std::vector<Handler> handlers_;
};

}  // namespace soak::hal::sim
