// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "hal/imu/detail/xbus.h"
#include "hal/imu/imu.h"

namespace soak::hal::imu {

/// Fails (bad_input) unless a unit can be asked for these rates: whole numbers of Hz, 1 to 2000.
[[nodiscard]] base::Status check_rates(const Imu::Settings& settings);

/// The dialogue that makes a unit stream: into configuration, who are you, what to send, into measurement. It only
/// composes requests and judges answers; sending, waiting and repeating are the caller's.
class XsensSetup {
 public:
  explicit XsensSetup(const Imu::Settings& settings) : settings_(settings) {}

  /// Back to the first request.
  void begin();
  [[nodiscard]] bool done() const;
  /// The message to send now. Not after done().
  [[nodiscard]] base::Bytes request() const;
  /// What the current request is, for messages to the user.
  [[nodiscard]] std::string_view request_name() const;
  /// Moves on if `message` is the answer that is waited for; any other is ignored. Returns whether it was. Error
  /// `device` if the answer is malformed or offers another rate (by more than 1 %) than was asked for.
  [[nodiscard]] base::Result<bool> take(const XbusMessage& message);
  /// Complete once done().
  [[nodiscard]] const ImuIdentity& identity() const { return identity_; }

 private:
  [[nodiscard]] base::Status take_answer(Mid request, std::span<const std::uint8_t> data);
  [[nodiscard]] base::Status check_offer(std::span<const std::uint8_t> data) const;

  Imu::Settings settings_;
  std::size_t step_ = 0;
  ImuIdentity identity_;
};

}  // namespace soak::hal::imu
