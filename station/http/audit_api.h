// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "station/http/runs_api.h"

namespace soak::station {

/// Questions about the event log: who did what when, and whether the log is as it was written. docs/http-api.md.
[[nodiscard]] const std::vector<RunQuestion>& audit_questions();

}  // namespace soak::station
