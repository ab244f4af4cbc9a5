// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "hal/devices/fixture.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// The fixture of a sound map with [axes].
[[nodiscard]] std::unique_ptr<Fixture> make_two_axis_fixture(const RegisterMap& map);

}  // namespace soak::hal
