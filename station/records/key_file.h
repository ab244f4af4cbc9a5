// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "station/records/signing.h"

namespace soak::station {

/// Key files are three lines of text (docs/file-formats.md): what it is, the key as 64 hexadecimal digits, a comment.

struct PublicKeyFile {
  PublicKey key{};
  std::string comment;
  std::filesystem::path path;
};

struct SecretKeyFile {
  SecretKey key;
  std::string comment;
};

enum class KeyKind { secret_key, public_key };

/// What the first line of the file says that it is.
[[nodiscard]] base::Result<KeyKind> kind_of_key_file(const std::filesystem::path& path);

/// Refuses a file that is not a public key.
[[nodiscard]] base::Result<PublicKeyFile> read_public_key(const std::filesystem::path& path);

/// Refuses a file that is not a secret key, or that others than its owner may read.
[[nodiscard]] base::Result<SecretKeyFile> read_secret_key(const std::filesystem::path& path);

/// All files *.pub of the folder, by name. Refuses a folder without any, and one with a *.pub that is not a public key.
[[nodiscard]] base::Result<std::vector<PublicKeyFile>> read_trusted_keys(const std::filesystem::path& folder);

/// Writes `path` (mode 0600) and `path`.pub. Refuses a comment of several lines, and where either file is there
/// already: a lost key cannot be had again. On failure neither file is left behind.
[[nodiscard]] base::Status write_new_key(const std::filesystem::path& path, const SecretKey& key,
                                         const std::string& comment);

/// Where write_new_key() puts the public key.
[[nodiscard]] std::filesystem::path public_path_of(const std::filesystem::path& secret_path);

}  // namespace soak::station
