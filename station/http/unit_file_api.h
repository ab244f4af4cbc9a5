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

/// GET /api/v1/unit/file?unit=SN&format=FORMAT: the file of the unit's newest released model; `simulated=true`: also of
/// one of simulated data. The first time that a file is given enters the event log, under the name of who has it
/// (`user`; empty: nobody is known). Refuses (bad_input) another unit or format than there is, and (where == "state")
/// where no model is released or the newest that is does not keep the rule of release (release_rule.h) now, naming the
/// reasons: an older one is not given in its place.
[[nodiscard]] base::Result<UnitFile> unit_file(RunArchive& archive, const Parameters& parameters,
                                               const std::string& user);

}  // namespace soak::station
