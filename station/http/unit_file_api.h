// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"
#include "station/http/parameters.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// A file to be saved.
struct UnitFile {
  std::string name;
  std::string content;
};

/// GET /api/v1/unit/file?unit=SN&format=FORMAT: the file of the unit's newest released model that keeps the rule of
/// release (release_rule.h); `simulated=true`: also one of simulated data. The first time that a file is given enters
/// the event log, under the name of who has it (`user`; empty: nobody is known). Refuses (bad_input) another unit or
/// format than there is, and (where == "state") where no model may be handed over, naming the reasons.
[[nodiscard]] base::Result<UnitFile> unit_file(RunArchive& archive, const Parameters& parameters,
                                               const std::string& user);

}  // namespace soak::station
