// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

/// Who may use a station over the network (docs/access.md). Accounts stand in a file of the data folder that its owner
/// alone may read; `soak user` writes it, soakd reads it again when it has changed.
namespace soak::station {

/// Each may do what those before it may.
enum class Role {
  viewer,     ///< looks
  operating,  ///< "operator": runs campaigns, answers prompts, fits and verifies
  engineer,   ///< also withdraws data, exports, accepts effects, changes settings
};

/// "viewer", "operator", "engineer".
[[nodiscard]] std::string_view name_of(Role role);
/// The inverse of name_of(). Refuses (bad_input, where == "role") any other text.
[[nodiscard]] base::Result<Role> parse_role(std::string_view text);

/// What a script shows in place of a password.
struct AccessToken {
  std::string label;  ///< unique in its account
  Role role = Role::viewer;
  std::string kept;  ///< kept_of_secret() of the token
  double made_utc_s = 0.0;
};

struct Account {
  std::string name;
  Role role = Role::viewer;
  std::string password;  ///< kept_of_password()
  double made_utc_s = 0.0;
  std::vector<AccessToken> tokens;
};

using Accounts = std::vector<Account>;

/// Names appear in logs, records and tables: 1 to 32 of a-z, 0-9, '.', '_' and '-', a letter first. Refuses (bad_input)
/// any other.
[[nodiscard]] base::Status check_account_name(std::string_view name);

/// Null where there is none.
[[nodiscard]] const Account* find_account(const Accounts& accounts, std::string_view name);

/// The file in a data folder.
[[nodiscard]] std::filesystem::path accounts_file(const std::filesystem::path& data_folder);

/// The accounts of a data folder; none where there is no such file. Refuses a file that others than its owner may read
/// or write (bad_input) and one that is damaged or holds what `soak user` would not have written (corrupt).
[[nodiscard]] base::Result<Accounts> read_accounts(const std::filesystem::path& data_folder);

/// Changes the accounts of a data folder and writes them, all or nothing. The files are the folder's owner's, also
/// where root writes them; anybody else is refused (bad_input). One process at a time: a second one is refused
/// (bad_input). What `change` refuses is passed on, and nothing is written.
[[nodiscard]] base::Status change_accounts(const std::filesystem::path& data_folder,
                                           const std::function<base::Status(Accounts&)>& change);

/// The accounts as they are at any time, for a program that runs for weeks. Any thread may ask.
class AccountBook {
 public:
  explicit AccountBook(std::filesystem::path data_folder);

  /// Never null. Where the file is gone or cannot be read the accounts stay those that were read last, and the log says
  /// why: with its data folder lost a station must still take an abort. One caller at a time looks at the file; the
  /// others do not wait for it, which may be on a disk that does not answer.
  [[nodiscard]] std::shared_ptr<const Accounts> now();

 private:
  /// Reads the file again where it has changed.
  void look();

  std::filesystem::path folder_;
  std::mutex look_;
  std::optional<struct stat> seen_;  ///< of the file that accounts_ was read from
  std::string trouble_;              ///< that the log was told last; empty = none since
  std::atomic<std::shared_ptr<const Accounts>> accounts_ = std::make_shared<const Accounts>();
};

}  // namespace soak::station
