// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"

namespace soak::station {

/// What `soak campaign start` asks for.
struct StartRequest {
  std::string procedure_text;  ///< the TOML itself: the daemon need not see the caller's files
  std::string procedure_file;  ///< its name, for messages
  std::string campaign;
  std::map<std::string, std::string> units;  ///< slot → serial number; empty = the units that the configuration names
  std::string user;
  std::string queued_by = {};  ///< who put it into the queue; empty = it was never there
};

/// The running station as the HTTP interface sees it. Every call may come from any thread and returns soon; commands
/// are carried out by the engine's thread between two of its steps. Errors: bad_input where the command does not fit
/// the state ("no campaign is running") or is wrong in itself, device where a device refuses.
class StationService {
 public:
  StationService() = default;
  StationService(const StationService&) = delete;
  StationService& operator=(const StationService&) = delete;
  virtual ~StationService() = default;

  /// Checks everything (procedure, ratings, slots, references, devices) and begins; {"campaign", "runs", "steps",
  /// "estimate_s", "notes"}.
  [[nodiscard]] virtual base::Result<nlohmann::json> start(const StartRequest& request) = 0;
  /// Checks everything that can be known before, and lets it begin after those before it, never at once. As start(),
  /// and "before": the number of campaigns before it.
  [[nodiscard]] virtual base::Result<nlohmann::json> queue(const StartRequest& request) = 0;
  /// What that campaign would be and all that is wrong with it, without touching a device: docs/http-api.md. Mistakes
  /// of the request are part of the answer, not errors.
  [[nodiscard]] virtual base::Result<nlohmann::json> check(const StartRequest& request) = 0;
  /// Asks each slot of an idle station which unit it holds, some 7 s at most; switches nothing. Refuses (state) where a
  /// campaign is under way, is being made safe or is about to begin by itself. docs/http-api.md.
  [[nodiscard]] virtual base::Result<nlohmann::json> look(const std::string& user) = 0;
  [[nodiscard]] virtual base::Status unqueue(const std::string& user, const std::string& campaign) = 0;
  /// Begins the first campaign of the queue now. Refuses (state) where it has another name than `campaign`, if that is
  /// given: the queue that the user saw is gone.
  [[nodiscard]] virtual base::Status next(const std::string& user, const std::string& campaign) = 0;
  [[nodiscard]] virtual base::Status pause(const std::string& user) = 0;
  [[nodiscard]] virtual base::Status resume(const std::string& user) = 0;
  [[nodiscard]] virtual base::Status abort(const std::string& user, const std::string& reason) = 0;
  /// Answers the prompt with that number. Refuses another number: the prompt that the user saw is gone.
  [[nodiscard]] virtual base::Status confirm(const std::string& user, std::int64_t prompt) = 0;

  /// Enters something into the event log that is none of the campaign's doing; `user` is empty where the station does
  /// it by itself.
  virtual void note(const std::string& kind, const std::string& subject, const std::string& text,
                    const std::string& user) = 0;

  /// docs/http-api.md: the document of GET /api/v1/status.
  [[nodiscard]] virtual nlohmann::json status() const = 0;
  /// Rises whenever status() has changed.
  [[nodiscard]] virtual std::uint64_t status_version() const = 0;
  /// The plan of the running or last campaign, null if there was none. `around`: the number of a step, then as
  /// plan_around() makes it. Absent = the whole plan.
  [[nodiscard]] virtual base::Result<nlohmann::json> plan(std::optional<std::int64_t> around) const = 0;
  /// Temperatures since `after_s` of the history's own time, thinned to at most a few thousand points.
  [[nodiscard]] virtual nlohmann::json history(double after_s) const = 0;
  /// docs/http-api.md: the document of GET /api/v1/stored.
  [[nodiscard]] virtual base::Result<nlohmann::json> stored() = 0;
  /// docs/http-api.md: the document of GET /api/v1/procedures, of all or of one file.
  [[nodiscard]] virtual nlohmann::json procedures(const std::string& file) const = 0;
  /// docs/http-api.md: the document of GET /api/v1/types.
  [[nodiscard]] virtual nlohmann::json types() const = 0;
  /// Allan deviations of that unit in its present or last run. Refuses (bad_input, where == "unit") a serial number
  /// that no unit of the campaign has.
  [[nodiscard]] virtual base::Result<nlohmann::json> noise(const std::string& unit) const = 0;
  /// Log entries with a number above `after`, at most 500.
  [[nodiscard]] virtual nlohmann::json log(std::int64_t after) const = 0;
};

}  // namespace soak::station
