// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/unit_type.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"
#include "station/commands/command.h"
#include "station/io/output.h"

/// What several commands do.
namespace soak::station {

/// {"code", "text"} of each.
[[nodiscard]] nlohmann::json warnings_json(const std::vector<calib::Warning>& warnings);

/// One line on standard error for all references that were used by a waiver, and one for each waiver whose signature
/// does not match; nothing where no waiver was used. `about`: what each line begins with.
void note_waivers(const std::vector<calib::ReferenceUse>& references, Output& output, const std::string& about = {});

/// " (SIMULATED, NOT RELEASED)", or what of it holds for a file; empty for one of a released model of measured data.
[[nodiscard]] std::string marks_text(const calib::Calibration& calibration);

/// Reads the name of who does something, which goes into records that nobody can change: one plain line.
[[nodiscard]] OptionReader name_reader(std::string& name);

/// The argument RUN of a command, and the options that narrow its search.
void declare_run(OptionList& options, db::RunFilter& filter);

/// The type of that name; fails (bad_input) if the folder (empty = default_unit_type_folder()) does not have it.
[[nodiscard]] base::Result<calib::UnitType> find_unit_type(const std::string& folder, const std::string& name);

}  // namespace soak::station
