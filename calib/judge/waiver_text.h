// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "calib/vocabulary/reference.h"

namespace soak::calib {

/// The text that the signer of a waiver signs (docs/records.md): which entry of the register, why, who, when. Refuses a
/// text with a control character, which could make two waivers of one text.
[[nodiscard]] base::Result<std::string> waiver_text(const Waiver& waiver, const Reference& reference);

}  // namespace soak::calib
