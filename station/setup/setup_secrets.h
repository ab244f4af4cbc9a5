// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/alarms/delivery.h"
#include "station/setup/setup_form.h"

namespace soak::station {

/// Files beside the configuration for what may be read by soakd alone.
inline constexpr const char* kMailPasswordFile = "mail.password";
inline constexpr const char* kWebhookUrlFile = "webhook.url";
inline constexpr const char* kWebhookTokenFile = "webhook.token";

/// A line that is kept out of the configuration.
struct SetupSecret {
  std::string file;  ///< its name
  std::string line;
};

/// Those that were entered.
[[nodiscard]] std::vector<SetupSecret> secrets_of(const SetupForm& form);

/// The same for a message that is sent now.
[[nodiscard]] AlarmSecrets alarm_secrets_of(const SetupForm& form);

/// Writes each to its file in the folder, in place of what is there: readable by its owner alone from the first moment
/// on (mode 0600), synced. No error says what is in one.
[[nodiscard]] base::Status write_secrets(const std::filesystem::path& folder, const std::vector<SetupSecret>& secrets);

}  // namespace soak::station
