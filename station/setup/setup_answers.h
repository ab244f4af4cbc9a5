// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/setup/setup_check.h"
#include "station/setup/setup_form.h"

namespace soak::station {

/// What somebody would have entered to get this configuration: setup_text() of it says what `text` says, as far as the
/// form asks for it. Of secrets the files alone, but for an address that stands in the text itself. Refuses (bad_input)
/// what parse_station_config() refuses, and a station that the form cannot show wholly: slots of several types or
/// protocols, a unit at a USB adapter that is found by its numbers.
[[nodiscard]] base::Result<SetupForm> answers_in(std::string_view text, const std::filesystem::path& file);

/// Secrets that were not entered anew are those of before: the password of a mail account while its server and its user
/// are the same, the address of a webhook, and while that is, its token. They are read from their files (paths relative
/// to `folder`), and keep their names; what was entered gets a name that `before` does not have. Mistakes: of files
/// that cannot be read.
[[nodiscard]] std::vector<SetupMistake> keep_secrets(SetupForm& form, const SetupForm& before,
                                                     const std::filesystem::path& folder);

}  // namespace soak::station
