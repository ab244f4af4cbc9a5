// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "hal/devices/chamber.h"
#include "hal/devices/detail/quantity_access.h"

namespace soak::hal {

/// A chamber over the quantities of its controller; docs/register-maps.md says which ones it asks for.
[[nodiscard]] std::unique_ptr<Chamber> make_mapped_chamber(std::unique_ptr<QuantityAccess> controller);

/// Whether a chamber can have that reading: a finite number and, for a quantity in °C, one from −150 to 400 that is not
/// as near to 0 as only a float with exchanged words is.
[[nodiscard]] bool is_credible(std::string_view quantity, double value);

}  // namespace soak::hal
