// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace soak::hal::sim {

/// The laboratory's own time, counted in ticks of 2.5 ms: one internal sample of a unit.
using Tick = std::int64_t;

inline constexpr Tick kTicksPerSecond = 400;
/// Heat, controller and slow noise advance every 0.1 s.
inline constexpr Tick kTicksPerStep = 40;
inline constexpr double kStep_s = 0.1;

/// Tick that lies nothing or less than a tick after `duration_s`.
constexpr Tick ticks_of(double duration_s) {
  const double ticks = duration_s * static_cast<double>(kTicksPerSecond);
  const auto whole = static_cast<Tick>(ticks);
  return static_cast<double>(whole) < ticks ? whole + 1 : whole;
}

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
