// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "db/detail/sqlite.h"

/// The texts of the schemas, one per version, and the way from one version to the next.
namespace soak::db::schema {

/// "SOAK" in ASCII.
inline constexpr std::uint32_t kRunFileApplicationId = 0x534F414B;
inline constexpr std::uint32_t kRunFileVersion = 1;
/// "SOKS" in ASCII.
inline constexpr std::uint32_t kStationApplicationId = 0x534F4B53;
/// "SOKC": catalogs of development versions before the first release, whose schemas had versions of their own.
inline constexpr std::uint32_t kDevelopmentApplicationId = 0x534F4B43;

/// SQL that makes a file of version `to_version` from one of the version before; 0 is the empty file.
struct Step {
  std::uint32_t to_version;
  std::string sql;
  std::function<void(SQLite::Database&)> then{};  ///< what SQL cannot say, after it; throws SQLite::Exception
};

extern const char* const kRunFileSql;
[[nodiscard]] const std::vector<Step>& station_steps();

/// Brings a file forward to the last of `steps` in one transaction; does nothing where it is there already. Sets the
/// application id of a new file. Several processes may call it at once.
[[nodiscard]] base::Status migrate(const sqlite::Connection& connection, std::span<const Step> steps,
                                   std::uint32_t application_id);

/// Refuses (bad_input) a file of another kind, one of a development version and one of a version newer than `newest`.
/// `kind` names what the file should be: "run file".
[[nodiscard]] base::Status check_identity(const sqlite::Identity& identity, std::uint32_t application_id,
                                          std::uint32_t newest, std::string_view kind,
                                          const std::filesystem::path& path);

}  // namespace soak::db::schema
