// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/deploy/signature.h"

namespace soak::station {

/// Ed25519 (RFC 8032) by libsodium; nothing else in the project knows that library.

using PublicKey = std::array<std::uint8_t, 32>;

/// The 32 bytes that RFC 8032 calls the private key. Overwritten when it goes out of scope; cannot be copied.
class SecretKey {
 public:
  using Seed = std::array<std::uint8_t, 32>;

  explicit SecretKey(const Seed& seed) : seed_(seed) {}
  SecretKey(SecretKey&& other) noexcept;
  SecretKey& operator=(SecretKey&&) = delete;
  SecretKey(const SecretKey&) = delete;
  SecretKey& operator=(const SecretKey&) = delete;
  ~SecretKey();

  [[nodiscard]] const Seed& seed() const { return seed_; }

 private:
  Seed seed_;
};

/// A new key from the system's source of randomness. Fails (internal) where there is none.
[[nodiscard]] base::Result<SecretKey> new_secret_key();

[[nodiscard]] PublicKey public_key_of(const SecretKey& key);

/// What a signature section and `soak key show` call the key.
[[nodiscard]] calib::KeyId key_id_of(const PublicKey& key);

/// Deterministic: the same key and message give the same signature.
[[nodiscard]] calib::Signature sign(const SecretKey& key, std::span<const std::uint8_t> message);

[[nodiscard]] bool is_signed_by(const PublicKey& key, std::span<const std::uint8_t> message,
                                const calib::Signature& signature);

/// Overwrites what the memory holds, in a way that the compiler does not leave out.
void wipe(std::span<std::uint8_t> memory);
void wipe(std::string& text);

/// The calibration file `file`, which decode() reads, signed; a signature that it has is replaced. Refuses (bad_input)
/// one that has no room for a signature.
[[nodiscard]] base::Result<base::Bytes> signed_file(std::span<const std::uint8_t> file, const SecretKey& key);

/// Whether the last section of the calibration file is a signature of all before it by this key. `file` is one that
/// decode() reads.
[[nodiscard]] bool is_file_signed_by(const PublicKey& key, std::span<const std::uint8_t> file);

}  // namespace soak::station
