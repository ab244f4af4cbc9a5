// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "station/access/accounts.h"

namespace soak::station {

/// Who is logged in at a page. Sessions live in memory: a new soakd asks everybody for the password again. Any thread
/// may call; times are given, so that nothing has to wait for them.
class Sessions {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Without a request for so long a session ends. An open page is no silence: its event stream counts.
  static constexpr std::chrono::hours kLongestSilence{1};
  /// However much it is used, a session ends after so long: a working week and its weekend.
  static constexpr std::chrono::hours kLongestSession{7 * 24};
  /// Sessions of one account; for one more the one ends that has been silent longest.
  static constexpr std::size_t kMostOfAnAccount = 32;

  /// Begins a session; its secret, which is kept nowhere else.
  [[nodiscard]] base::Result<std::string> open(const Account& account, Time now);

  /// The account that a secret is a session of, and counts that as a use of it. Null for a secret that was never given
  /// out, or whose session has ended: by time, by close(), or since the account has gone or has a new password.
  [[nodiscard]] const Account* account_of(std::string_view secret, const Accounts& accounts, Time now);

  /// Ends a session; nothing where there is none.
  void close(std::string_view secret);

 private:
  struct Session {
    std::string account;
    std::string password;  ///< as it was kept when the session began
    Time begun;
    Time used;
  };

  static bool has_ended(const Session& session, Time now);
  void make_room(const std::string& account, Time now);

  std::mutex mutex_;
  std::map<std::string, Session> sessions_;  ///< by kept_of_secret()
};

}  // namespace soak::station
