// SPDX-License-Identifier: Apache-2.0
#include "station/http/stream_places.h"

#include <fmt/format.h>

namespace soak::station {
namespace {

std::size_t count_of(const std::map<std::string, std::size_t>& counts, const std::string& name) {
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

void take_one_off(std::map<std::string, std::size_t>& counts, const std::string& name) {
  const auto found = counts.find(name);
  if (--found->second == 0) counts.erase(found);
}

tl::unexpected<base::Error> has_enough(const std::string& whose, std::size_t most) {
  return base::bad_input(fmt::format("{} has {} event streams open, as many as it may: close pages or scripts that "
                                     "nobody needs",
                                     whose, most),
                         kTooManyStreams);
}

}  // namespace

base::Result<std::shared_ptr<void>> StreamPlaces::take(const std::string& account, const std::string& address) {
  const std::lock_guard lock(mutex_);
  if (taken_ >= limits_.all) {
    return base::fail(base::ErrorKind::internal, "too many event streams are open", "events");
  }
  if (!account.empty()) {
    if (count_of(by_account_, account) >= limits_.account) return has_enough("account " + account, limits_.account);
    if (count_of(by_address_, address) >= limits_.address) return has_enough("address " + address, limits_.address);
  }
  ++taken_;
  ++by_account_[account];
  ++by_address_[address];
  return std::shared_ptr<void>(nullptr, [this, account, address](void*) { give_back(account, address); });
}

std::size_t StreamPlaces::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

void StreamPlaces::give_back(const std::string& account, const std::string& address) {
  const std::lock_guard lock(mutex_);
  --taken_;
  take_one_off(by_account_, account);
  take_one_off(by_address_, address);
}

}  // namespace soak::station
