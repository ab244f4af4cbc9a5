// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/vocabulary/reference.h"

/// What is signed: calibration files (docs/blob-format.md, section 0x0040) and waivers (docs/records.md). No
/// cryptography here: that is station/records/signing.h.
namespace soak::calib {

/// First bytes of the SHA-256 of the public key: says which key to try.
using KeyId = std::array<std::uint8_t, 8>;
/// Ed25519, RFC 8032 section 5.1.6.
using Signature = std::array<std::uint8_t, 64>;

/// Precedes the file's bytes in what is signed: nothing else that the key ever signs can be taken for a calibration.
inline constexpr std::string_view kSignaturePrefix = "soak-signature-1";

/// Payload of a signature section.
struct SignatureSection {
  KeyId key_id{};
  Signature signature{};
};

/// The file with a signature section of zeros as its last, minor version 1 at least, size and CRC made right; signature
/// sections that it has are left out. `file` is one that decode() reads. Refuses (bad_input) one that is full.
[[nodiscard]] base::Result<base::Bytes> with_empty_signature(std::span<const std::uint8_t> file, const KeyId& key_id);

/// Prefix and all bytes of the file before its signature. `file` ends with a signature section.
[[nodiscard]] base::Bytes signed_message(std::span<const std::uint8_t> file);

/// Writes the signature into its place and makes the CRC right. `file` ends with a signature section.
void put_signature(base::Bytes& file, const Signature& signature);

/// The signature section; nothing if the last section of the file, which decode() reads, is not one.
[[nodiscard]] std::optional<SignatureSection> signature_of(std::span<const std::uint8_t> file);

/// The text that the signer of a waiver signs (docs/records.md): which entry of the register, why, who, when. Refuses a
/// text with a control character, which could make two waivers of one text.
[[nodiscard]] base::Result<std::string> waiver_text(const Waiver& waiver, const Reference& reference);

}  // namespace soak::calib
