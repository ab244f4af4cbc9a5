// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace soak::hal {

enum class FixtureAxis : std::uint8_t { outer, inner };

struct AxisAngles {
  double outer_deg = 0.0;
  double inner_deg = 0.0;
};

/// A fixture of two axes that are told angles: the outer one stands still in the room and carries the inner one, which
/// carries the units. As the section [axes] of its map says (docs/register-maps.md).
struct FixtureAxes {
  double tolerance_deg = 0.0;          ///< an angle read within it counts as reached
  std::vector<AxisAngles> angles_deg;  ///< of RegisterMap::positions
  std::optional<FixtureAxis> spins;    ///< the axis without an end, which can turn at a rate
  double rate_tolerance_dps = 0.0;
  /// Of those positions, where the axis that spins is vertical: +1 if a positive rate of it is counter-clockwise seen
  /// from above, -1 if clockwise; 0 elsewhere.
  std::vector<int> spin_sign;
};

}  // namespace soak::hal
