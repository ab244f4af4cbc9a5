// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calib/vocabulary/reference.h"

namespace soak::calib::exporting {

/// What the campaigns were measured with, for the comments of an exported file: a line for each reference, and one
/// behind it, indented, for its waiver. `clean` makes what people wrote (names, reasons) fit for the comment.
[[nodiscard]] std::vector<std::string> reference_lines(const std::vector<ReferenceUse>& uses,
                                                       const std::function<std::string(std::string)>& clean);

}  // namespace soak::calib::exporting
