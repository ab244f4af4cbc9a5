// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "station/commands/runs_command.h"
#include "station/data_folder.h"
#include "station/identity.h"

namespace soak::station {
namespace {

bool matches(const calib::SegmentKey& key, const RunsVoidCommand& command) {
  return key.visit == command.visit.value_or(key.visit) && key.position == command.position.value_or(key.position) &&
         key.attempt == command.attempt.value_or(key.attempt);
}

std::string listed(const std::vector<calib::Segment>& segments) {
  std::string text;
  for (const calib::Segment& segment : segments) {
    text += fmt::format("{}{}/{}/{}", text.empty() ? "" : ", ", segment.key.visit, segment.key.position,
                        segment.key.attempt);
  }
  return text.empty() ? "none" : text;
}

base::Status check(const RunsVoidCommand& command) {
  if (command.reason.empty()) return base::bad_input("a void record needs a reason", "--reason");
  if (command.position && !command.visit) return base::bad_input("--position needs --visit", "--position");
  if (command.attempt && !command.position) return base::bad_input("--attempt needs --position", "--attempt");
  return {};
}

}  // namespace

base::Status run_runs_void(const RunsVoidCommand& command, Output& output) {
  if (auto status = check(command); !status) return status;
  auto catalog = open_existing_catalog(command.data);
  if (!catalog) return base::forward_error(catalog);
  const auto run = find_run(*catalog, command.filter);
  if (!run) return base::forward_error(run);
  const auto segments = catalog->segments(run->run_id, run->unit, false);
  if (!segments) return base::forward_error(segments);
  const auto withdrawn =
      std::count_if(segments->begin(), segments->end(), [&](const auto& s) { return matches(s.key, command); });
  if (command.visit && withdrawn == 0) {
    return base::bad_input(
        fmt::format("the run has no such segment that still counts; it has (visit/position/attempt): {}",
                    listed(*segments)),
        run->run_id);
  }
  const std::string user = command.user.empty() ? user_name() : command.user;
  auto status = catalog->add_void(
      {run->run_id, run->unit, command.visit, command.position, command.attempt, command.reason, user, now_utc_s()});
  if (!status) return status;
  output.print(
      fmt::format("run {} ({}): {} of {} segments withdrawn\n", run->label, run->run_id, withdrawn, segments->size()));
  return {};
}

}  // namespace soak::station
