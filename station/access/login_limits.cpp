// SPDX-License-Identifier: Apache-2.0
#include "station/access/login_limits.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace soak::station {
namespace {

constexpr std::size_t kMostEntries = 4096;

/// What counts as one address: of IPv6 its first 64 bits, since whoever has one of a network has all of them.
std::string place_of(const std::string& address) {
  in6_addr bytes{};
  if (::inet_pton(AF_INET6, address.c_str(), &bytes) != 1) return address;
  if (IN6_IS_ADDR_V4MAPPED(&bytes)) return address.substr(address.rfind(':') + 1);
  if (IN6_IS_ADDR_LOOPBACK(&bytes)) return address;
  std::fill(bytes.s6_addr + 8, bytes.s6_addr + 16, std::uint8_t{0});
  std::array<char, INET6_ADDRSTRLEN> text{};
  return ::inet_ntop(AF_INET6, &bytes, text.data(), text.size());
}

bool is_this_machine(const std::string& place) { return place == "::1" || place.starts_with("127."); }

}  // namespace

std::optional<double> LoginLimits::take_try(const std::string& address, const std::string& account, Time now) {
  const std::string place = place_of(address);
  const std::lock_guard lock(mutex_);
  const bool familiar = is_familiar(place, account);
  const auto of_address = wait_s(addresses_, place, kTriesOfAnAddress, now);
  const auto of_account = familiar ? std::nullopt : wait_s(accounts_, account, kTriesOfAnAccount, now);
  if (of_address || of_account) return std::max(of_address.value_or(0.0), of_account.value_or(0.0));
  count(addresses_, place, 1.0, now);
  if (!familiar) count(accounts_, account, 1.0, now);
  return std::nullopt;
}

void LoginLimits::was_right(const std::string& address, const std::string& account, Time now) {
  give_back(address, account, now);
  const std::string place = place_of(address);
  const std::lock_guard lock(mutex_);
  if (is_familiar(place, account)) return;
  if (familiar_.size() >= kMostEntries) familiar_.erase(familiar_.begin());
  familiar_.insert({place, account});
}

void LoginLimits::give_back(const std::string& address, const std::string& account, Time now) {
  const std::string place = place_of(address);
  const std::lock_guard lock(mutex_);
  count(addresses_, place, -1.0, now);
  if (!is_familiar(place, account)) count(accounts_, account, -1.0, now);
}

bool LoginLimits::knows(const std::string& address, const std::string& account) {
  const std::lock_guard lock(mutex_);
  return is_familiar(place_of(address), account);
}

double LoginLimits::used_now(const Used& used, Time now) {
  const double passed_s = std::chrono::duration<double>(now - used.at).count();
  return std::max(0.0, used.tries - passed_s / kTryReturnsAfter_s);
}

std::optional<double> LoginLimits::wait_s(const Table& table, const std::string& key, double most, Time now) {
  const auto found = table.find(key);
  if (found == table.end()) return std::nullopt;
  const double too_many = used_now(found->second, now) + 1.0 - most;
  return too_many > 0.0 ? std::optional(too_many * kTryReturnsAfter_s) : std::nullopt;
}

void LoginLimits::count(Table& table, const std::string& key, double tries, Time now) {
  if (table.size() >= kMostEntries && !table.contains(key)) {
    std::erase_if(table, [&](const auto& entry) { return used_now(entry.second, now) == 0.0; });
    // Where all are in use those go that have tried least: an address that goes on trying stays.
    const auto least =
        std::ranges::min_element(table, {}, [&](const auto& entry) { return used_now(entry.second, now); });
    if (table.size() >= kMostEntries) table.erase(least);
  }
  Used& used = table[key];
  used = {std::max(0.0, used_now(used, now) + tries), now};
}

bool LoginLimits::is_familiar(const std::string& address, const std::string& account) const {
  return is_this_machine(address) || familiar_.contains({address, account});
}

}  // namespace soak::station
