// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "station/commands/command.h"
#include "station/commands/shared.h"
#include "station/io/host.h"
#include "station/io/text_file.h"
#include "station/records/calibration_reader.h"
#include "station/records/key_file.h"
#include "station/release/manifest.h"

namespace soak::station {
namespace {

/// soak key new -o FILE [--comment TEXT]
struct KeyNew final : Command {
  std::string file;
  std::string comment;

  void declare(OptionList& options) override {
    options.add("-o,--output FILE", &file, "File for the secret key; the public key is written to FILE.pub").required();
    options.add("--comment TEXT", &comment, "Owner of the key; written to both files");
  }
  base::Status run(Output& output) override;
};

/// soak key show FILE
struct KeyShow final : Command {
  std::string file;

  void declare(OptionList& options) override { options.add("file FILE", &file, "Secret or public key").required(); }
  base::Status run(Output& output) override;
};

/// soak key sign FILE.soakcal --key FILE: signs in place, atomically; replaces a signature.
struct KeySign final : Command {
  std::string file;
  std::string key;

  void declare(OptionList& options) override {
    options.add("file FILE.soakcal", &file, "Calibration file").required();
    options.add("--key FILE", &key, "Secret key").required();
  }
  base::Status run(Output& output) override;
};

/// soak key verify FILE.soakcal|manifest.json --key FILE.pub | --trusted DIR: fails (corrupt) for a file that is
/// damaged, not signed, or not signed by one of the keys, and for a manifest that lists such a file.
struct KeyVerify final : Command {
  std::string file;
  std::string key;      ///< empty: `trusted` is given
  std::string trusted;  ///< folder of public keys

  void declare(OptionList& options) override {
    options.add("file FILE.soakcal", &file, "Calibration file, or manifest.json of released files").required();
    options.add("--key FILE.pub", &key, "Public key");
    options.add("--trusted DIR", &trusted, "Folder of public keys (*.pub); a signature by any of them is accepted")
        .excludes("--key");
    options.require_one_of({"--key", "--trusted"}, "--key FILE.pub or --trusted DIR");
  }
  base::Status run(Output& output) override;
};

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

base::Result<std::vector<PublicKeyFile>> keys_of(const KeyVerify& command) {
  if (command.key.empty()) return read_trusted_keys(command.trusted);
  auto key = read_public_key(command.key);
  if (!key) return base::forward_error(key);
  return std::vector<PublicKeyFile>{*std::move(key)};
}

/// Why the file is not accepted as signed by one of the keys.
base::Error signature_error(const base::Bytes& file, const std::vector<PublicKeyFile>& keys, const std::string& where) {
  const auto section = calib::signature_of(file);
  if (!section)
    return {base::ErrorKind::corrupt, "the calibration file is not signed: 'soak key sign' signs it", where};
  const auto has_id = [&](const PublicKeyFile& key) { return key_id_of(key.key) == section->key_id; };
  const std::string id = base::to_hex(section->key_id);
  if (std::any_of(keys.begin(), keys.end(), has_id)) {
    return {base::ErrorKind::corrupt,
            fmt::format(
                "the signature by key {} does not match: the file was changed after it was signed, do not use it", id),
            where};
  }
  return {base::ErrorKind::corrupt,
          fmt::format("the file is signed with key {}, which is {}", id,
                      keys.size() == 1 ? "not " + id_text(keys.front().key)
                                       : fmt::format("none of the {} trusted keys", keys.size())),
          where};
}

base::Status KeyNew::run(Output& output) {
  const auto secret_key = new_secret_key();
  if (!secret_key) return base::forward_error(secret_key);
  if (auto status = write_new_key(file, *secret_key, comment); !status) return status;
  const PublicKey public_key = public_key_of(*secret_key);
  const std::filesystem::path path = std::filesystem::absolute(file);
  if (output.json()) {
    nlohmann::json document = key_document("secret", public_key, comment);
    document["secret_key_file"] = path.string();
    document["public_key_file"] = public_path_of(path).string();
    return output.print_json(document);
  }
  output.print(fmt::format("{}: secret key {}, keep it secret\n{}: public key, give it to those who verify\n", file,
                           id_text(public_key), public_path_of(file).string()));
  return {};
}

base::Status KeyShow::run(Output& output) {
  const auto kind = kind_of_key_file(file);
  if (!kind) return base::forward_error(kind);
  if (*kind == KeyKind::public_key) {
    const auto key = read_public_key(file);
    if (!key) return base::forward_error(key);
    return print_key("public", key->key, key->comment, output);
  }
  const auto key = read_secret_key(file);
  if (!key) return base::forward_error(key);
  return print_key("secret", public_key_of(key->key), key->comment, output);
}

base::Status KeySign::run(Output& output) {
  const auto secret_key = read_secret_key(key);
  if (!secret_key) return base::forward_error(secret_key);
  const auto loaded = read_calibration(file);
  if (!loaded) return base::forward_error(loaded);
  const auto bytes = signed_file(loaded->bytes, secret_key->key);
  if (!bytes) return base::fail(bytes.error().kind, bytes.error().message, file);
  const std::string_view content(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (auto written = write_text_file(file, content); !written) return written;

  const std::string id = id_text(public_key_of(secret_key->key));
  const bool replaced = calib::signature_of(loaded->bytes).has_value();
  if (output.json()) {
    return output.print_json({{"file", std::filesystem::absolute(file).string()},
                              {"unit", loaded->calibration.unit},
                              {"model", loaded->calibration.model_version},
                              {"key_id", id},
                              {"replaced", replaced},
                              {"bytes", bytes->size()},
                              {"sha256", base::to_hex(base::sha256(*bytes))}});
  }
  output.print(fmt::format("{}: unit {}, model {}, signed with key {}{}{}\n", file, loaded->calibration.unit,
                           loaded->calibration.model_version, id, with_comment(secret_key->comment),
                           replaced ? ", replacing its previous signature" : ""));
  return {};
}

nlohmann::json manifest_document(const std::string& file, const CheckedManifest& checked) {
  return {{"file", std::filesystem::absolute(file).string()},
          {"files", checked.files},
          {"created_utc", checked.created_utc},
          {"expires", checked.expires ? nlohmann::json(*checked.expires) : nlohmann::json()},
          {"expired", checked.expired},
          {"key_id", id_text(checked.signer.key)},
          {"key_file", std::filesystem::absolute(checked.signer.path).string()},
          {"comment", checked.signer.comment}};
}

/// What has expired is told after the document: files and signature are good all the same.
base::Status verify_manifest(const std::string& file, const std::vector<PublicKeyFile>& keys, Output& output) {
  const auto checked = check_manifest(file, keys, now_utc_s());
  if (!checked) return base::forward_error(checked);
  if (output.json()) {
    if (auto printed = output.print_json(manifest_document(file, *checked)); !printed) return printed;
  } else {
    output.print(fmt::format(
        "{}: signature is good and all {} files are those that it lists; made {}, {}, signed with key {}{}\n", file,
        checked->files, checked->created_utc,
        checked->expires ? "good until " + *checked->expires : std::string("expires never"),
        id_text(checked->signer.key), with_comment(checked->signer.comment)));
  }
  if (checked->expired.empty()) return {};
  return base::fail(base::ErrorKind::limits,
                    fmt::format("{} of {} units have expired: {}: calibrate them again", checked->expired.size(),
                                checked->files, fmt::join(checked->expired, ", ")),
                    file);
}

base::Status KeyVerify::run(Output& output) {
  const auto keys = keys_of(*this);
  if (!keys) return base::forward_error(keys);
  if (is_manifest(file)) return verify_manifest(file, *keys, output);
  const auto loaded = read_calibration(file);
  if (!loaded) return base::forward_error(loaded);
  const auto signer = std::find_if(keys->begin(), keys->end(), [&](const PublicKeyFile& candidate) {
    return is_file_signed_by(candidate.key, loaded->bytes);
  });
  if (signer == keys->end()) return tl::unexpected<base::Error>(signature_error(loaded->bytes, *keys, file));

  note_waivers(loaded->calibration.references, output);
  if (output.json()) {
    return output.print_json({{"file", std::filesystem::absolute(file).string()},
                              {"unit", loaded->calibration.unit},
                              {"model", loaded->calibration.model_version},
                              {"simulated", loaded->calibration.simulated},
                              {"unreleased", loaded->calibration.unreleased},
                              {"key_id", id_text(signer->key)},
                              {"key_file", std::filesystem::absolute(signer->path).string()},
                              {"comment", signer->comment}});
  }
  output.print(fmt::format("{}: signature is good; unit {}, model {}{}, signed with key {}{}\n", file,
                           loaded->calibration.unit, loaded->calibration.model_version, marks_text(loaded->calibration),
                           id_text(signer->key), with_comment(signer->comment)));
  return {};
}

}  // namespace

CommandGroup key_commands() {
  return {"key",
          "Keys and signatures of calibration files",
          {{"new", "Make a key to sign calibration files with",
            "soak key new -o lab.key --comment 'Laboratory 1, 2027'", std::make_shared<KeyNew>()},
           {"show", "Show a key's id, public key and comment; never the secret", "soak key show lab.key.pub",
            std::make_shared<KeyShow>()},
           {"sign", "Sign a calibration file; replaces its signature if it has one",
            "soak key sign SN0042.soakcal --key lab.key", std::make_shared<KeySign>()},
           {"verify",
            "Check that a calibration file, or a manifest with its files, is unchanged since a trusted key signed it",
            "soak key verify SN0042.soakcal --key lab.key.pub", std::make_shared<KeyVerify>()}}};
}

}  // namespace soak::station
