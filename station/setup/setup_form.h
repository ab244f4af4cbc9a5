// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace soak::station {

/// Port of a Modbus controller for which none is entered.
inline constexpr int kModbusPort = 502;

/// Where a device is reached, as somebody has entered it. What is absent the configuration says by default.
struct EnteredAddress {
  std::optional<std::string> device;  ///< a serial port; absent = over TCP
  std::optional<int> baud;            ///< of `device`
  std::string host;                   ///< where there is no `device`
  std::optional<int> port;            ///< of `host`
};

/// A chamber's or a fixture's controller.
struct EnteredController {
  std::string map;  ///< file of its register map
  EnteredAddress address;
  std::optional<int> unit;            ///< Modbus unit number; this and the next two of Modbus only
  std::optional<std::string> parity;  ///< of a serial line: "N", "E", "O"
  std::optional<int> stop_bits;       ///< of a serial line
};

/// What switches the units on and off: the first of the three that is there.
struct EnteredPower {
  std::optional<std::string> from;                   ///< "chamber": outputs of its controller
  std::optional<std::vector<std::string>> usb_hubs;  ///< the ports that these are plugged into
  EnteredController controller;                      ///< relays, or a supply
};

/// A place for a unit.
struct EnteredSlot {
  std::string name;
  EnteredAddress address;
  std::string unit;                 ///< its serial number; empty = given when a campaign starts
  std::optional<int> power_output;  ///< of the power switch; absent = switched by hand
  std::optional<double> supply_v;   ///< what that output is set to, as the next one
  std::optional<double> supply_limit_a;
};

/// Where the station stands, as far as it is known: it decides how much gravity there is.
struct EnteredSite {
  std::optional<double> latitude_deg;
  std::optional<double> height_m;
  std::optional<double> gravity_mps2;
};

/// The room, as far as somebody has said.
struct EnteredRoom {
  std::optional<double> temp_c;
  std::optional<double> dew_point_c;
};

/// A mail server.
struct EnteredMail {
  std::string host;
  std::string security;  ///< "starttls", "tls", "none"
  std::optional<int> port;
  std::string from;
  std::vector<std::string> to;
  std::string user;                ///< empty = the server asks for none
  std::string password;            ///< never in a text of the configuration: setup_secrets.h
  std::string password_file = {};  ///< that holds it, as the configuration names it; empty = the usual one
};

/// A webhook. Its address may be a secret, and is kept as one.
struct EnteredWebhook {
  std::string url;
  std::string token;            ///< empty = none
  std::string url_file = {};    ///< as password_file of mail
  std::string token_file = {};  ///< the same
  bool url_is_open = false;     ///< it stands in the configuration itself, where somebody has written it
};

/// What somebody has entered who sets up a station.
struct SetupForm {
  EnteredController chamber;
  std::optional<EnteredController> fixture;  ///< absent = units are turned by hand
  std::optional<EnteredPower> power;         ///< absent = units are switched by hand
  std::optional<double> purge_below_c;       ///< absent = dry air is never asked for
  std::string unit_type;                     ///< of all slots
  std::string decoder;                       ///< of all slots: the units' protocol
  std::vector<EnteredSlot> slots;
  std::optional<EnteredSite> site;  ///< absent = standard gravity is assumed
  std::optional<EnteredRoom> room;  ///< absent = its temperature and its dew point are assumed
  std::optional<EnteredMail> mail;  ///< absent = nobody is told of alarms by mail
  std::optional<EnteredWebhook> webhook;
};

/// A configuration, or a part of one, with what was entered into which line.
struct SetupText {
  std::string toml;
  /// Of each line the member of POST /api/v1/setup/check that it says: "chamber.host", "slots.0.device", of the head of
  /// a section "chamber", "slots.0"; empty where a line says none.
  std::vector<std::string> fields;
};

/// A text within double quotes as TOML reads it back, whatever is in it: always one line.
[[nodiscard]] std::string toml_quoted(std::string_view text);

/// The configuration of the station (docs/station-config.md).
[[nodiscard]] SetupText setup_text(const SetupForm& form);

/// The section of one controller alone: `section` is "chamber", "fixture" or "power".
[[nodiscard]] SetupText controller_text(std::string_view section, const EnteredController& controller);

/// The slots alone.
[[nodiscard]] SetupText slots_text(const SetupForm& form);

/// Who is told of alarms alone.
[[nodiscard]] SetupText alarms_text(const SetupForm& form);

}  // namespace soak::station
