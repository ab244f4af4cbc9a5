// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/records/key_file.h"
#include "station/records/signing.h"

/// The list of released files in a folder, and its signature (docs/file-formats.md, Released files).
namespace soak::station {

inline constexpr std::string_view kManifestName = "manifest.json";

/// Where the signature of a manifest stands: beside it.
[[nodiscard]] std::filesystem::path signature_path_of(const std::filesystem::path& manifest);

/// The content of the signature's file.
[[nodiscard]] std::string manifest_signature(std::string_view manifest, const SecretKey& key);

/// A manifest whose signature is good and whose files are those that it lists.
struct CheckedManifest {
  std::size_t files = 0;
  std::string created_utc;             ///< as it stands there
  std::optional<std::string> expires;  ///< day on which the first of its units expires; none: none does
  std::vector<std::string> expired;    ///< serial numbers of units past that day
  PublicKeyFile signer;
};

/// Whether a file is meant as a manifest, by its name.
[[nodiscard]] bool is_manifest(const std::filesystem::path& file);

/// Checks the signature by one of the keys, then every file that the manifest lists against its hash, and that no other
/// calibration file, by the ending of its name, lies beside it. Fails (corrupt) where the signature is missing or not
/// by one of the keys, where a file is missing, another one or not listed, and where a signed list is malformed;
/// (bad_input) where there is no such manifest, or one of another format. `now_utc_s`: what has expired.
[[nodiscard]] base::Result<CheckedManifest> check_manifest(const std::filesystem::path& file,
                                                           const std::vector<PublicKeyFile>& keys, double now_utc_s);

}  // namespace soak::station
