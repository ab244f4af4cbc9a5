// SPDX-License-Identifier: Apache-2.0
#include "station/access/accounts.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "base/file_descriptor.h"
#include "db/durable.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/text.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 3> kRoles = {"viewer", "operator", "engineer"};
constexpr int kFormat = 1;
constexpr mode_t kOwnerOnly = 0600;
constexpr mode_t kGroupAndOthers = 0077;

json token_json(const AccessToken& token) {
  return {
      {"label", token.label}, {"role", name_of(token.role)}, {"sha256", token.kept}, {"made_utc_s", token.made_utc_s}};
}

json account_json(const Account& account) {
  json tokens = json::array();
  for (const AccessToken& token : account.tokens) tokens.push_back(token_json(token));
  return {{"name", account.name},
          {"role", name_of(account.role)},
          {"password", account.password},
          {"made_utc_s", account.made_utc_s},
          {"tokens", std::move(tokens)}};
}

std::string text_of(const Accounts& accounts) {
  json document = {{"format", kFormat}, {"accounts", json::array()}};
  for (const Account& account : accounts) document["accounts"].push_back(account_json(account));
  return document.dump(1) + "\n";
}

base::Result<AccessToken> token_of(const json& document) {
  const auto role = parse_role(document.at("role").get<std::string>());
  if (!role) return base::forward_error(role);
  AccessToken token{document.at("label"), *role, document.at("sha256"), document.at("made_utc_s")};
  if (auto fits = check_text_line(token.label, "label"); !fits) return base::forward_error(fits);
  return token;
}

base::Result<Account> account_of(const json& document) {
  const auto role = parse_role(document.at("role").get<std::string>());
  if (!role) return base::forward_error(role);
  Account account{document.at("name"), *role, document.at("password"), document.at("made_utc_s"), {}};
  if (auto fits = check_account_name(account.name); !fits) return base::forward_error(fits);
  for (const json& entry : document.at("tokens")) {
    auto token = token_of(entry);
    if (!token) return base::forward_error(token);
    account.tokens.push_back(*std::move(token));
  }
  return account;
}

base::Result<Accounts> accounts_of(const std::string& text) {
  const json document = json::parse(text);
  if (document.at("format") != kFormat) return base::bad_input("written by a newer version of Soak");
  Accounts accounts;
  std::set<std::string> names;
  for (const json& entry : document.at("accounts")) {
    auto account = account_of(entry);
    if (!account) return base::forward_error(account);
    if (!names.insert(account->name).second) return base::bad_input("two accounts are called " + account->name);
    accounts.push_back(*std::move(account));
  }
  return accounts;
}

/// Whose accounts they are: soakd, which reads them, runs as the owner of its data folder.
struct Owner {
  uid_t user = 0;
  gid_t group = 0;
};

/// The owner of the data folder. Refuses (bad_input) somebody who is neither that owner nor root: soakd could not read
/// what he writes.
base::Result<Owner> owner_of(const std::filesystem::path& data_folder) {
  struct stat status{};
  if (::stat(data_folder.c_str(), &status) != 0) {
    return base::bad_input("cannot be read: " + std::generic_category().message(errno), data_folder.string());
  }
  if (::geteuid() == 0 || ::geteuid() == status.st_uid) return Owner{status.st_uid, status.st_gid};
  const struct passwd* account = ::getpwuid(status.st_uid);
  const std::string name = account != nullptr ? account->pw_name : fmt::format("'#{}'", status.st_uid);
  return base::bad_input(
      fmt::format("the data folder belongs to {}, who alone may change its accounts: run 'sudo -u {} "
                  "soak user ... --data {}'",
                  name, name, data_folder.string()),
      data_folder.string());
}

/// For root, whose files soakd could not read; nobody else can give files away.
bool give_to(int file, const Owner& owner) {
  return ::geteuid() == owner.user || ::fchown(file, owner.user, owner.group) == 0;
}

base::Status check_private(const std::filesystem::path& path) {
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0 || (status.st_mode & kGroupAndOthers) == 0) return {};
  return base::bad_input(fmt::format("others may read or write the accounts (mode {:04o}): 'chmod 600' the file, and "
                                     "give all accounts new passwords if somebody may have copied it",
                                     status.st_mode & 07777U),
                         path.string());
}

/// Written to a file that is private from its first moment on, then renamed.
base::Status write_accounts(const std::filesystem::path& path, const std::string& text, const Owner& owner) {
  const std::filesystem::path temporary = path.string() + ".tmp";
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  bool written = false;
  int error = 0;
  {
    const base::FileDescriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly));
    written = file && give_to(file.get(), owner) &&
              ::write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
    error = errno;
  }
  base::Status kept =
      written ? db::rename_durably(temporary, path)
              : base::fail(base::ErrorKind::internal,
                           "cannot write the accounts: " + std::generic_category().message(error), path.string());
  if (!kept) std::filesystem::remove(temporary, ignored);
  return kept;
}

bool is_same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size && a.st_mode == b.st_mode &&
         a.st_mtim.tv_sec == b.st_mtim.tv_sec && a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

}  // namespace

std::string_view name_of(Role role) { return kRoles.at(static_cast<std::size_t>(role)); }

base::Result<Role> parse_role(std::string_view text) {
  const auto found = std::ranges::find(kRoles, text);
  if (found != kRoles.end()) return static_cast<Role>(found - kRoles.begin());
  return base::bad_input(fmt::format("'{}' is no role: give viewer, operator or engineer", text), "role");
}

base::Status check_account_name(std::string_view name) {
  const auto is_small = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto is_allowed = [&](char c) {
    return is_small(c) || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= 32 && is_small(name.front()) && std::ranges::all_of(name, is_allowed)) return {};
  return base::bad_input("the name of an account has 1 to 32 of a-z, 0-9, '.', '_' and '-', a letter first", "name");
}

const Account* find_account(const Accounts& accounts, std::string_view name) {
  const auto found = std::ranges::find(accounts, name, &Account::name);
  return found == accounts.end() ? nullptr : &*found;
}

std::filesystem::path accounts_file(const std::filesystem::path& data_folder) { return data_folder / "soakd.accounts"; }

base::Result<Accounts> read_accounts(const std::filesystem::path& data_folder) {
  const std::filesystem::path path = accounts_file(data_folder);
  std::error_code failure;
  if (!std::filesystem::exists(path, failure) && !failure) return Accounts{};
  if (auto is_private = check_private(path); !is_private) return base::forward_error(is_private);
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const auto damaged = [&](const std::string& why) {
    return base::fail(
        base::ErrorKind::corrupt,
        "the accounts cannot be read (" + why + "): bring the file back from a copy, or delete it and add them again",
        path.string());
  };
  try {
    auto accounts = accounts_of(*text);
    if (!accounts) return damaged(accounts.error().message);
    return accounts;
  } catch (const json::exception&) {
    return damaged("not what 'soak user' writes");
  }
}

base::Status change_accounts(const std::filesystem::path& data_folder,
                             const std::function<base::Status(Accounts&)>& change) {
  const auto owner = owner_of(data_folder);
  if (!owner) return base::forward_error(owner);
  const std::filesystem::path lock_file = data_folder / "soakd.accounts.lock";
  const auto lock = FolderLock::take(lock_file, "soak user");
  if (!lock) return base::forward_error(lock);
  if (const base::FileDescriptor file(::open(lock_file.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
      !file || !give_to(file.get(), *owner)) {
    return base::fail(base::ErrorKind::internal,
                      "cannot be given to the owner of the data folder: " + std::generic_category().message(errno),
                      lock_file.string());
  }
  auto accounts = read_accounts(data_folder);
  if (!accounts) return base::forward_error(accounts);
  if (auto changed = change(*accounts); !changed) return changed;
  return write_accounts(accounts_file(data_folder), text_of(*accounts), *owner);
}

AccountBook::AccountBook(std::filesystem::path data_folder) : folder_(std::move(data_folder)) { look(); }

std::shared_ptr<const Accounts> AccountBook::now() {
  if (const std::unique_lock turn(look_, std::try_to_lock); turn) look();
  return accounts_;
}

void AccountBook::look() {
  struct stat found{};
  const bool is_there = ::stat(accounts_file(folder_).c_str(), &found) == 0;
  if (is_there ? seen_ && is_same_file(*seen_, found) : !seen_) {
    trouble_.clear();
    return;
  }
  auto accounts =
      is_there ? read_accounts(folder_) : base::bad_input("the file is gone", accounts_file(folder_).string());
  if (accounts) {
    accounts_ = std::make_shared<const Accounts>(*std::move(accounts));
    seen_ = found;
    trouble_.clear();
    return;
  }
  // It is read again for each question until that succeeds: a revocation must not be lost.
  std::string trouble = accounts.error().where + ": " + accounts.error().message;
  if (trouble != trouble_) log_line("accounts stay as they were: " + trouble);
  trouble_ = std::move(trouble);
}

}  // namespace soak::station
