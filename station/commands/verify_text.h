// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "station/release/judgement.h"

namespace soak::station {

/// What `soak verify` prints of one calibration: the table of its sensors in deg/s, m/s² and ppm, what was not judged,
/// the rule, and what became of the verdict.
[[nodiscard]] std::string verify_text(const Judgement& judgement, const StoredJudgement& stored);

}  // namespace soak::station
