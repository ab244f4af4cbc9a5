// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "settings/reader.h"

namespace soak::station {

/// Between which a set point of a procedure lies, whatever units and chamber allow.
inline constexpr settings::Limits kSetPoint_c = {-200.0, 300.0};

}  // namespace soak::station
