// SPDX-License-Identifier: Apache-2.0
#include "station/access/sessions.h"

#include <algorithm>

#include "station/access/secrets.h"

namespace soak::station {

base::Result<std::string> Sessions::open(const Account& account, Time now) {
  auto secret = new_secret();
  if (!secret) return secret;
  const std::lock_guard lock(mutex_);
  make_room(account.name, now);
  sessions_[kept_of_secret(*secret)] = {account.name, account.password, now, now};
  return secret;
}

const Account* Sessions::account_of(std::string_view secret, const Accounts& accounts, Time now) {
  const std::string kept = kept_of_secret(secret);
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(kept);
  if (found == sessions_.end()) return nullptr;
  const Account* account = find_account(accounts, found->second.account);
  if (account == nullptr || account->password != found->second.password || has_ended(found->second, now)) {
    sessions_.erase(found);
    return nullptr;
  }
  found->second.used = std::max(found->second.used, now);
  return account;
}

void Sessions::close(std::string_view secret) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(kept_of_secret(secret));
}

bool Sessions::has_ended(const Session& session, Time now) {
  return now - session.used > kLongestSilence || now - session.begun > kLongestSession;
}

void Sessions::make_room(const std::string& account, Time now) {
  std::erase_if(sessions_, [&](const auto& entry) { return has_ended(entry.second, now); });
  std::size_t count = 0;
  auto longest_silent = sessions_.end();
  for (auto one = sessions_.begin(); one != sessions_.end(); ++one) {
    if (one->second.account != account) continue;
    ++count;
    if (longest_silent == sessions_.end() || one->second.used < longest_silent->second.used) longest_silent = one;
  }
  if (count >= kMostOfAnAccount) sessions_.erase(longest_silent);
}

}  // namespace soak::station
