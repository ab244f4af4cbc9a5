// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "base/result.h"

namespace soak::calib::signal::denoising {

/// Refuses a value that is negative or not finite; `what` names the values ("threshold"), `where` tells the level.
[[nodiscard]] base::Status check_not_negative(std::span<const double> values, std::string_view what);

}  // namespace soak::calib::signal::denoising
