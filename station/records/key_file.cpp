// SPDX-License-Identifier: Apache-2.0
#include "station/records/key_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include "base/file_descriptor.h"
#include "base/hash.h"
#include "db/durable.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

constexpr std::string_view kSecretHead = "soak-secret-key-1";
constexpr std::string_view kPublicHead = "soak-public-key-1";
constexpr std::string_view kCommentWord = "comment ";
constexpr mode_t kOwnerOnly = 0600;
constexpr mode_t kEveryone = 0644;
constexpr mode_t kGroupAndOthers = 077;

using KeyBytes = PublicKey;
static_assert(std::is_same_v<KeyBytes, SecretKey::Seed>);

/// Text that is wiped with the secret in it.
struct WipedText {
  std::string text;

  explicit WipedText(std::string content) : text(std::move(content)) {}
  WipedText(const WipedText&) = delete;
  WipedText& operator=(const WipedText&) = delete;
  ~WipedText() { wipe(text); }
};

/// Takes the first line off the text.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::optional<KeyBytes> bytes_of_hex(std::string_view digits) {
  KeyBytes bytes{};
  if (digits.size() != 2 * bytes.size()) return std::nullopt;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char* first = digits.data() + 2 * i;
    if (std::from_chars(first, first + 2, bytes[i], 16).ptr != first + 2) return std::nullopt;
  }
  return bytes;
}

struct ParsedKey {
  KeyBytes bytes{};
  std::string comment;
};

/// The lines after the first.
base::Result<ParsedKey> parse_body(std::string_view text, const std::string& where) {
  const auto bytes = bytes_of_hex(take_line(text));
  if (!bytes)
    return base::bad_input("the key must be 64 hexadecimal digits on a line of their own", where + ", line 2");
  ParsedKey parsed{*bytes, {}};
  const std::string_view comment = take_line(text);
  if (comment.starts_with(kCommentWord)) parsed.comment = comment.substr(kCommentWord.size());
  if (!text.empty() || (!comment.empty() && !comment.starts_with(kCommentWord))) {
    return base::bad_input("a key file must end after the key and a line 'comment TEXT'", where + ", line 3");
  }
  return parsed;
}

std::optional<KeyKind> kind_of(std::string_view head) {
  if (head == kSecretHead) return KeyKind::secret_key;
  if (head == kPublicHead) return KeyKind::public_key;
  return std::nullopt;
}

/// The key in a file that must be of the kind.
base::Result<ParsedKey> parse_key(std::string_view text, KeyKind wanted, const std::string& where) {
  const auto kind = kind_of(take_line(text));
  if (!kind) return base::bad_input("is not a key file: 'soak key new' makes one", where);
  if (*kind == wanted) return parse_body(text, where);
  return base::bad_input(wanted == KeyKind::public_key
                             ? "is a secret key: give the public key, the file beside it that ends in .pub"
                             : "is a public key: give the secret key, the file beside it without .pub",
                         where);
}

base::Status check_private(const std::filesystem::path& path) {
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0 || (status.st_mode & kGroupAndOthers) == 0) return {};
  return base::bad_input(fmt::format("others may read or write this secret key (mode {:04o}): 'chmod 600' it, and make "
                                     "a new key if somebody may have copied it",
                                     status.st_mode & 0777U),
                         path.string());
}

std::string key_text(std::string_view head, const KeyBytes& bytes, const std::string& comment) {
  return fmt::format("{}\n{}\n{}", head, base::to_hex(bytes),
                     comment.empty() ? "" : fmt::format("{}{}\n", kCommentWord, comment));
}

/// Creates the file, which must not be there; on failure nothing is left behind.
base::Status create_file(const std::filesystem::path& path, std::string_view text, mode_t mode) {
  base::FileDescriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
  if (!file && errno == EEXIST) {
    return base::bad_input("already exists: keys are never overwritten, give another name", path.string());
  }
  if (!file) {
    return base::bad_input("cannot create the file: " + std::generic_category().message(errno), path.string());
  }
  const bool written = ::write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const bool kept = written && ::fsync(file.get()) == 0;
  const int error = errno;
  file.reset();
  if (kept) return db::sync_name(path);
  ::unlink(path.c_str());
  return base::fail(base::ErrorKind::internal, "cannot write the file: " + std::generic_category().message(error),
                    path.string());
}

}  // namespace

base::Result<KeyKind> kind_of_key_file(const std::filesystem::path& path) {
  auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const WipedText wiped(*std::move(text));
  std::string_view rest = wiped.text;
  const auto kind = kind_of(take_line(rest));
  if (!kind) return base::bad_input("is not a key file: 'soak key new' makes one", path.string());
  return *kind;
}

base::Result<PublicKeyFile> read_public_key(const std::filesystem::path& path) {
  auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const WipedText wiped(*std::move(text));  // it may be a secret key by mistake
  auto parsed = parse_key(wiped.text, KeyKind::public_key, path.string());
  if (!parsed) return base::forward_error(parsed);
  return PublicKeyFile{parsed->bytes, std::move(parsed->comment), path};
}

base::Result<SecretKeyFile> read_secret_key(const std::filesystem::path& path) {
  auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const WipedText wiped(*std::move(text));
  auto parsed = parse_key(wiped.text, KeyKind::secret_key, path.string());
  if (!parsed) return base::forward_error(parsed);
  SecretKeyFile file{SecretKey(parsed->bytes), std::move(parsed->comment)};
  wipe(parsed->bytes);
  if (auto status = check_private(path); !status) return base::forward_error(status);
  return file;
}

base::Result<std::vector<PublicKeyFile>> read_trusted_keys(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".pub") paths.push_back(entry.path());
  }
  if (error) return base::bad_input("cannot read the folder of trusted keys: " + error.message(), folder.string());
  if (paths.empty()) return base::bad_input("the folder holds no public key (*.pub)", folder.string());
  std::sort(paths.begin(), paths.end());
  std::vector<PublicKeyFile> keys;
  for (const auto& path : paths) {
    auto key = read_public_key(path);
    if (!key) return base::forward_error(key);
    keys.push_back(*std::move(key));
  }
  return keys;
}

base::Status write_new_key(const std::filesystem::path& path, const SecretKey& key, const std::string& comment) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (std::any_of(comment.begin(), comment.end(), is_control)) {
    return base::bad_input("the comment must be one line of text", "--comment");
  }
  const WipedText secret(key_text(kSecretHead, key.seed(), comment));
  if (auto status = create_file(path, secret.text, kOwnerOnly); !status) return status;
  auto status = create_file(public_path_of(path), key_text(kPublicHead, public_key_of(key), comment), kEveryone);
  if (!status) ::unlink(path.c_str());
  return status;
}

std::filesystem::path public_path_of(const std::filesystem::path& secret_path) { return secret_path.string() + ".pub"; }

}  // namespace soak::station
