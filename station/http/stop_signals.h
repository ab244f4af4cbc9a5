// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <signal.h>

#include <functional>
#include <thread>
#include <utility>

namespace soak::station {

/// From its making on, SIGTERM and SIGINT reach no thread but the one that waits for them.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGTERM, SIGINT, kQuit}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    // A connection that the peer has closed, a file that grows too large: errors of the write, not our end.
    for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals() { release(); }

  /// No signal reaches what stop_with() was given any more: before that is destroyed.
  void release() {
    if (!waiter_.joinable()) return;
    pthread_kill(waiter_.native_handle(), kQuit);
    waiter_.join();
  }

  /// `stop` is called, by another thread, whenever one of them comes; until release().
  void stop_with(std::function<void()> stop) {
    waiter_ = std::thread([this, stop = std::move(stop)] {
      for (int signal = 0; sigwait(&signals_, &signal) == 0 && signal != kQuit;) stop();
    });
  }

 private:
  static constexpr int kQuit = SIGUSR1;  ///< ends the waiting thread
  sigset_t signals_{};
  std::thread waiter_;
};

}  // namespace soak::station
