// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <semaphore>
#include <string>

#include "base/result.h"
#include "station/access/accounts.h"
#include "station/access/login_limits.h"
#include "station/access/ration.h"
#include "station/access/sessions.h"

namespace soak::station {

/// Who asks.
struct Caller {
  std::string name;  ///< of the account
  Role role = Role::viewer;
};

/// What a request shows of who asks; empty where it shows nothing.
struct Shown {
  std::string session;  ///< secret of its cookie
  std::string token;    ///< of a script
};

/// `where` of what log_in() refuses.
inline constexpr const char* kWrongPassword = "password";
inline constexpr const char* kTooManyTries = "tries";

/// Decides who may ask a station that others than this machine reach. Any thread may call.
class Gate {
 public:
  /// Takes note of a log-in, granted or not, and of a log-out: kind of event, account (empty = one that does not exist:
  /// its name may be a password that was typed into the wrong field), text.
  using Note = std::function<void(const std::string& kind, const std::string& account, const std::string& text)>;

  explicit Gate(std::filesystem::path data_folder, Note note = {})
      : accounts_(std::move(data_folder)), note_(std::move(note)) {}

  /// Who asks; nothing for somebody who does not show that he is known. A token counts before a session, with its own
  /// role, which its account's limits.
  [[nodiscard]] std::optional<Caller> caller(const Shown& shown);

  struct Entry {
    Caller caller;
    std::string session;  ///< the secret for the cookie
  };
  /// Begins a session. Refuses (bad_input) a wrong name and a wrong password alike (where == kWrongPassword), and tries
  /// beyond LoginLimits or the places for log-ins at a time (where == kTooManyTries). `address`: of who asks, numeric.
  [[nodiscard]] base::Result<Entry> log_in(const std::string& name, const std::string& password,
                                           const std::string& address);

  /// Ends a session, if it is one. `address`: as of log_in().
  void log_out(const std::string& session, const std::string& address);
  /// Ends a session that another one takes the place of.
  void replace(const std::string& session) { sessions_.close(session); }

 private:
  [[nodiscard]] bool has_password(const Account* account, const std::string& password);
  void note(const std::string& kind, const std::string& account, const std::string& text) const;
  /// As note(), of what a stranger can do as often as he likes: beyond a ration it is counted only.
  void note_refused(const std::string& kind, const std::string& name, const std::string& text);

  /// Log-ins that wait for their turn hold threads that others need. One more place is kept for addresses that
  /// LoginLimits knows: strangers cannot take it.
  static constexpr int kMostAtATime = 3;

  AccountBook accounts_;
  Sessions sessions_;
  LoginLimits limits_;
  std::counting_semaphore<kMostAtATime> places_{kMostAtATime};
  std::binary_semaphore kept_place_{1};
  Note note_;
  std::mutex refusals_;
  Ration ration_{60.0, 60.0};
  int not_noted_ = 0;  ///< refusals since the last one that was
  std::mutex turn_;    ///< one password at a time: each takes 64 MiB, and a processor for a tenth of a second
};

}  // namespace soak::station
