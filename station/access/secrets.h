// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

/// Passwords and random secrets, by libsodium.
namespace soak::station {

/// 256 random bits as 64 hexadecimal digits. Fails (internal) where the system has no random numbers.
[[nodiscard]] base::Result<std::string> new_secret();

/// What is kept of a secret of new_secret(): its SHA-256 in hexadecimal digits. A plain hash does, since nobody can try
/// 2^256 secrets; the same holds for comparing two hashes in a time that depends on them.
[[nodiscard]] std::string kept_of_secret(std::string_view secret);

/// Shortest and longest password, in bytes. NIST SP 800-63B asks for 8 at least, and for no rules on characters.
inline constexpr std::size_t kShortestPassword = 10;
inline constexpr std::size_t kLongestPassword = 200;

/// Refuses (bad_input) a password that is too short or too long, or has control characters.
[[nodiscard]] base::Status check_password(std::string_view password);

/// What is kept of a password: argon2id (RFC 9106) with 64 MiB and two passes, which takes about a tenth of a second,
/// with its salt and settings. Fails (internal) where there is no memory for it.
[[nodiscard]] base::Result<std::string> kept_of_password(const std::string& password);

/// Whether `kept` is of that password. Takes as long as kept_of_password(), also where `kept` is empty: that of an
/// account that does not exist, which nobody shall find out by the time that the answer takes.
[[nodiscard]] bool is_password(const std::string& kept, const std::string& password);

}  // namespace soak::station
