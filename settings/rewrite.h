// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"

namespace soak::settings {

/// What a key can be given.
using Value = std::variant<std::string, std::int64_t, double, std::vector<double>>;

/// A key that shall say something else. That it says so already, or is absent already, is no mistake.
struct KeyChange {
  std::string table;           ///< in which it stands; empty = at the top
  std::string key;             ///< not dotted
  std::optional<Value> value;  ///< nothing = the key is taken out, with its line
};

/// A TOML text with these keys changed and everything else, comments included, as it was. A table that is not there is
/// put at the end. What is written reads back as the table of `text` with the changes and nothing else: where no change
/// of lines does that (inline tables, dotted keys), the text is written anew from its table, without comments.
/// Refuses (bad_input, where == `file`) a text that is no TOML, and a `table` that is something else.
[[nodiscard]] base::Result<std::string> rewritten(std::string_view text, const std::string& file,
                                                  const std::vector<KeyChange>& changes);

}  // namespace soak::settings
