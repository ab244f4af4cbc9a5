// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/text.h"
#include "station/access/accounts.h"
#include "station/access/secrets.h"
#include "station/commands/command.h"
#include "station/io/data_folder.h"
#include "station/io/host.h"
#include "station/io/password_input.h"
#include "station/io/text.h"

namespace soak::station {
namespace {

using nlohmann::json;

const std::vector<std::string> kRoles = {"viewer", "operator", "engineer"};

/// What all commands that change an account do: change it, enter that into the event log, say it.
struct UserCommand : Command {
  std::string name;

  void declare(OptionList& options) override {
    options.add("name NAME", &name, "Name of the account: a-z, 0-9, '.', '_', '-'").required();
  }
  /// Changes the account, or refuses (bad_input) one that does not exist.
  base::Status change(const std::function<base::Status(Accounts&, Account&)>& what) const;
  /// To the event log and to standard output.
  base::Status tell(const std::string& what, Output& output) const;
};

base::Status UserCommand::change(const std::function<base::Status(Accounts&, Account&)>& what) const {
  const auto folder = data_folder(data);
  if (!folder) return base::forward_error(folder);
  return change_accounts(*folder, [&](Accounts& accounts) -> base::Status {
    const auto account = std::ranges::find(accounts, name, &Account::name);
    if (account == accounts.end()) return base::bad_input("no such account: 'soak user list' shows all", name);
    return what(accounts, *account);
  });
}

base::Status UserCommand::tell(const std::string& what, Output& output) const {
  auto catalog = open_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  const auto logged = catalog->log_event({now_utc_s(), "account", name, what, user_name()});
  if (!logged) return base::forward_error(logged);
  output.print(fmt::format("account {}: {}\n", name, what));
  return {};
}

base::Result<std::string> new_password(const std::string& name) {
  auto password = read_password("password of " + name);
  if (!password) return password;
  if (auto fits = check_password(*password); !fits) return base::forward_error(fits);
  return kept_of_password(*password);
}

/// soak user add NAME --role ROLE
struct UserAdd final : UserCommand {
  std::string role;

  void declare(OptionList& options) override {
    UserCommand::declare(options);
    options
        .add("--role ROLE", &role,
             "viewer: looks; operator: also runs campaigns and fits; engineer: also withdraws data, exports, accepts "
             "effects, changes settings")
        .required()
        .one_of(kRoles);
  }
  base::Status run(Output& output) override;
};

base::Status UserAdd::run(Output& output) {
  if (auto fits = check_account_name(name); !fits) return fits;
  const auto catalog = open_catalog(data);  // makes the data folder where it is new
  if (!catalog) return base::forward_error(catalog);
  const auto kept = new_password(name);
  if (!kept) return base::forward_error(kept);
  auto added = change_accounts(catalog->data_folder(), [&](Accounts& accounts) -> base::Status {
    if (find_account(accounts, name) != nullptr) {
      return base::bad_input("there is such an account already: 'soak user password' gives it another password", name);
    }
    accounts.push_back({name, *parse_role(role), *kept, now_utc_s(), {}});
    return {};
  });
  if (!added) return added;
  return tell("added as " + role, output);
}

/// soak user remove NAME
struct UserRemove final : UserCommand {
  base::Status run(Output& output) override {
    auto removed = change([&](Accounts& accounts, Account&) -> base::Status {
      std::erase_if(accounts, [&](const Account& account) { return account.name == name; });
      return {};
    });
    if (!removed) return removed;
    return tell("removed, with its tokens", output);
  }
};

/// soak user password NAME
struct UserPassword final : UserCommand {
  base::Status run(Output& output) override {
    const auto kept = new_password(name);
    if (!kept) return base::forward_error(kept);
    auto changed = change([&](Accounts&, Account& account) -> base::Status {
      account.password = *kept;
      return {};
    });
    if (!changed) return changed;
    return tell("new password; whoever was logged in has to log in again", output);
  }
};

/// soak user token NAME --label TEXT [--role ROLE]
struct UserToken final : UserCommand {
  std::string label;
  std::string role;

  void declare(OptionList& options) override {
    UserCommand::declare(options);
    options.add("--label TEXT", &label, "What the token is for, such as the script's name").required();
    options.add("--role ROLE", &role, "What it may do (default: what the account may; never more)").one_of(kRoles);
  }
  base::Status run(Output& output) override;
};

base::Status UserToken::run(Output& output) {
  if (auto fits = check_text_line(label, "--label"); !fits) return fits;
  const auto secret = new_secret();
  if (!secret) return base::forward_error(secret);
  Role may = Role::viewer;
  auto made = change([&](Accounts&, Account& account) -> base::Status {
    if (std::ranges::find(account.tokens, label, &AccessToken::label) != account.tokens.end()) {
      return base::bad_input("the account has a token of that label: 'soak user revoke' ends it", label);
    }
    may = role.empty() ? account.role : std::min(*parse_role(role), account.role);
    account.tokens.push_back({label, may, kept_of_secret(*secret), now_utc_s()});
    return {};
  });
  if (!made) return made;
  auto catalog = open_catalog(data);
  if (!catalog) return base::forward_error(catalog);
  const std::string what = fmt::format("token {} made, may do what {} may", label, name_of(may));
  const auto logged = catalog->log_event({now_utc_s(), "account", name, what, user_name()});
  if (!logged) return base::forward_error(logged);
  if (output.json()) {
    return output.print_json({{"account", name}, {"label", label}, {"role", name_of(may)}, {"token", *secret}});
  }
  output.print(*secret + "\n");
  output.note("keep it in a file that nobody else can read: it is not shown again");
  return {};
}

/// soak user revoke NAME --label TEXT
struct UserRevoke final : UserCommand {
  std::string label;

  void declare(OptionList& options) override {
    UserCommand::declare(options);
    options.add("--label TEXT", &label, "Label of the token").required();
  }
  base::Status run(Output& output) override {
    auto revoked = change([&](Accounts&, Account& account) -> base::Status {
      const auto is_it = [&](const AccessToken& token) { return token.label == label; };
      if (std::erase_if(account.tokens, is_it) == 1) return {};
      return base::bad_input("the account has no token of that label: 'soak user list' shows all", label);
    });
    if (!revoked) return revoked;
    return tell(fmt::format("token {} revoked", label), output);
  }
};

/// soak user list
struct UserList final : Command {
  base::Status run(Output& output) override;
};

json account_document(const Account& account) {
  json tokens = json::array();
  for (const AccessToken& token : account.tokens) {
    tokens.push_back({{"label", token.label}, {"role", name_of(token.role)}, {"made_utc_s", token.made_utc_s}});
  }
  return {{"name", account.name},
          {"role", name_of(account.role)},
          {"made_utc_s", account.made_utc_s},
          {"tokens", std::move(tokens)}};
}

base::Status UserList::run(Output& output) {
  const auto folder = data_folder(data);
  if (!folder) return base::forward_error(folder);
  const auto accounts = read_accounts(*folder);
  if (!accounts) return base::forward_error(accounts);
  json document = {{"accounts", json::array()}};
  std::vector<std::vector<std::string>> rows = {{"account", "role", "since", "token"}};
  for (const Account& account : *accounts) {
    document["accounts"].push_back(account_document(account));
    rows.push_back({account.name, std::string(name_of(account.role)), base::utc_text(account.made_utc_s), ""});
    for (const AccessToken& token : account.tokens) {
      rows.push_back({account.name, std::string(name_of(token.role)), base::utc_text(token.made_utc_s), token.label});
    }
  }
  if (output.json()) return output.print_json(document);
  output.print(rows.size() == 1 ? "no accounts\n" : text_table(rows));
  return {};
}

}  // namespace

CommandGroup user_commands() {
  return {"user",
          "Who may use the station over the network: accounts and tokens",
          {{"add", "Add an account; asks for its password, or reads it from standard input",
            "soak user add eva --role engineer", std::make_shared<UserAdd>(), false},
           {"list", "List accounts and their tokens", "soak user list", std::make_shared<UserList>()},
           {"password", "Give an account another password; asks for it, or reads it from standard input",
            "soak user password eva", std::make_shared<UserPassword>(), false},
           {"remove", "Remove an account with its tokens; what it did stays in the event log", "soak user remove eva",
            std::make_shared<UserRemove>(), false},
           {"token", "Make a token with which a script shows who it is; printed once",
            "soak user token eva --label nightly --role viewer > nightly.token", std::make_shared<UserToken>()},
           {"revoke", "End a token", "soak user revoke eva --label nightly", std::make_shared<UserRevoke>(), false}}};
}

}  // namespace soak::station
