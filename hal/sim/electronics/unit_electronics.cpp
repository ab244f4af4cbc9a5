// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/electronics/unit_electronics.h"

#include <utility>

#include "hal/sim/electronics/detail/ahrs400_device.h"
#include "hal/sim/electronics/detail/vectornav_device.h"
#include "hal/sim/electronics/detail/xbus_device.h"

namespace soak::hal::sim {

base::Bytes UnitElectronics::take_output() { return std::exchange(output_, {}); }

void UnitElectronics::put_out(std::span<const std::uint8_t> bytes) {
  output_.insert(output_.end(), bytes.begin(), bytes.end());
}

std::unique_ptr<UnitElectronics> make_unit(UnitKind kind, const CampaignConfig& config, int number) {
  switch (kind) {
    case UnitKind::xsens:
      return std::make_unique<XbusDevice>(config, number);
    case UnitKind::ahrs400:
      return std::make_unique<Ahrs400Device>(config, number);
    case UnitKind::vectornav:
      return std::make_unique<VectorNavDevice>(config, number);
  }
  return nullptr;
}

}  // namespace soak::hal::sim
