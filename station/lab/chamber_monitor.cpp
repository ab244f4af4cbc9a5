// SPDX-License-Identifier: Apache-2.0
#include "station/lab/chamber_monitor.h"

#include <cmath>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSoonest{2};
constexpr std::chrono::seconds kStale{10};
constexpr int kMisses = 3;
constexpr int kDisobeyed = 3;
constexpr double kSetPointTolerance_c = 0.5;

}  // namespace

bool ChamberMonitor::poll(double now_s) {
  const auto host_now = steady_clock::now();
  // By the host's clock too: a unit whose clock stands still must not leave the chamber unwatched.
  const bool due = !polled_s_ || now_s - *polled_s_ >= poll_s_ ||
                   std::chrono::duration<double>(host_now - polled_host_).count() >= poll_s_;
  if (!due || host_now - polled_host_ < kSoonest) return false;
  polled_s_ = now_s;
  auto reading = chamber_.read();
  polled_host_ = steady_clock::now();
  if (!reading) {
    trouble_ = reading.error().message;
    if (++misses_ >= kMisses || polled_host_ - heard_host_ > kStale) reading_.reset();
    return false;
  }
  misses_ = 0;
  trouble_.clear();
  heard_host_ = polled_host_;
  reading_ = *std::move(reading);
  air_.add(now_s, reading_->air_c);
  const bool obeys =
      !expected_c_ || (reading_->running && std::abs(reading_->set_point_c - *expected_c_) <= kSetPointTolerance_c);
  disobeyed_ = obeys ? 0 : disobeyed_ + 1;
  return true;
}

bool ChamberMonitor::disobeys() const { return disobeyed_ >= kDisobeyed; }

std::optional<double> ChamberMonitor::age_s() const {
  if (heard_host_ == steady_clock::time_point{}) return std::nullopt;
  return std::chrono::duration<double>(steady_clock::now() - heard_host_).count();
}

}  // namespace soak::station
