// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/io/output.h"

namespace soak::station {

/// soak gap find --unit SN [--campaign NAME]
struct GapFindCommand {
  std::string data;
  std::string unit;
  std::optional<std::string> campaign;
};

/// Looks for what the unit's newest model lacks in the runs that a fit takes, less the terms that the model carries,
/// and stores the report in the catalog. Refuses (bad_input) a unit without a model: the gap is that of a model.
[[nodiscard]] base::Status run_gap_find(const GapFindCommand& command, Output& output);

/// soak gap accept --unit SN [--campaign NAME] [--effect NAME]... [--user NAME]
struct GapAcceptCommand {
  std::string data;
  std::string unit;
  std::optional<std::string> campaign;
  std::vector<std::string> effects;  ///< empty = all that are named
  std::string user;                  ///< empty = who runs the program
};

/// Finds the gap as run_gap_find() does, adds the effects that it names to the terms of the unit's model, and fits a
/// new version to readings freed of all of them. Refuses (bad_input) a verdict that names nothing, and an effect that
/// is not named.
[[nodiscard]] base::Status run_gap_accept(const GapAcceptCommand& command, Output& output);

/// soak gap withdraw --unit SN --effect NAME [--user NAME] --reason TEXT
struct GapWithdrawCommand {
  std::string data;
  std::string unit;
  std::string effect;
  std::string reason;
  std::string user;  ///< empty = who runs the program
};

/// Fits a new version of the unit's model without an effect that was accepted. Versions are only added. Refuses
/// (bad_input) an effect that the newest model does not carry.
[[nodiscard]] base::Status run_gap_withdraw(const GapWithdrawCommand& command, Output& output);

/// soak gap show --unit SN [--model V] [--campaign NAME] [-o FILE.html]
struct GapShowCommand {
  std::string data;
  std::string unit;
  std::optional<std::int32_t> model;  ///< absent = the newest
  std::optional<std::string> campaign;
  std::string file;      ///< empty = text only
  std::string software;  ///< name and version of this program, for the page
};

/// Simulates the unit's runs with a model before and after its accepted effects and shows how far each is from what was
/// measured, on runs that the model was fitted to and on fresh ones. Refuses (bad_input) a unit without a model.
[[nodiscard]] base::Status run_gap_show(const GapShowCommand& command, Output& output);

}  // namespace soak::station
