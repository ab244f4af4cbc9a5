// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace soak::station {

/// How often passwords may be tried. Each address has a few tries, and so has each account; both come back with time.
///
/// Whoever tries many passwords of an account from many addresses would use up its tries and keep its owner out. So an
/// address from which the account was logged in before counts for itself alone: what strangers try takes nothing from
/// it. The machine itself counts as such an address, so that one way in is always left. Tokens have no tries to use up.
/// Memory is bounded. Any thread may call.
class LoginLimits {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr double kTriesOfAnAddress = 10.0;
  static constexpr double kTriesOfAnAccount = 20.0;
  static constexpr double kTryReturnsAfter_s = 30.0;

  /// Takes one try; nothing where there is one, else the seconds until there is. `address` is numeric.
  [[nodiscard]] std::optional<double> take_try(const std::string& address, const std::string& account, Time now);

  /// The try was right: it is given back, and the address is known for the account from now on.
  void was_right(const std::string& address, const std::string& account, Time now);

  /// Gives a try back that came to nothing: the password was not looked at.
  void give_back(const std::string& address, const std::string& account, Time now);

  /// Whether the account was logged in from this address before, or it is the machine itself.
  [[nodiscard]] bool knows(const std::string& address, const std::string& account);

 private:
  /// Tries that are used up: one of them returns every kTryReturnsAfter_s.
  struct Used {
    double tries = 0.0;
    Time at;
  };
  using Table = std::map<std::string, Used>;

  static double used_now(const Used& used, Time now);
  static std::optional<double> wait_s(const Table& table, const std::string& key, double most, Time now);
  static void count(Table& table, const std::string& key, double tries, Time now);
  [[nodiscard]] bool is_familiar(const std::string& address, const std::string& account) const;

  std::mutex mutex_;
  Table addresses_;
  Table accounts_;
  std::set<std::pair<std::string, std::string>> familiar_;  ///< address and account
};

}  // namespace soak::station
