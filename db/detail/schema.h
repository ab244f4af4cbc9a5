// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "base/result.h"
#include "db/detail/connection.h"

/// The texts of the schemas, one per version, and the way from one version to the next.
namespace soak::db::schema {

/// "SOAK" in ASCII.
inline constexpr std::uint32_t kRunFileApplicationId = 0x534F414B;
inline constexpr std::uint32_t kRunFileVersion = 1;
/// "SOKC" in ASCII.
inline constexpr std::uint32_t kStationApplicationId = 0x534F4B43;

/// SQL that makes a file of version `to_version` from one of the version before; 0 is the empty file.
struct Step {
  std::uint32_t to_version;
  const char* sql;
};

extern const char* const kRunFileSql;
[[nodiscard]] std::span<const Step> station_steps();

/// Brings a file forward to the last of `steps` in one transaction; does nothing where it is there already. Sets the
/// application id of a new file. Several processes may call it at once.
[[nodiscard]] base::Status migrate(const sqlite::Connection& connection, std::span<const Step> steps,
                                   std::uint32_t application_id);

/// Refuses what `steps` cannot bring forward: a file of another kind or of a version newer than `newest` (bad_input).
/// `kind` names what the file should be: "run file".
[[nodiscard]] base::Status check_identity(const sqlite::Identity& identity, std::uint32_t application_id,
                                          std::uint32_t newest, std::string_view kind,
                                          const std::filesystem::path& path);

}  // namespace soak::db::schema
