// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/result.h"
#include "hal/devices/detail/controller.h"

namespace soak::hal {

/// What the quantity `status` of a fixture's map means.
class FixtureStatus {
 public:
  /// Its codes must hold standing, moving and fault.
  explicit FixtureStatus(const RegisterMap& map);

  /// Whether it moves; a fault and a code that the map does not know are errors (device) of `controller`.
  [[nodiscard]] base::Result<bool> moving(const Controller& controller, double status) const;

 private:
  int moving_ = 0;
  int standing_ = 0;
  int fault_ = 0;
};

}  // namespace soak::hal
