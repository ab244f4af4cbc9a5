// SPDX-License-Identifier: Apache-2.0
#include "station/release/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/bytes.h"
#include "base/hash.h"
#include "base/text.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

constexpr std::string_view kFormat = "soak-manifest-1";
/// Precedes the manifest in what is signed, as calib::kSignaturePrefix does a calibration file.
constexpr std::string_view kSignedPrefix = "soak-manifest-signature-1\n";

base::Bytes signed_message(std::string_view manifest) {
  const std::string message = fmt::format("{}{}", kSignedPrefix, manifest);
  return {message.begin(), message.end()};
}

/// The signature in its file: first line what it is, second line 128 hexadecimal digits.
std::optional<calib::Signature> signature_in(const std::string& text) {
  if (!text.starts_with(kSignedPrefix)) return std::nullopt;
  const std::size_t digits = 2 * calib::Signature().size();
  if (text.size() != kSignedPrefix.size() + digits + 1 || text.back() != '\n') return std::nullopt;
  return base::bytes_of_hex<64>(std::string_view(text).substr(kSignedPrefix.size(), digits));
}

base::Result<std::string> hash_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return base::corrupt("the manifest lists this file, and it cannot be read: get the whole folder again",
                         path.string());
  const base::Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return base::to_hex(base::sha256(bytes));
}

/// The number of files, all of which are as listed.
base::Result<std::size_t> check_files(const std::filesystem::path& manifest, const std::string& text) {
  const auto document = nlohmann::json::parse(text, nullptr, false);
  if (!document.is_object() || document.value("format", "") != kFormat || !document["units"].is_array()) {
    return base::bad_input(fmt::format("is signed and is no manifest of the format '{}': use a newer program", kFormat),
                           manifest.string());
  }
  for (const auto& unit : document["units"]) {
    const std::filesystem::path file = manifest.parent_path() / unit.value("file", "");
    const auto hash = hash_of_file(file);
    if (!hash) return base::forward_error(hash);
    if (*hash == unit.value("sha256", "")) continue;
    return base::corrupt("is not the file that the manifest lists: it was changed or replaced, do not use it",
                         file.string());
  }
  return document["units"].size();
}

}  // namespace

std::filesystem::path signature_path_of(const std::filesystem::path& manifest) { return manifest.string() + ".sig"; }

std::string manifest_signature(std::string_view manifest, const SecretKey& key) {
  return fmt::format("{}{}\n", kSignedPrefix, base::to_hex(sign(key, signed_message(manifest))));
}

bool is_manifest(const std::filesystem::path& file) { return file.filename() == kManifestName; }

base::Result<CheckedManifest> check_manifest(const std::filesystem::path& file,
                                             const std::vector<PublicKeyFile>& keys) {
  const auto text = read_text_file(file);
  if (!text) return base::forward_error(text);
  const auto signature_text = read_text_file(signature_path_of(file));
  const auto signature = signature_text ? signature_in(*signature_text) : std::nullopt;
  if (!signature) {
    return base::corrupt("there is no signature of this manifest beside it: get the whole folder again",
                         signature_path_of(file).string());
  }
  const base::Bytes message = signed_message(*text);
  const auto signer =
      std::ranges::find_if(keys, [&](const PublicKeyFile& key) { return is_signed_by(key.key, message, *signature); });
  if (signer == keys.end()) {
    return base::corrupt(
        "the signature is by none of the given keys, or the manifest was changed after it was signed: "
        "do not use what it lists",
        file.string());
  }
  const auto files = check_files(file, *text);
  if (!files) return base::forward_error(files);
  return CheckedManifest{*files, *signer};
}

}  // namespace soak::station
