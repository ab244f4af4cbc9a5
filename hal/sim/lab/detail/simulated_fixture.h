// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/lab_fixture.h"
#include "hal/sim/lab/register_table.h"
#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {

/// Six positions, numbered 1 ... 6 in the order of calib::kSixPositionLabels. A request that
/// comes while it turns is begun when the turn has ended; only the last one counts. It starts in position 5, +Z.
class SimulatedFixture final : public LabFixture {
 public:
  SimulatedFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth);

  void advance_to(Tick now) override;
  [[nodiscard]] Attitude attitude() const override;
  [[nodiscard]] RegisterTable& registers() override { return registers_; }

 private:
  [[nodiscard]] bool moves() const { return turn_end_ > now_; }
  void begin_turn();

  double turn_s_per_rad_;
  std::optional<EarthFrame> earth_;
  Tick now_ = 0;
  int requested_;
  int from_;
  int position_;  ///< where it stands or turns to
  Tick turn_start_ = 0;
  Tick turn_end_ = 0;
  RegisterTable registers_;
};

}  // namespace soak::hal::sim
