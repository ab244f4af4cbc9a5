// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// The formats of `soak export`.
[[nodiscard]] std::vector<std::string_view> export_formats();

/// How the name of a file of a format ends: ".soakcal"; empty for a format that there is not.
[[nodiscard]] std::string_view ending_of(std::string_view format);

/// What is to be written of a unit.
struct ExportRequest {
  std::string unit;
  std::string format;                    ///< one of those of `soak export`
  std::optional<int> model;              ///< version; absent = the newest
  bool simulated = false;                ///< the user knows that the model comes from simulated data
  bool unreleased = false;               ///< the user knows that the model may not be released
  std::optional<int> instance;           ///< px4, ardupilot: which of the vehicle's units, from 0; absent = 0
  std::optional<std::int32_t> accel_id;  ///< px4: device ids; absent = left to the user
  std::optional<std::int32_t> gyro_id;
  std::optional<int> table;  ///< blob, c: curves as tables of at most so many points; absent = as fitted
  std::string sign;          ///< blob: secret key file to sign with; empty = unsigned
};

/// The file's content, and what is to be printed about it.
struct ExportedFile {
  std::string content;
  std::optional<std::int32_t> model;  ///< version; absent: made of runs
  bool simulated = false;
  bool unreleased = false;                            ///< the file is marked as of a model that is not released
  nlohmann::json members = nlohmann::json::object();  ///< of the document beyond those of every format
  std::string text;
  std::vector<calib::ReferenceUse> references;  ///< that the model's data were measured with
  std::vector<calib::Warning> warnings;         ///< of its fit, and what of its data was withdrawn afterwards
};

/// SHA-256 of a file's content, as it is recorded.
[[nodiscard]] std::string content_sha256(std::string_view content);

/// The file of a unit's model in any format but kalibr. Refuses (bad_input) an unknown unit or version, a model of
/// another epoch, and one of simulated data or one that is not released where the request does not accept that; a key
/// file that is none; fails as the encoders do.
[[nodiscard]] base::Result<ExportedFile> export_model(const db::Catalog& catalog, const ExportRequest& request);

/// The noise values of the unit's longest rest, for kalibr. Refuses (bad_input) a unit without such a rest, and
/// simulated data where the request does not accept them.
[[nodiscard]] base::Result<ExportedFile> export_noise(const db::Catalog& catalog, const ExportRequest& request);

}  // namespace soak::station
