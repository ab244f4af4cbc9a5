// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/setup/setup_check.h"
#include "station/setup/setup_form.h"
#include "station/setup/setup_secrets.h"

namespace soak::station {

/// A configuration with other answers in it.
struct SettingsDraft {
  std::string toml;         ///< of the file; as before where there is nothing to change
  std::string differences;  ///< lines that go ("- port = 502") and come ("+ port = 503"), under their sections
  std::string summary;      ///< one line for the event log: which lines differ, but not what they say
  std::vector<SetupMistake> mistakes;    ///< none: soakd takes the text as its configuration
  std::vector<SetupSecret> new_secrets;  ///< that the text names and `before` did not
};

/// What becomes of the text of `file`, whose answers are `before`, with those of `form` (after keep_secrets()). Lines
/// of which nothing is asked stay as they are. No secret is in `differences`.
[[nodiscard]] SettingsDraft draft_settings(std::string_view text, const std::filesystem::path& file,
                                           const SetupForm& before, const SetupForm& form);

/// SHA-256 of the text, hexadecimal: whoever changes it says which one it was.
[[nodiscard]] std::string revision_of(std::string_view text);

/// Where the file of before is kept: "station.toml.before".
[[nodiscard]] std::filesystem::path file_before(const std::filesystem::path& file);

/// Keeps the old text beside the file, writes the secrets, and puts the new text in the place of the old one: all of it
/// or nothing, forced to the disk, with the mode that the file has.
[[nodiscard]] base::Status write_settings(const std::filesystem::path& file, std::string_view old_text,
                                          const SettingsDraft& draft);

}  // namespace soak::station
