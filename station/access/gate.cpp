// SPDX-License-Identifier: Apache-2.0
#include "station/access/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "station/access/secrets.h"

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
    note_refused("login_limited", name, "refused from " + address + ": too many tries");
    return base::bad_input(fmt::format("too many tries: the next one in {:.0f} s", std::ceil(*wait_s)), kTooManyTries);
  }
  const Place place(places_, true);
  const Place kept(kept_place_, !place.is_taken() && limits_.knows(address, name));
  if (!place.is_taken() && !kept.is_taken()) {
    limits_.give_back(address, name, std::chrono::steady_clock::now());
    note_refused("login_limited", name, "refused from " + address + ": too many people at once");
    return base::bad_input("too many people log in at once: try again", kTooManyTries);
  }
  const auto accounts = accounts_.now();
  const Account* account = find_account(*accounts, name);
  if (!has_password(account, password)) {
    note_refused("login_refused", name,
                 "refused from " + address + (account == nullptr ? ": no such account" : ": wrong password"));
    return base::bad_input("this name with this password is not known", kWrongPassword);
  }
  limits_.was_right(address, name, std::chrono::steady_clock::now());
  auto session = sessions_.open(*account, std::chrono::steady_clock::now());
  if (!session) return base::forward_error(session);
  note("logged_in", account->name, fmt::format("logged in from {}, {}", address, name_of(account->role)));
  return Entry{{account->name, account->role}, *std::move(session)};
}

void Gate::log_out(const std::string& session, const std::string& address) {
  const auto known = caller({session, {}});
  sessions_.close(session);
  if (known) note("logged_out", known->name, "logged out from " + address);
}

void Gate::note(const std::string& kind, const std::string& account, const std::string& text) const {
  if (note_) note_(kind, account, text);
}

void Gate::note_refused(const std::string& kind, const std::string& name, const std::string& text) {
  const double now_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  int others = 0;
  {
    const std::lock_guard lock(refusals_);
    if (!ration_.take(now_s)) {
      ++not_noted_;
      return;
    }
    others = std::exchange(not_noted_, 0);
  }
  const bool is_account = find_account(*accounts_.now(), name) != nullptr;
  note(kind, is_account ? name : "", others == 0 ? text : fmt::format("{} ({} more refusals before it)", text, others));
}

bool Gate::has_password(const Account* account, const std::string& password) {
  const std::lock_guard turn(turn_);
  return is_password(account == nullptr ? std::string() : account->password, password);
}

}  // namespace soak::station
