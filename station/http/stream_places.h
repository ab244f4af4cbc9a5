// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "base/result.h"

namespace soak::station {

/// `where` of what StreamPlaces::take() refuses because its caller has enough of them.
inline constexpr const char* kTooManyStreams = "streams";

/// Places for event streams, each of which holds one of the listener's threads. Of a station with accounts no account
/// and no address gets all of them: whoever has got hold of one keeps nobody else from watching. Any thread may call.
class StreamPlaces {
 public:
  struct Limits {
    std::size_t all = 80;
    std::size_t account = 20;  ///< pages of one browser share one stream
    std::size_t address = 40;
  };

  explicit StreamPlaces(Limits limits) : limits_(limits) {}

  /// A place, which is free again once the pointer is gone; it must go before this object. `account`: whose stream it
  /// is; empty = of a station without accounts, which only its own machine reaches: there only the sum counts.
  /// `address`: where it goes, numeric. Refuses (where == kTooManyStreams) one more of an account or an address that
  /// has its share, (internal) one more than all.
  [[nodiscard]] base::Result<std::shared_ptr<void>> take(const std::string& account, const std::string& address);

  /// How many are taken.
  [[nodiscard]] std::size_t taken() const;

 private:
  void give_back(const std::string& account, const std::string& address);

  Limits limits_;
  mutable std::mutex mutex_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_account_;
  std::map<std::string, std::size_t> by_address_;
};

}  // namespace soak::station
