// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "hal/sim/lab/detail/turning_axis.h"
#include "hal/sim/lab/lab_fixture.h"

namespace soak::hal::sim {

/// A tilting axis, horizontal in the room, that carries a turning axis with slip rings. At 0, 0 the fixture's +Z points
/// up, the outer axis lies along its +X, the inner one along its +Z; with `earth` its +X then points at
/// `earth->azimuth_deg`. It starts there, and does what was asked of it once a command begins it; a command in mid-way
/// is begun from there.
class TwoAxisFixture final : public LabFixture {
 public:
  TwoAxisFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth);

  void advance_to(Tick now) override { now_ = now; }
  [[nodiscard]] Attitude attitude() const override;
  [[nodiscard]] RegisterTable& registers() override { return registers_; }

 private:
  void add_registers();
  void carry_out(int command);
  /// Within the turn, -180 ... 180: the slip rings count no turns.
  [[nodiscard]] double inner_deg() const;

  std::optional<EarthFrame> earth_;
  Tick now_ = 0;
  TurningAxis outer_;
  TurningAxis inner_;
  double asked_outer_deg_ = 0.0;
  double asked_inner_deg_ = 0.0;
  double asked_dps_ = 0.0;
  RegisterTable registers_;
};

}  // namespace soak::hal::sim
