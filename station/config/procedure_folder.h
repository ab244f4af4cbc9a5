// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// Where the procedures lie that a person can choose from: `procedures` of the data folder, which are the laboratory's
/// own, then $SOAK_PROCEDURES, else those that Soak comes with. They need not exist.
[[nodiscard]] std::vector<std::filesystem::path> procedure_folders(const std::filesystem::path& data_folder);

/// The *.toml of that name, of the first folder that has one; nothing where none has. A name is only compared with
/// those that are there: no path leads elsewhere.
[[nodiscard]] std::optional<std::filesystem::path> procedure_file(const std::vector<std::filesystem::path>& folders,
                                                                  const std::string& file);

/// Its text. Refuses (bad_input) one that is longer than 256 KiB, and what read_text_file() refuses.
[[nodiscard]] base::Result<std::string> procedure_file_text(const std::filesystem::path& path);

/// The *.toml of these folders, in the order of their names; of two with the same name that of the
/// first folder. One that is wrong, or longer than 256 KiB, has `trouble` instead of what it says. `file`: only the one
/// of that name, with its text and what of it can be changed (procedure_changes.h); empty = all. `room_c`: as
/// compile_plan() has it. Document of GET /api/v1/procedures: docs/http-api.md.
[[nodiscard]] nlohmann::json procedures_document(const std::vector<std::filesystem::path>& folders,
                                                 const std::string& file, double room_c);

}  // namespace soak::station
