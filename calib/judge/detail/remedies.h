// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::calib {

/// What to do about a warning of this code, one sentence in plain words (docs/fit.md has the table); empty for a code
/// that nobody has written one for.
[[nodiscard]] std::string_view remedy_of(std::string_view code);

}  // namespace soak::calib
