// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Changes of the bytes of a TOML text, for those who leave everything else in it as it is.
namespace soak::settings {

/// Bytes from `begin` to `end` that are replaced.
struct Edit {
  std::size_t begin;
  std::size_t end;
  std::string text;
};

/// Behind the line end of the line that `at` lies in.
[[nodiscard]] std::size_t end_of_line(std::string_view text, std::size_t at);
[[nodiscard]] std::size_t begin_of_line(std::string_view text, std::size_t at);

/// Where in the bytes a place is that counts lines and code points, from 1 on.
[[nodiscard]] std::size_t offset_of(std::string_view text, const toml::source_position& place);

/// The text with the edits in it. Those that overlap an earlier one are left out: reads_as() finds that.
[[nodiscard]] std::string edited(std::string_view text, std::vector<Edit> edits);

/// Whether a text is TOML of that table.
[[nodiscard]] bool reads_as(const std::string& text, const toml::table& wanted);

}  // namespace soak::settings
