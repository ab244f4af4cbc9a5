// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/devices/unit_power.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// An alarm that the chamber's controller reports as active.
struct ChamberAlarm {
  std::string name;
  bool outputs_off = false;  ///< over-temperature and the like: heating and cooling must be switched off at once

  bool operator==(const ChamberAlarm&) const = default;
};

/// What the chamber says of itself at one moment.
struct ChamberReading {
  double air_c = 0.0;
  double set_point_c = 0.0;
  std::optional<double> working_set_point_c;  ///< moves towards the set point while the controller ramps
  std::optional<double> output_percent;       ///< positive heats, negative cools
  std::optional<double> air_rh_percent;       ///< relative humidity of the air
  bool running = false;                       ///< control is on: heating and cooling may be driven
  std::vector<ChamberAlarm> alarms;
};

/// A temperature chamber. A call to one that does not answer blocks for one link time-out, to one that answers late for
/// a few at most (and besides for the delays that the map's actions ask for, 10 s at most, and for the resolver where
/// the address is a name); a fault is an error of kind `device`. A broken link is opened again by the next call, after
/// a pause that grows with the failures (1, 2, 5, 10 s): until then calls fail at once. One thread at a time.
class Chamber {
 public:
  Chamber() = default;
  Chamber(const Chamber&) = delete;
  Chamber& operator=(const Chamber&) = delete;
  virtual ~Chamber() = default;

  /// Opens the link and proves by the map's probes that this is the controller that the map describes.
  [[nodiscard]] virtual base::Status connect() = 0;
  [[nodiscard]] virtual base::Result<ChamberReading> read() = 0;
  /// Gives a new set point, read back. An unchanged one is not written (EEPROM).
  [[nodiscard]] virtual base::Status set_temperature(double temp_c) = 0;
  /// Rate at which the controller's working set point moves; absent = as fast as the chamber can.
  [[nodiscard]] virtual base::Status set_ramp_rate(std::optional<double> rate_kpmin) = 0;
  /// Control on: the chamber drives towards the set point.
  [[nodiscard]] virtual base::Status start() = 0;
  /// Control off: neither heating nor cooling. Written also where the controller says that it is off.
  [[nodiscard]] virtual base::Status stop() = 0;
  /// Set points that the map allows; absent = not stated.
  [[nodiscard]] virtual std::optional<double> min_set_point_c() const = 0;
  [[nodiscard]] virtual std::optional<double> max_set_point_c() const = 0;
  [[nodiscard]] virtual bool can_ramp() const = 0;
  /// What switches units by outputs of the chamber's controller, over the same link: as long-lived as the chamber, same
  /// thread. Null where the map names no such output.
  [[nodiscard]] virtual UnitPower* unit_power() { return nullptr; }
  /// Whether the last call got its answers, be they ones that nobody can believe; false where the link broke.
  [[nodiscard]] virtual bool answers() const { return true; }
  /// Map and address, for messages and logs.
  [[nodiscard]] virtual std::string description() const = 0;
};

/// Refuses (bad_input) a map of another kind, or one that lacks what every chamber needs. Nothing is opened yet.
[[nodiscard]] base::Result<std::unique_ptr<Chamber>> make_chamber(const DeviceMap& map);

/// Whether a chamber can have that reading: a finite number and, for a quantity in °C, one from −150 to 400 that is not
/// as near to 0 as only a float with exchanged words is.
[[nodiscard]] bool is_credible(std::string_view quantity, double value);

}  // namespace soak::hal
