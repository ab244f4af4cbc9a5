// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace soak::base {

/// Whether the bytes are UTF-8 (RFC 3629): shortest forms, no surrogates, nothing beyond U+10FFFF.
[[nodiscard]] bool is_utf8(std::string_view text);

}  // namespace soak::base
