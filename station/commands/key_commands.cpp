// SPDX-License-Identifier: Apache-2.0
#include "station/commands/key_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "station/commands/waiver_note.h"
#include "station/io/text_file.h"
#include "station/records/calibration_reader.h"
#include "station/records/key_file.h"

namespace soak::station {
namespace {

std::string id_text(const PublicKey& key) { return base::to_hex(key_id_of(key)); }

nlohmann::json key_document(std::string_view kind, const PublicKey& key, const std::string& comment) {
  return {{"kind", kind}, {"key_id", id_text(key)}, {"public_key", base::to_hex(key)}, {"comment", comment}};
}

std::string with_comment(const std::string& comment) { return comment.empty() ? "" : fmt::format(" ({})", comment); }

base::Status print_key(std::string_view kind, const PublicKey& key, const std::string& comment, Output& output) {
  if (output.json()) return output.print_json(key_document(kind, key, comment));
  output.print(
      fmt::format("{} key {}{}\npublic key {}\n", kind, id_text(key), with_comment(comment), base::to_hex(key)));
  return {};
}

base::Result<std::vector<PublicKeyFile>> keys_of(const KeyVerifyCommand& command) {
  if (command.key.empty()) return read_trusted_keys(command.trusted);
  auto key = read_public_key(command.key);
  if (!key) return base::forward_error(key);
  return std::vector<PublicKeyFile>{*std::move(key)};
}

/// Why none of the keys is the one that signed the file.
base::Error refusal(const base::Bytes& file, const std::vector<PublicKeyFile>& keys, const std::string& where) {
  const auto section = calib::signature_of(file);
  if (!section)
    return {base::ErrorKind::corrupt, "the calibration file is not signed; 'soak key sign' signs it", where};
  const auto has_id = [&](const PublicKeyFile& key) { return key_id_of(key.key) == section->key_id; };
  const std::string id = base::to_hex(section->key_id);
  if (std::any_of(keys.begin(), keys.end(), has_id)) {
    return {base::ErrorKind::corrupt,
            fmt::format("the signature by key {} does not fit: the file was changed after it was signed, do not use it",
                        id),
            where};
  }
  return {base::ErrorKind::corrupt,
          fmt::format("the file says that key {} signed it, which is {}", id,
                      keys.size() == 1 ? "not " + id_text(keys.front().key)
                                       : fmt::format("none of the {} trusted keys", keys.size())),
          where};
}

}  // namespace

base::Status run_key_new(const KeyNewCommand& command, Output& output) {
  const auto key = new_secret_key();
  if (!key) return base::forward_error(key);
  if (auto status = write_new_key(command.file, *key, command.comment); !status) return status;
  const PublicKey public_key = public_key_of(*key);
  const std::filesystem::path path = std::filesystem::absolute(command.file);
  if (output.json()) {
    nlohmann::json document = key_document("secret", public_key, command.comment);
    document["secret_key_file"] = path.string();
    document["public_key_file"] = public_path_of(path).string();
    return output.print_json(document);
  }
  output.print(fmt::format("{}: secret key {}, keep it to yourself\n{}: public key, for those who verify\n",
                           command.file, id_text(public_key), public_path_of(command.file).string()));
  return {};
}

base::Status run_key_show(const KeyShowCommand& command, Output& output) {
  const auto kind = kind_of_key_file(command.file);
  if (!kind) return base::forward_error(kind);
  if (*kind == KeyKind::public_key) {
    const auto file = read_public_key(command.file);
    if (!file) return base::forward_error(file);
    return print_key("public", file->key, file->comment, output);
  }
  const auto file = read_secret_key(command.file);
  if (!file) return base::forward_error(file);
  return print_key("secret", public_key_of(file->key), file->comment, output);
}

base::Status run_key_sign(const KeySignCommand& command, Output& output) {
  const auto key = read_secret_key(command.key);
  if (!key) return base::forward_error(key);
  const auto loaded = read_calibration(command.file);
  if (!loaded) return base::forward_error(loaded);
  const auto bytes = signed_file(loaded->bytes, key->key);
  if (!bytes) return base::fail(bytes.error().kind, bytes.error().message, command.file);
  const std::string_view content(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (auto written = write_text_file(command.file, content); !written) return written;

  const std::string id = id_text(public_key_of(key->key));
  const bool replaced = calib::signature_of(loaded->bytes).has_value();
  if (output.json()) {
    return output.print_json({{"file", std::filesystem::absolute(command.file).string()},
                              {"unit", loaded->calibration.unit},
                              {"model", loaded->calibration.model_version},
                              {"key_id", id},
                              {"replaced", replaced},
                              {"bytes", bytes->size()},
                              {"sha256", base::to_hex(base::sha256(*bytes))}});
  }
  output.print(fmt::format("{}: unit {}, model {}, signed with key {}{}{}\n", command.file, loaded->calibration.unit,
                           loaded->calibration.model_version, id, with_comment(key->comment),
                           replaced ? ", in place of the signature that it had" : ""));
  return {};
}

base::Status run_key_verify(const KeyVerifyCommand& command, Output& output) {
  const auto keys = keys_of(command);
  if (!keys) return base::forward_error(keys);
  const auto loaded = read_calibration(command.file);
  if (!loaded) return base::forward_error(loaded);
  const auto key = std::find_if(keys->begin(), keys->end(), [&](const PublicKeyFile& candidate) {
    return is_file_signed_by(candidate.key, loaded->bytes);
  });
  if (key == keys->end()) return tl::unexpected<base::Error>(refusal(loaded->bytes, *keys, command.file));

  note_waivers(loaded->calibration.references, output);
  if (output.json()) {
    return output.print_json({{"file", std::filesystem::absolute(command.file).string()},
                              {"unit", loaded->calibration.unit},
                              {"model", loaded->calibration.model_version},
                              {"simulated", loaded->calibration.simulated},
                              {"key_id", id_text(key->key)},
                              {"key_file", std::filesystem::absolute(key->path).string()},
                              {"comment", key->comment}});
  }
  output.print(fmt::format("{}: good; unit {}, model {}{}, signed with key {}{}\n", command.file,
                           loaded->calibration.unit, loaded->calibration.model_version,
                           loaded->calibration.simulated ? " (SIMULATED)" : "", id_text(key->key),
                           with_comment(key->comment)));
  return {};
}

}  // namespace soak::station
