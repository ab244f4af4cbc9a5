// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// The data folder: `option` (--data) if not empty, else $SOAK_DATA, else $XDG_DATA_HOME/soak, else
/// ~/.local/share/soak.
[[nodiscard]] base::Result<std::filesystem::path> data_folder(std::string_view option);

/// Opens the catalog of the data folder, which is created where it is new.
[[nodiscard]] base::Result<db::Catalog> open_catalog(std::string_view data_option);

/// Opens the catalog of a data folder that must be there already: a mistyped folder shall not look like an empty one.
[[nodiscard]] base::Result<db::Catalog> open_existing_catalog(std::string_view data_option);

/// The one run that `text` names: run id, unique beginning of one, or label. Refuses none and several, listing them.
[[nodiscard]] base::Result<db::RunRow> find_run(const db::Catalog& catalog, const db::RunFilter& filter);

}  // namespace soak::station
