// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/io/output.h"

namespace soak::station {

/// soak runs list [--unit SN] [--campaign NAME]
struct RunsListCommand {
  std::string data;
  db::RunFilter filter;
};

/// soak runs show RUN
struct RunsShowCommand {
  std::string data;
  db::RunFilter filter;
};

/// soak runs export RUN [--native] [-o FILE]
struct RunsExportCommand {
  std::string data;
  db::RunFilter filter;
  bool native = false;
  std::string file;  ///< empty = standard output
};

/// soak runs void RUN [--visit N [--position P [--attempt K]]] --reason TEXT
struct RunsVoidCommand {
  std::string data;
  db::RunFilter filter;
  std::optional<std::int32_t> visit;
  std::optional<std::string> position;
  std::optional<std::int32_t> attempt;
  std::string reason;
  std::string user;  ///< empty = who runs the program
};

/// soak runs verify [RUN...]
struct RunsVerifyCommand {
  std::string data;
  std::vector<std::string> runs;  ///< empty = all
};

[[nodiscard]] base::Status run_runs_list(const RunsListCommand& command, Output& output);
[[nodiscard]] base::Status run_runs_show(const RunsShowCommand& command, Output& output);
[[nodiscard]] base::Status run_runs_export(const RunsExportCommand& command, Output& output);
[[nodiscard]] base::Status run_runs_void(const RunsVoidCommand& command, Output& output);
[[nodiscard]] base::Status run_runs_verify(const RunsVerifyCommand& command, Output& output);

}  // namespace soak::station
