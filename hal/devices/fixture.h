// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

struct FixtureReading {
  bool moving = false;                  ///< on its way, or turning at a rate
  std::optional<std::string> position;  ///< label of the position that it stands in
  /// Of a fixture that can spin(): its rate as spin() counts it, once it is steady.
  std::optional<double> rate_dps;
  std::string angles;  ///< where its axes stand, for messages; empty where it does not say
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
  /// Begins to turn; read() tells when it has come there. One that turns at a rate is halted first: until it stands the
  /// call fails (device), to be tried again.
  [[nodiscard]] virtual base::Status move_to(std::string_view label) = 0;
  [[nodiscard]] virtual base::Result<FixtureReading> read() = 0;
  [[nodiscard]] virtual std::string description() const = 0;

  /// Whether spin() may be asked for that: refuses (bad_input) a position in which this fixture cannot turn steadily
  /// about the vertical (most fixtures can in none) and a rate beyond its map's limits. Asks nothing of the device.
  [[nodiscard]] virtual base::Status can_spin(std::string_view label, double rate_dps) const;
  /// Begins to turn at `rate_dps`, counter-clockwise seen from above, from the position `label` in which it stands or
  /// turns already; read() tells when the rate is steady. Refuses what can_spin() refuses, and (device) a fixture that
  /// stands otherwise.
  [[nodiscard]] virtual base::Status spin(std::string_view label, double rate_dps) { return can_spin(label, rate_dps); }
  /// Ends the turning at a rate; read() tells when it stands. Of one that does not turn so nothing is asked.
  [[nodiscard]] virtual base::Status halt() { return {}; }
};

/// Refuses (bad_input) a map of another kind, or one that lacks what every fixture needs. Nothing is opened yet.
[[nodiscard]] base::Result<std::unique_ptr<Fixture>> make_fixture(const DeviceMap& map);

}  // namespace soak::hal
