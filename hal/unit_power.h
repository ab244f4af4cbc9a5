// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/result.h"

namespace soak::hal {

/// What switches the supply of the units, output by output. The rules of Chamber's calls hold.
class UnitPower {
 public:
  UnitPower() = default;
  UnitPower(const UnitPower&) = delete;
  UnitPower& operator=(const UnitPower&) = delete;
  virtual ~UnitPower() = default;

  [[nodiscard]] virtual base::Status connect() = 0;
  /// Outputs are numbered from 1. Read back.
  [[nodiscard]] virtual base::Status set(int output, bool on) = 0;
  [[nodiscard]] virtual base::Result<bool> is_on(int output) = 0;
  [[nodiscard]] virtual std::string description() const = 0;
};

}  // namespace soak::hal
