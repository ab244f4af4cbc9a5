// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace soak::base {

/// UUID version 7 (RFC 9562 §5.7) as text: `unix_ms` in the upper 48 bits, the rest from two random words. Sorts by
/// time of creation. The clock and the randomness are the caller's: this function is pure.
[[nodiscard]] std::string uuid_v7(std::uint64_t unix_ms, std::uint64_t random_a, std::uint64_t random_b);

/// True for the 8-4-4-4-12 lower-case hexadecimal form.
[[nodiscard]] bool is_uuid(std::string_view text);

}  // namespace soak::base
