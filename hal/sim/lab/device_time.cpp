// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/device_time.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

constexpr double kTicksPerNs = static_cast<double>(kTicksPerSecond) * 1e-9;
/// Host time that is made up for at most, so that a short delay does not slow the laboratory down.
constexpr std::int64_t kMaxLag_ns = 100'000'000;

}  // namespace

void LabClock::hold(std::int64_t host_ns, Tick now) {
  started_ = true;
  anchor_ns_ = host_ns;
  anchor_ = now;
}

Tick LabClock::allowed(std::int64_t host_ns, Tick now) {
  if (!started_) hold(host_ns, now);
  const auto at = [this](std::int64_t ns) {
    return anchor_ + static_cast<Tick>(std::floor(rate_ * kTicksPerNs * static_cast<double>(ns - anchor_ns_)));
  };
  if (at(host_ns - kMaxLag_ns) > now) hold(host_ns - kMaxLag_ns, now);
  return at(host_ns);
}

std::int64_t LabClock::ns_until(Tick tick, std::int64_t host_ns) const {
  const double due_ns = static_cast<double>(tick - anchor_) / (rate_ * kTicksPerNs);
  return std::max<std::int64_t>(0, anchor_ns_ + static_cast<std::int64_t>(std::ceil(due_ns)) - host_ns);
}

}  // namespace soak::hal::sim
