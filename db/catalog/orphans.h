// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"

namespace soak::db {

/// A run file in the data folder that no row of the catalog names: its writer came to an end before it could enter it,
/// or is still at work.
struct OrphanRunFile {
  std::filesystem::path path;
  bool sealed = false;
  std::optional<RunInfo> info;     ///< what the file says of itself; absent where it cannot be read
  std::vector<std::string> units;  ///< serial numbers of its streams, each once
  std::string problem;             ///< why it cannot be read
};

/// The orphans among `*.soakrun` in the folder `runs`, in the order of their names, which is that of time. Other names
/// are passed over: an import that was killed leaves `*.soakrun.tmp`, which may also belong to one at work; nothing
/// removes it.
[[nodiscard]] base::Result<std::vector<OrphanRunFile>> orphan_run_files(const Catalog& catalog);

}  // namespace soak::db
