// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// The secret key that a station signs calibration files with, in its data folder; a key file of `soak key new`.
[[nodiscard]] std::filesystem::path station_key_file(const std::filesystem::path& data_folder);

/// {"key": {"key_id", "public_key", "comment", "file"} or null}: the public part, `file` the text of a public key file
/// (docs/schema/http-key.schema.json). Refuses (bad_input) a key file that others may read, or that is none.
[[nodiscard]] base::Result<nlohmann::json> station_key(const std::filesystem::path& data_folder);

/// Makes the station's key and enters that into the event log (`key_made`); its document. Refuses (bad_input, where ==
/// "state") where there is one: what was signed with it would not be known any more.
[[nodiscard]] base::Result<nlohmann::json> make_station_key(db::Catalog& catalog, const std::string& comment,
                                                            const std::string& user);

}  // namespace soak::station
