// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// The data folder of the service that the Debian package brings (packaging/systemd/soakd.service).
inline constexpr const char* kServiceFolder = "/var/lib/soak";

/// A station configuration to begin with, commented (packaging/station.toml), with the register maps of this machine.
[[nodiscard]] std::string config_template();

/// Where the configuration of a station is.
struct ConfigPlace {
  std::filesystem::path file;
  bool is_there = false;
  bool is_usual = false;              ///< station.toml in the data folder, where the first start may write it
  std::filesystem::path data;         ///< the data folder where it is the service's that was found; else empty
  std::filesystem::path passed_over;  ///< the --config that is still the template; empty = none
  std::vector<std::filesystem::path> searched;  ///< folders in which a station.toml was looked for
};

/// `file` (--config) where given, else station.toml in the data folder (`data_option`: --data). A `file` that is still
/// the template says nothing of a station yet, whatever its comments and the folder of its maps: then it is the data
/// folder's, too, and where that has none and no --data is given, that of the service's data folder.
[[nodiscard]] base::Result<ConfigPlace> place_of_config(const std::filesystem::path& file, std::string_view data_option,
                                                        const std::filesystem::path& service_folder = kServiceFolder);

/// What to say of a place without a configuration.
[[nodiscard]] base::Error no_config_at(const ConfigPlace& place);

}  // namespace soak::station
