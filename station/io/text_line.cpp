// SPDX-License-Identifier: Apache-2.0
#include "station/io/text_line.h"

#include <fmt/format.h>

#include <string>

#include "base/utf8.h"

namespace soak::station {

base::Status check_text_line(std::string_view text, std::string_view where) {
  if (text.find_first_not_of(' ') == std::string_view::npos) return base::bad_input("is empty", std::string(where));
  if (base::is_plain_line(text)) return {};
  return base::bad_input(
      "must be one line of plain text: no control characters, line separators or marks that turn its direction",
      std::string(where));
}

base::Status check_carried_line(std::string_view text, std::string_view where) {
  if (auto plain = check_text_line(text, where); !plain) return plain;
  if (text.size() <= kLongestCarried) return {};
  return base::bad_input(
      fmt::format("has {} bytes, and a calibration file carries {} at most", text.size(), kLongestCarried),
      std::string(where));
}

}  // namespace soak::station
