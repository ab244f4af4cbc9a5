// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "station/output.h"

namespace soak::station {

/// soak gap find --unit SN [--campaign NAME]
struct GapFindCommand {
  std::string data;
  std::string unit;
  std::optional<std::string> campaign;
};

/// Looks for what the unit's newest model lacks in the runs that a fit takes. Refuses (bad_input) a unit without a
/// model: the gap is that of a model.
[[nodiscard]] base::Status run_gap_find(const GapFindCommand& command, Output& output);

}  // namespace soak::station
