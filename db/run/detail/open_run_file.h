// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "base/result.h"
#include "db/detail/connection.h"

namespace soak::db::run {

struct OpenedRunFile {
  sqlite::Connection connection;
  bool sealed = false;
};

/// Opens a run file for reading in the way that leaves it and its folder unchanged.
[[nodiscard]] base::Result<OpenedRunFile> open_run_file(const std::filesystem::path& path);

/// Opens a file that is not sealed and that nobody else has open, for writing; nobody else can open it meanwhile.
/// Nothing where it is sealed.
[[nodiscard]] base::Result<std::optional<sqlite::Connection>> open_abandoned(const std::filesystem::path& path);

}  // namespace soak::db::run
