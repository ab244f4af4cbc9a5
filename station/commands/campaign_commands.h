// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// What all campaign commands know: where the daemon is and who asks.
struct StationCommand {
  std::string station;  ///< HOST:PORT; empty = $SOAK_STATION, else 127.0.0.1:8088
  std::string user;     ///< empty = the user that runs the program
};

/// soak campaign start PROCEDURE.toml --name NAME [--unit SLOT=SERIAL]...
struct CampaignStartCommand {
  StationCommand station;
  std::string procedure;  ///< path of the file, read here: the daemon need not see it
  std::string name;
  std::map<std::string, std::string> units;  ///< slot → serial number
};

/// soak campaign abort --reason TEXT
struct CampaignAbortCommand {
  StationCommand station;
  std::string reason;
};

[[nodiscard]] base::Status run_campaign_start(const CampaignStartCommand& command, Output& output);
[[nodiscard]] base::Status run_campaign_status(const StationCommand& command, Output& output);
[[nodiscard]] base::Status run_campaign_pause(const StationCommand& command, Output& output);
[[nodiscard]] base::Status run_campaign_resume(const StationCommand& command, Output& output);
[[nodiscard]] base::Status run_campaign_abort(const CampaignAbortCommand& command, Output& output);
/// Answers the prompt that stands now, and prints its text.
[[nodiscard]] base::Status run_campaign_confirm(const StationCommand& command, Output& output);

/// Follows the campaign to its end: success where it finished, `device` where it failed, `internal` where it was
/// aborted or interrupted, or the user stopped watching (the campaign goes on). A stream that breaks is taken up again.
[[nodiscard]] base::Status run_campaign_watch(const StationCommand& command, Output& output);

}  // namespace soak::station
