// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::hal {

struct FixtureReading {
  bool moving = false;
  std::optional<std::string> position;  ///< label of the position that it stands in
};

/// What turns the units. Positions are those of the fixture itself: a unit's own is this turned by its slot. The rules
/// of Chamber's calls hold.
class Fixture {
 public:
  Fixture() = default;
  Fixture(const Fixture&) = delete;
  Fixture& operator=(const Fixture&) = delete;
  virtual ~Fixture() = default;

  [[nodiscard]] virtual base::Status connect() = 0;
  /// Labels that move_to() takes.
  [[nodiscard]] virtual std::vector<std::string> positions() const = 0;
  /// Begins to turn; read() tells when it has come there.
  [[nodiscard]] virtual base::Status move_to(std::string_view label) = 0;
  [[nodiscard]] virtual base::Result<FixtureReading> read() = 0;
  [[nodiscard]] virtual std::string description() const = 0;
};

}  // namespace soak::hal
