// SPDX-License-Identifier: Apache-2.0
#include "station/access/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "station/access/secrets.h"
#include "station/io/host.h"

namespace soak::station {
namespace {

std::optional<Caller> caller_with_token(const Accounts& accounts, const std::string& token) {
  const std::string kept = kept_of_secret(token);
  for (const Account& account : accounts) {
    const auto found = std::ranges::find(account.tokens, kept, &AccessToken::kept);
    if (found != account.tokens.end()) return Caller{account.name, std::min(found->role, account.role)};
  }
  return std::nullopt;
}

/// One of the places of a semaphore, if there is one, for as long as this object lives.
template <class Semaphore>
class Place {
 public:
  Place(Semaphore& places, bool wanted) : places_(places), taken_(wanted && places.try_acquire()) {}
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  ~Place() {
    if (taken_) places_.release();
  }
  [[nodiscard]] bool is_taken() const { return taken_; }

 private:
  Semaphore& places_;
  bool taken_;
};

}  // namespace

std::optional<Caller> Gate::caller(const Shown& shown) {
  const auto accounts = accounts_.now();
  if (!shown.token.empty()) return caller_with_token(*accounts, shown.token);
  if (shown.session.empty()) return std::nullopt;
  const Account* account = sessions_.account_of(shown.session, *accounts, std::chrono::steady_clock::now());
  return account == nullptr ? std::nullopt : std::optional(Caller{account->name, account->role});
}

base::Result<Gate::Entry> Gate::log_in(const std::string& name, const std::string& password,
                                       const std::string& address) {
  if (const auto wait_s = limits_.take_try(address, name, std::chrono::steady_clock::now())) {
    return base::bad_input(fmt::format("too many tries: the next one in {:.0f} s", std::ceil(*wait_s)), kTooManyTries);
  }
  const Place place(places_, true);
  const Place kept(kept_place_, !place.is_taken() && limits_.knows(address, name));
  if (!place.is_taken() && !kept.is_taken()) {
    limits_.give_back(address, name, std::chrono::steady_clock::now());
    return base::bad_input("too many people log in at once: try again", kTooManyTries);
  }
  const auto accounts = accounts_.now();
  const Account* account = find_account(*accounts, name);
  const bool right = has_password(account, password);
  // A name that is nobody's may be a password that was typed into the wrong field.
  const std::string who = account == nullptr ? "an account that does not exist" : account->name;
  log_line(fmt::format("log-in of {} from {}{}", who, address, right ? "" : ": refused"));
  if (!right) return base::bad_input("this name with this password is not known", kWrongPassword);
  limits_.was_right(address, name, std::chrono::steady_clock::now());
  auto session = sessions_.open(*account, std::chrono::steady_clock::now());
  if (!session) return base::forward_error(session);
  return Entry{{account->name, account->role}, *std::move(session)};
}

bool Gate::has_password(const Account* account, const std::string& password) {
  const std::lock_guard turn(turn_);
  return is_password(account == nullptr ? std::string() : account->password, password);
}

}  // namespace soak::station
