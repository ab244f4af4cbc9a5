// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/position.h"
#include "calib/vocabulary/run.h"
#include "calib/vocabulary/unit_type.h"
#include "hal/devices/chamber.h"
#include "hal/devices/fixture.h"
#include "hal/devices/unit_power.h"
#include "hal/imu/imu.h"
#include "hal/links/addresses.h"
#include "hal/maps/device_map.h"
#include "station/config/alarm_config.h"

namespace soak::station {

/// A place for one unit on the fixture.
struct Slot {
  std::string name;
  hal::UnitAddress address;
  hal::UnitDecoder decoder = hal::UnitDecoder::xsens;
  /// Fixture directions of the unit's own axes x, y, z ("+X" "+Y" "+Z" = mounted straight): right-handed.
  std::array<std::string, 3> axes = {"+X", "+Y", "+Z"};
  std::optional<int> power_output;  ///< of the unit power; absent = not switched by us
  hal::SupplySettings supply;       ///< what that output shall deliver
  std::string unit;                 ///< serial number that stands here; empty = given when a campaign starts
  std::string unit_type;            ///< of a unit that the catalog does not know yet
};

/// Units are switched by people, when asked.
struct PowerByHand {};
/// Outputs of the chamber's controller feed the units, over its link.
struct PowerFromChamber {};
/// What switches the units; a map is that of a device of its own.
using UnitPowerSource = std::variant<PowerByHand, PowerFromChamber, hal::DeviceMap, hal::UsbHubs>;

/// The file that `soakd --config` reads: docs/station-config.md describes it.
struct StationConfig {
  std::string file;
  std::string listen = "127.0.0.1:8088";
  std::vector<std::string> allowed_hosts;  ///< names by which browsers may ask for it, in small letters
  std::filesystem::path tls_certificate;   ///< PEM; empty = soakd makes one where it needs one
  std::filesystem::path tls_key;           ///< of tls_certificate
  double clock_rate = 1.0;
  std::filesystem::path data;             ///< empty = as for `soak`
  std::filesystem::path unit_types;       ///< folder of unit types
  hal::DeviceMap chamber;                 ///< map file, its link replaced by the station's
  std::optional<hal::DeviceMap> fixture;  ///< absent = turned by hand
  UnitPowerSource power;
  std::optional<double> purge_below_c;  ///< dry air must flow before the chamber goes below
  std::vector<Slot> slots;
  calib::Site site;
  double dew_point_c = 15.0;      ///< of the room
  bool dew_point_assumed = true;  ///< nobody has stated it
  double room_c = 25.0;
  AlarmConfig alarms;  ///< who is told of what needs somebody
};

/// Reads the configuration with the register maps that it names (paths relative to it). All mistakes at once, one per
/// line, each with "`file`:line": unknown keys, wrong types, two slots of one name, address, power output or unit, axes
/// that are not right-handed...
[[nodiscard]] base::Result<StationConfig> read_station_config(const std::filesystem::path& file);

/// The same of a text that is, or is to be, that of `file`.
[[nodiscard]] base::Result<StationConfig> parse_station_config(std::string_view text,
                                                               const std::filesystem::path& file);

/// The controller, the slots, or who is told of alarms, of a text that holds no other part of a configuration: as far
/// as somebody has come who sets up a station. `kind`: of the controller, "chamber", "fixture" or "power".
[[nodiscard]] base::Result<hal::DeviceMap> parse_controller(std::string_view text, std::string_view kind,
                                                            const std::filesystem::path& file);
[[nodiscard]] base::Result<std::vector<Slot>> parse_slots(std::string_view text, const std::filesystem::path& file);
[[nodiscard]] base::Result<AlarmConfig> parse_alarms(std::string_view text, const std::filesystem::path& file);

/// The configuration where place_of_config() finds it, with the data folder filled in: that of `data_option` (--data)
/// where given, else the configuration's, else as for `soak`.
[[nodiscard]] base::Result<StationConfig> find_station_config(const std::filesystem::path& file,
                                                              std::string_view data_option);

/// How the unit of that type in the slot is talked to. An AHRS400 needs both ranges of its type.
[[nodiscard]] hal::UnitLink link_of(const Slot& slot, const calib::UnitType& type);

/// The unit's position when the fixture stands with `fixture_up` (a label of the six) upwards: label and up vector in
/// the unit's own axes; both empty where the label is none of the six. `azimuth_deg`: the fixture's own in that
/// position; the unit's is that of its own axis after the vertical one. `lean_deg`: as DeviceMap::leans_deg.
[[nodiscard]] calib::Position unit_position(const Slot& slot, std::string_view fixture_up,
                                            std::optional<double> azimuth_deg = {},
                                            const std::array<double, 2>& lean_deg = {});

/// The positions of a unit in the slot of which the fixture's register map gives more than a label: azimuth or lean.
[[nodiscard]] std::vector<calib::Position> positions_of(const Slot& slot, const StationConfig& config);

}  // namespace soak::station
