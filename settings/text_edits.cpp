// SPDX-License-Identifier: Apache-2.0
#include "settings/text_edits.h"

#include <algorithm>
#include <utility>

namespace soak::settings {

std::size_t end_of_line(std::string_view text, std::size_t at) {
  const std::size_t found = text.find('\n', at);
  return found == std::string_view::npos ? text.size() : found + 1;
}

std::size_t begin_of_line(std::string_view text, std::size_t at) {
  const std::size_t found = at == 0 ? std::string_view::npos : text.rfind('\n', at - 1);
  return found == std::string_view::npos ? 0 : found + 1;
}

std::size_t offset_of(std::string_view text, const toml::source_position& place) {
  constexpr unsigned kTopBits = 0xC0;
  constexpr unsigned kContinuation = 0x80;
  std::size_t at = 0;
  for (std::uint32_t line = 1; line < place.line; ++line) at = end_of_line(text, at);
  const auto continues = [](char byte) { return (static_cast<unsigned char>(byte) & kTopBits) == kContinuation; };
  for (std::uint32_t column = 1; column < place.column && at < text.size(); ++column) {
    do ++at;
    while (at < text.size() && continues(text[at]));
  }
  return at;
}

std::string edited(std::string_view text, std::vector<Edit> edits) {
  // What is put in stands before what begins there.
  std::stable_sort(edits.begin(), edits.end(),
                   [](const Edit& a, const Edit& b) { return std::pair(a.begin, a.end) < std::pair(b.begin, b.end); });
  std::string out;
  std::size_t at = 0;
  for (const Edit& edit : edits) {
    if (edit.begin < at) continue;
    out += text.substr(at, edit.begin - at);
    out += edit.text;
    at = edit.end;
  }
  return out += text.substr(at);
}

bool reads_as(const std::string& text, const toml::table& wanted) {
  try {
    return toml::parse(text) == wanted;
  } catch (const toml::parse_error&) {
    return false;
  }
}

}  // namespace soak::settings
