// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/signature.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "base/hash.h"
#include "base/text.h"
#include "calib/runtime/soak_runtime.h"

namespace soak::calib {
namespace {

constexpr std::uint16_t kSignatureType = 0x0040;
constexpr std::uint8_t kSignatureVersion = 1;
/// First minor version that has the section.
constexpr std::uint16_t kSignatureMinorVersion = 1;
constexpr std::size_t kSectionHead = 8;
constexpr std::size_t kCheck = 4;
constexpr std::size_t kSectionSize = kSectionHead + sizeof(KeyId) + sizeof(Signature);

// Fields of the header.
constexpr std::size_t kMinorVersionAt = 10;
constexpr std::size_t kSizeAt = 12;
constexpr std::size_t kCountAt = 20;

template <class T>
void overwrite(base::Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

struct Sections {
  base::Bytes bytes;  ///< header and all sections but signatures
  std::uint32_t count = 0;
};

Sections without_signatures(std::span<const std::uint8_t> file) {
  const std::size_t end = file.size() - kCheck;
  std::size_t at = soak_u32(file.data() + 16);
  Sections result{{file.begin(), file.begin() + static_cast<std::ptrdiff_t>(at)}, 0};
  while (at < end) {
    const auto section = file.subspan(at, kSectionHead + soak_u32(file.data() + at + 4));
    at += section.size();
    if (soak_u16(section.data()) == kSignatureType) continue;
    result.bytes.insert(result.bytes.end(), section.begin(), section.end());
    ++result.count;
  }
  return result;
}

void append_empty_section(base::Bytes& bytes, const KeyId& key_id) {
  base::ByteWriter section;
  section.write(kSignatureType);
  section.write(kSignatureVersion);
  section.write(std::uint8_t{0});  // ignorable
  section.write(static_cast<std::uint32_t>(sizeof(KeyId) + sizeof(Signature)));
  section.write(key_id);
  section.write(Signature{});
  bytes.insert(bytes.end(), section.bytes().begin(), section.bytes().end());
}

void seal(base::Bytes& file) {
  overwrite(file, file.size() - kCheck, base::crc32c(std::span(file).first(file.size() - kCheck)));
}

/// Offset of the signature in a file that ends with one.
std::size_t signature_at(std::size_t file_size) { return file_size - kCheck - sizeof(Signature); }

}  // namespace

base::Result<base::Bytes> with_empty_signature(std::span<const std::uint8_t> file, const KeyId& key_id) {
  Sections sections = without_signatures(file);
  base::Bytes& bytes = sections.bytes;
  append_empty_section(bytes, key_id);
  bytes.resize(bytes.size() + kCheck);
  if (sections.count == SOAK_MAX_SECTIONS || bytes.size() > SOAK_MAX_FILE) {
    return base::bad_input("the file has no room for a signature: the format allows " +
                           std::to_string(SOAK_MAX_SECTIONS) + " sections and " + std::to_string(SOAK_MAX_FILE) +
                           " bytes");
  }
  const auto minor = static_cast<std::uint16_t>(soak_u16(bytes.data() + kMinorVersionAt));
  overwrite(bytes, kMinorVersionAt, std::max(minor, kSignatureMinorVersion));
  overwrite(bytes, kSizeAt, static_cast<std::uint32_t>(bytes.size()));
  overwrite(bytes, kCountAt, sections.count + 1);
  seal(bytes);
  return std::move(bytes);
}

base::Bytes signed_message(std::span<const std::uint8_t> file) {
  base::Bytes message(kSignaturePrefix.begin(), kSignaturePrefix.end());
  const auto part = file.first(signature_at(file.size()));
  message.insert(message.end(), part.begin(), part.end());
  return message;
}

void put_signature(base::Bytes& file, const Signature& signature) {
  overwrite(file, signature_at(file.size()), signature);
  seal(file);
}

std::optional<SignatureSection> signature_of(std::span<const std::uint8_t> file) {
  const std::size_t end = file.size() - kCheck;
  std::size_t at = soak_u32(file.data() + 16);
  std::size_t last = at;
  while (at < end) {
    last = at;
    at += kSectionHead + soak_u32(file.data() + at + 4);
  }
  const std::uint8_t* head = file.data() + last;
  if (end - last != kSectionSize || soak_u16(head) != kSignatureType || head[2] != kSignatureVersion)
    return std::nullopt;
  SignatureSection section;
  std::memcpy(section.key_id.data(), head + kSectionHead, section.key_id.size());
  std::memcpy(section.signature.data(), head + kSectionHead + section.key_id.size(), section.signature.size());
  return section;
}

base::Result<std::string> waiver_text(const Waiver& waiver, const Reference& reference) {
  const std::string due = base::utc_text(reference.due_utc_s);
  const std::string signed_at = base::utc_text(waiver.utc_s);
  const std::array<std::pair<std::string_view, std::string_view>, 9> lines = {{
      {"waiver", waiver.waiver_id},
      {"reference", reference.record_id},
      {"kind", name_of(reference.kind)},
      {"name", reference.name},
      {"certificate", reference.certificate},
      {"due", due},
      {"reason", waiver.reason},
      {"signer", waiver.signer},
      {"signed", signed_at},
  }};
  std::string text = "soak-waiver-1\n";
  for (const auto& [key, value] : lines) {
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
    if (std::any_of(value.begin(), value.end(), is_control)) {
      return base::bad_input("the text must be one line", std::string(key));
    }
    text.append(key).append(" ").append(value).append("\n");
  }
  return text;
}

}  // namespace soak::calib
