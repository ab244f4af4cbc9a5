// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace soak::station {

/// A station configuration to begin with, commented (packaging/station.toml), with the register maps of this machine.
[[nodiscard]] std::string config_template();

/// Where the configuration of a station is.
struct ConfigPlace {
  std::filesystem::path file;
  bool is_there = false;
  bool is_usual = false;  ///< station.toml in the data folder, where the first start may write it
};

/// `file` (--config) where given, else station.toml in the data folder (`data_option`: --data). A `file` that is still
/// the template as the package brings it says nothing of a station yet: then it is the data folder's, too.
[[nodiscard]] base::Result<ConfigPlace> place_of_config(const std::filesystem::path& file,
                                                        std::string_view data_option);

}  // namespace soak::station
