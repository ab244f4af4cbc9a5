// SPDX-License-Identifier: Apache-2.0
#include "station/release/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "base/bytes.h"
#include "base/hash.h"
#include "base/text.h"
#include "station/io/text.h"
#include "station/io/text_file.h"
#include "station/release/exported_file.h"

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

tl::unexpected<base::Error> malformed(const std::string& what, const std::filesystem::path& manifest) {
  return base::corrupt(
      fmt::format("is signed and malformed ({}): do not use what it lists, and ask who signed it", what),
      manifest.string());
}

/// What is checked of a unit in the list.
struct ListedFile {
  std::string unit;
  std::string file;  ///< plain name in the manifest's folder
  std::string sha256;
  std::optional<double> expires_utc_s;
};

std::optional<std::string> text_in(const nlohmann::json& object, const char* member) {
  const auto found = object.find(member);
  if (found == object.end() || !found->is_string() || found->get_ref<const std::string&>().empty()) return std::nullopt;
  return found->get<std::string>();
}

/// Nothing for an entry that is malformed or whose file is not in the manifest's own folder.
std::optional<ListedFile> listed_file(const nlohmann::json& entry) {
  if (!entry.is_object()) return std::nullopt;
  const auto unit = text_in(entry, "unit");
  const auto file = text_in(entry, "file");
  const auto sha256 = text_in(entry, "sha256");
  if (!unit || !file || !sha256 || plain_file_name(*file) != *file) return std::nullopt;
  ListedFile listed{*unit, *file, *sha256, std::nullopt};
  if (const auto expires = entry.find("expires"); expires == entry.end() || !expires->is_null()) {
    const auto day = text_in(entry, "expires");
    listed.expires_utc_s = day ? parse_iso_date(*day) : std::nullopt;
    if (!listed.expires_utc_s) return std::nullopt;
  }
  return listed;
}

base::Status check_file(const std::filesystem::path& file, const ListedFile& listed) {
  const auto hash = hash_of_file(file);
  if (!hash) return base::forward_error(hash);
  if (*hash == listed.sha256) return {};
  return base::corrupt("is not the file that the manifest lists: it was changed or replaced, do not use it",
                       file.string());
}

bool is_calibration_name(const std::filesystem::path& file) {
  const std::string ending = lower_case(file.extension().string());
  return std::ranges::any_of(export_formats(), [&](std::string_view format) { return ending == ending_of(format); });
}

/// Whoever flashes all files of a folder must not flash one that nobody signed.
base::Status check_no_others(const std::filesystem::path& manifest, const std::set<std::string>& names) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::absolute(manifest).parent_path();
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name == manifest.filename() || names.contains(name) || !is_calibration_name(name)) continue;
    return base::corrupt("lies beside the manifest, which does not list it: do not use it", entry->path().string());
  }
  if (!error) return {};
  return base::fail(base::ErrorKind::internal, "cannot be read: " + error.message(), folder.string());
}

/// What the manifest says, where all files are as listed and no other is there.
base::Result<CheckedManifest> check_files(const std::filesystem::path& manifest, const std::string& text,
                                          const PublicKeyFile& signer, double now_utc_s) {
  const auto document = nlohmann::json::parse(text, nullptr, false);
  if (!document.is_object() || text_in(document, "format") != kFormat) {
    return base::bad_input(fmt::format("is signed and is no manifest of the format '{}': use a newer program", kFormat),
                           manifest.string());
  }
  const auto created = text_in(document, "created_utc");
  const auto units = document.value("units", nlohmann::json());
  if (!created || !units.is_array()) return malformed("it lacks its time or its units", manifest);
  CheckedManifest checked{units.size(), *created, std::nullopt, {}, signer};
  std::optional<double> first_utc_s;
  std::set<std::string> names;
  for (const auto& entry : units) {
    const auto listed = listed_file(entry);
    if (!listed || !names.insert(listed->file).second) {
      return malformed(fmt::format("entry {} of its units", names.size() + 1), manifest);
    }
    if (auto as_listed = check_file(manifest.parent_path() / listed->file, *listed); !as_listed) {
      return base::forward_error(as_listed);
    }
    if (!listed->expires_utc_s) continue;
    first_utc_s = std::min(first_utc_s.value_or(*listed->expires_utc_s), *listed->expires_utc_s);
    if (*listed->expires_utc_s <= now_utc_s) checked.expired.push_back(listed->unit);
  }
  if (first_utc_s) checked.expires = iso_date(*first_utc_s);
  if (auto alone = check_no_others(manifest, names); !alone) return base::forward_error(alone);
  return checked;
}

}  // namespace

std::filesystem::path signature_path_of(const std::filesystem::path& manifest) { return manifest.string() + ".sig"; }

std::string manifest_signature(std::string_view manifest, const SecretKey& key) {
  return fmt::format("{}{}\n", kSignedPrefix, base::to_hex(sign(key, signed_message(manifest))));
}

bool is_manifest(const std::filesystem::path& file) { return file.filename() == kManifestName; }

base::Result<CheckedManifest> check_manifest(const std::filesystem::path& file, const std::vector<PublicKeyFile>& keys,
                                             double now_utc_s) {
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
  return check_files(file, *text, *signer, now_utc_s);
}

}  // namespace soak::station
