// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::base {

/// Whether the bytes are UTF-8 (RFC 3629): shortest forms, no surrogates, nothing beyond U+10FFFF.
[[nodiscard]] bool is_utf8(std::string_view text);

/// Whether UTF-8 text is one line that reads as it is stored: no control characters (C0, DEL, C1), no line or paragraph
/// separator (U+2028, U+2029), no mark that turns the direction of what stands beside it (U+061C, U+200E, U+200F,
/// U+202A to U+202E, U+2066 to U+2069: Unicode Standard Annex #9). False for what is no UTF-8.
[[nodiscard]] bool is_plain_line(std::string_view text);

}  // namespace soak::base
