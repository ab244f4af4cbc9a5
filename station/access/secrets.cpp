// SPDX-License-Identifier: Apache-2.0
#include "station/access/secrets.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/hash.h"

namespace soak::station {
namespace {

constexpr auto kPasses = crypto_pwhash_OPSLIMIT_INTERACTIVE;
constexpr auto kMemory = crypto_pwhash_MEMLIMIT_INTERACTIVE;

bool has_random_numbers() {
  static const bool initialised = sodium_init() >= 0;
  return initialised;
}

base::Error no_random_numbers() {
  return {base::ErrorKind::internal, "the system provides no random numbers for a secret", "libsodium"};
}

}  // namespace

base::Result<std::string> new_secret() {
  if (!has_random_numbers()) return tl::unexpected(no_random_numbers());
  std::array<std::uint8_t, 32> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return base::to_hex(bytes);
}

std::string kept_of_secret(std::string_view secret) {
  base::Sha256 hash;
  hash.update(secret);
  return base::to_hex(hash.finish());
}

base::Status check_password(std::string_view password) {
  if (password.size() < kShortestPassword || password.size() > kLongestPassword) {
    return base::bad_input(
        fmt::format("a password has {} to {} bytes, this one {}", kShortestPassword, kLongestPassword, password.size()),
        "password");
  }
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (std::ranges::any_of(password, is_control)) {
    return base::bad_input("a password has no control characters", "password");
  }
  return {};
}

base::Result<std::string> kept_of_password(const std::string& password) {
  if (!has_random_numbers()) return tl::unexpected(no_random_numbers());
  std::array<char, crypto_pwhash_STRBYTES> kept{};
  if (crypto_pwhash_str(kept.data(), password.data(), password.size(), kPasses, kMemory) != 0) {
    return base::fail(base::ErrorKind::internal, "there is no memory (64 MiB) to hash a password", "libsodium");
  }
  return std::string(kept.data());
}

bool is_password(const std::string& kept, const std::string& password) {
  if (kept.empty()) {
    static_cast<void>(kept_of_password(password));
    return false;
  }
  return has_random_numbers() && crypto_pwhash_str_verify(kept.c_str(), password.data(), password.size()) == 0;
}

}  // namespace soak::station
