// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "hal/sim/config/campaign_config.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/lab/register_table.h"
#include "hal/sim/unit/attitude.h"

namespace soak::hal::sim {

enum class FixtureKind : std::uint8_t { six_positions, two_axis };

/// What turns the units, as its controller's registers say.
class LabFixture {
 public:
  LabFixture() = default;
  LabFixture(const LabFixture&) = delete;
  LabFixture& operator=(const LabFixture&) = delete;
  virtual ~LabFixture() = default;

  virtual void advance_to(Tick now) = 0;
  /// How it holds or turns its own axes now.
  [[nodiscard]] virtual Attitude attitude() const = 0;
  [[nodiscard]] virtual RegisterTable& registers() = 0;
};

[[nodiscard]] std::unique_ptr<LabFixture> make_fixture(FixtureKind kind, const CampaignConfig& config);

}  // namespace soak::hal::sim
