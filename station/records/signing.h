// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/deploy/signature.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/warning.h"

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

/// The waiver with key and signature filled in; what is signed is calib::waiver_text(). Refuses texts of several lines.
[[nodiscard]] base::Result<calib::Waiver> signed_waiver(calib::Waiver waiver, const calib::Reference& reference,
                                                        const SecretKey& key);

/// Refuses (corrupt) a waiver whose signature is not that of its own key over its own text and this entry of the
/// register. Whether that key may sign waivers is for whoever reads the record to judge.
[[nodiscard]] base::Status check_waiver(const calib::Waiver& waiver, const calib::Reference& reference);

/// `waiver_signature` for each waiver of a calibration that check_waiver() would refuse.
[[nodiscard]] std::vector<calib::Warning> waiver_warnings(const std::vector<calib::ReferenceUse>& references);

}  // namespace soak::station
