// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "hal/sim/lab/device_time.h"

namespace soak::hal::sim {

/// How far the laboratory may have advanced at a moment of host time. Time that is lost, because a reader or the
/// machine was slow, is not made up for.
class LabClock {
 public:
  /// `rate`: device seconds per second of host time.
  explicit LabClock(double rate) : rate_(rate) {}

  /// Tick that the laboratory may advance to; it stands at `now`.
  [[nodiscard]] Tick allowed(std::int64_t host_ns, Tick now);
  /// The laboratory stands still at `now`: device time goes on from here.
  void hold(std::int64_t host_ns, Tick now);
  /// Host time until `tick` may be reached; 0 if it may be already.
  [[nodiscard]] std::int64_t ns_until(Tick tick, std::int64_t host_ns) const;

 private:
  double rate_;
  bool started_ = false;
  std::int64_t anchor_ns_ = 0;
  Tick anchor_ = 0;
};

}  // namespace soak::hal::sim
