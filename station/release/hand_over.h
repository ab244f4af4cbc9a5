// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// What is to be handed over.
struct HandOverRequest {
  std::filesystem::path folder;  ///< new, or empty
  std::string format;            ///< of the files: one of export_formats() but kalibr
  std::string key_file;          ///< secret key that signs manifest and calibration files
  bool simulated = false;        ///< models of simulated data, too
  std::string archive = {};      ///< tar file that all of the folder is packed into, beside it; empty = none
};

/// A unit that is not handed over.
struct LeftOut {
  std::string unit;
  std::int32_t model = 0;
  std::vector<std::string> reasons;
  bool is_held_back = false;  ///< it keeps the rule, and is of simulated data, which the request does not accept
};

struct HandOver {
  nlohmann::json manifest;  ///< docs/schema/manifest.schema.json
  std::vector<LeftOut> left_out;
};

/// Writes the newest released model of every unit that keeps the rule of release (release_rule.h) now into a folder
/// with a signed manifest, and enters each file into the catalog. Refuses (bad_input) a folder that holds something, a
/// key that is none, and where no unit would be handed over, naming the reasons. After a failure nothing of it is left
/// in the folder.
[[nodiscard]] base::Result<HandOver> hand_over(db::Catalog& catalog, const HandOverRequest& request);

}  // namespace soak::station
