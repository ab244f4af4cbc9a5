// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"

namespace soak::settings {

/// A table of a TOML text, as far as somebody knows of it.
struct Section {
  std::string table;                                      ///< "chamber", "alarms.mail"; of [[slot]] "slot"
  std::optional<std::size_t> index;                       ///< of [[slot]]: which of them, from 0 on
  std::vector<std::pair<std::string, std::string>> keys;  ///< with what stands behind "=", one line
};

/// The line that begins it: "[chamber]", "[[slot]]".
[[nodiscard]] std::string header_of(const Section& section);

/// The keys that the text has in a table and the section has not. Nothing of a text that is no TOML.
[[nodiscard]] std::vector<std::string> keys_beyond(std::string_view text, const Section& section);

/// A TOML text with what differs between two lists of sections changed in it, and everything else, comments and keys
/// that no section has included, as it was, to the byte. `before`: what the text says; a key of it that the text leaves
/// out, since it goes without saying, is put in where it changes. A section that is in `after` alone is put behind the
/// last one of its name, else at the end; one that is in `before` alone is taken out, but for keys that `before` does
/// not have. Sections of one name come and go at their end. What is returned reads back as the table of `text` with the
/// changes and nothing else. Refuses (bad_input, where == `file`) a text that is no TOML, and one that is written so
/// that no change of lines does that (inline tables, dotted keys).
[[nodiscard]] base::Result<std::string> with_sections(std::string_view text, const std::string& file,
                                                      const std::vector<Section>& before,
                                                      const std::vector<Section>& after);

}  // namespace soak::settings
