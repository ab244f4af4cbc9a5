// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/devices/chamber.h"

namespace soak::hal {

/// Values by the names of their quantities.
using Values = std::map<std::string, double, std::less<>>;

/// A controller of a chamber or of unit power by named quantities, actions and alarms, whatever it speaks. Names must
/// be in its map. Each call opens the link if it is closed and proves the map's probes before it trusts a value. Errors
/// are of kind `device` with map and address as their place.
class QuantityAccess {
 public:
  struct Range {
    std::optional<double> min;
    std::optional<double> max;
  };

  QuantityAccess() = default;
  QuantityAccess(const QuantityAccess&) = delete;
  QuantityAccess& operator=(const QuantityAccess&) = delete;
  virtual ~QuantityAccess() = default;

  [[nodiscard]] virtual bool has(std::string_view quantity) const = 0;
  [[nodiscard]] virtual bool has_action(std::string_view action) const = 0;
  /// Limits of what may be written.
  [[nodiscard]] virtual Range range(const std::string& quantity) const = 0;
  [[nodiscard]] virtual bool has_code(const std::string& quantity, const std::string& name) const = 0;
  /// The number that stands for a code of the quantity, which must have it.
  [[nodiscard]] virtual double code(const std::string& quantity, const std::string& name) const = 0;
  /// Where the controller keeps the quantity, for messages: "register 2820".
  [[nodiscard]] virtual std::string place(const std::string& quantity) const = 0;
  /// Map and address.
  [[nodiscard]] virtual std::string description() const = 0;

  [[nodiscard]] virtual base::Status connect() = 0;
  [[nodiscard]] virtual base::Result<Values> read_all(const std::vector<std::string>& names) = 0;
  [[nodiscard]] virtual base::Result<std::vector<ChamberAlarm>> active_alarms() = 0;
  /// Writes by the map's policy. Refuses (bad_input) a value beyond the map's limits.
  [[nodiscard]] virtual base::Status write(const std::string& name, double value) = 0;
  [[nodiscard]] virtual base::Status run(const std::string& action) = 0;
  /// Waits a few tenths of a second for a quantity to become `value`.
  [[nodiscard]] virtual base::Status expect(const std::string& name, double value) = 0;
};

/// An error of this controller.
[[nodiscard]] inline tl::unexpected<base::Error> device_fault(const QuantityAccess& access, std::string message) {
  return base::fail(base::ErrorKind::device, std::move(message), access.description());
}

}  // namespace soak::hal
