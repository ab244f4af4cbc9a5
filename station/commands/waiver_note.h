// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/vocabulary/reference.h"
#include "station/io/output.h"

namespace soak::station {

/// One line on standard error where a reference was used by a waiver, and one for each waiver without a good signature;
/// nothing where none was.
void note_waivers(const std::vector<calib::ReferenceUse>& references, Output& output);

}  // namespace soak::station
