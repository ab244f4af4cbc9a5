// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/alarms/delivery.h"
#include "station/setup/setup_form.h"

namespace soak::station {

/// Files beside the configuration for what may be read by soakd alone.
inline constexpr const char* kMailPasswordFile = "mail.password";
inline constexpr const char* kWebhookUrlFile = "webhook.url";
inline constexpr const char* kWebhookTokenFile = "webhook.token";

/// The file that the configuration names for a secret; empty where there is none to be kept.
[[nodiscard]] std::string password_file_of(const EnteredMail& mail);
[[nodiscard]] std::string url_file_of(const EnteredWebhook& webhook);
[[nodiscard]] std::string token_file_of(const EnteredWebhook& webhook);

/// A line that is kept out of the configuration.
struct SetupSecret {
  std::string file;  ///< its name
  std::string line;
};

/// Those that were entered.
[[nodiscard]] std::vector<SetupSecret> secrets_of(const SetupForm& form);

/// The same for a message that is sent now.
[[nodiscard]] AlarmSecrets alarm_secrets_of(const SetupForm& form);

/// Writes a file in place of what is there, synced, all of it or nothing; until it has its mode it is readable by its
/// owner alone. Follows symbolic links. No error says what is in it.
[[nodiscard]] base::Status write_with_mode(const std::filesystem::path& file, std::string_view text,
                                           std::filesystem::perms mode);

/// Writes each to its file in the folder, in place of what is there: readable by its owner alone from the first moment
/// on (mode 0600), synced. No error says what is in one.
[[nodiscard]] base::Status write_secrets(const std::filesystem::path& folder, const std::vector<SetupSecret>& secrets);

}  // namespace soak::station
