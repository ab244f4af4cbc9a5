// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace soak::hal::sim {

/// Bounds of a uniform draw.
struct Range {
  double low = 0.0;
  double high = 0.0;
};

}  // namespace soak::hal::sim
