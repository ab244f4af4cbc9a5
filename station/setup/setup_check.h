// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"
#include "station/config/station_config.h"
#include "station/setup/setup_form.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {

/// A mistake in what was entered.
struct SetupMistake {
  std::string field;    ///< as SetupText::fields; empty = of all of it
  std::string message;  ///< for people
};

/// What is made of a form.
struct SetupCheck {
  std::string toml;
  std::vector<SetupMistake> mistakes;  ///< none: soakd takes the text as its configuration
};

/// The configuration that a form gives, judged by the parser with which soakd reads `file`. Of each field the first
/// mistake.
[[nodiscard]] SetupCheck check_setup(const SetupForm& form, const std::filesystem::path& file);

/// The controller that was entered; `section`: "chamber", "fixture" or "power". Refuses (bad_input) the first mistake,
/// with its field as `where`.
[[nodiscard]] base::Result<hal::DeviceMap> entered_controller(std::string_view section,
                                                              const EnteredController& controller);

/// The slots that were entered. Refuses as entered_controller() does.
[[nodiscard]] base::Result<std::vector<Slot>> entered_slots(const SetupForm& form);

/// Who is to be told of alarms; the secrets are in the form alone, not in the files that are named. Refuses as
/// entered_controller() does.
[[nodiscard]] base::Result<AlarmConfig> entered_alarms(const SetupForm& form);

/// Refuses (bad_input) slots at the port of the chamber, of the fixture or of the power switch, by whichever of its
/// names: what units are told to send is no request of theirs.
[[nodiscard]] base::Status refuse_shared_ports(const SetupForm& form);

/// Writes the configuration to a file that is not there yet, synced, all of it or nothing, after the secrets beside it.
/// Refuses (bad_input, where == "state") to write over one that is, also one that appeared just now.
[[nodiscard]] base::Status write_new_config(const std::filesystem::path& file, std::string_view toml,
                                            const std::vector<SetupSecret>& secrets);

}  // namespace soak::station
