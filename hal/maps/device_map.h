// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/result.h"
#include "hal/maps/fixture_axes.h"

namespace soak::hal {

struct ModbusTcp {
  std::string host;
  int port = 502;
};
struct ModbusRtu {
  std::string device;
  int baud = 9600;
  char parity = 'N';
  int stop_bits = 1;
};

/// How to reach the controller and how fast it may be asked. Times are host time.
struct ModbusLinkSettings {
  std::variant<ModbusTcp, ModbusRtu> address;
  int unit = 1;
  double response_timeout_s = 1.0;
  std::optional<double> gap_s;  ///< pause before each request; absent = 0.03 s on a serial line, none over TCP
  int max_block = 32;           ///< registers per request
  double poll_s = 1.0;          ///< process time between readings
};

enum class RegisterType : std::uint8_t { u16, i16, f32 };
enum class WordOrder : std::uint8_t { low_first, high_first };

/// One named value of the controller.
struct Quantity {
  int address = 0;  ///< PDU address, from 0
  RegisterType type = RegisterType::u16;
  WordOrder word_order = WordOrder::low_first;
  double scale = 1.0;                    ///< value = scale · number
  std::optional<int> decimals_register;  ///< then value = scale · number · 10^-(content of that register)
  int read_function = 3;                 ///< 3 or 4
  std::optional<int> write_function;     ///< 6 or 16; absent = read only
  std::optional<double> min;             ///< of the value, for writing
  std::optional<double> max;
  std::map<std::string, int> codes;  ///< names of an enumeration's numbers
  bool command = false;              ///< takes commands: written whatever it holds, never read
};

enum class LinkKind : std::uint8_t { tcp, rtu };

/// A register that must hold a known number after connecting: another means another controller or another setting.
struct Probe {
  std::string name;
  int address = 0;
  RegisterType type = RegisterType::u16;
  std::vector<int> expected;     ///< any of these
  std::string otherwise;         ///< what to tell the operator if it holds something else
  std::optional<LinkKind> link;  ///< asked over such a link alone; absent = over any
};

/// One write of a sequence.
struct ActionStep {
  std::string quantity;
  double value = 0.0;
  double delay_s = 0.0;  ///< afterwards
};

/// Holding registers that tell of an alarm. It is active while one of them says so: by holding none of `inactive`, or
/// one of `active`, or a set bit of `mask`, whichever of the three is given.
struct AlarmRule {
  std::string name;
  std::vector<int> addresses;
  std::vector<int> inactive;
  std::vector<int> active;
  std::optional<int> mask;
  bool outputs_off = false;
};

struct WritePolicy {
  bool only_on_change = true;
  bool read_back = true;
};

/// A controller as data: docs/register-maps.md describes the file.
struct RegisterMap {
  std::string name;
  std::string kind;  ///< chamber, fixture, power
  std::string file;
  ModbusLinkSettings link;
  std::map<std::string, Quantity> quantities;
  std::vector<Probe> probes;
  std::map<std::string, std::vector<ActionStep>> actions;
  std::vector<AlarmRule> alarms;
  WritePolicy write_policy;
  std::vector<std::string> positions;  ///< of a fixture: label of position code 1, 2, ..., or of a pair of angles
  std::vector<double> azimuths_deg;    ///< of those positions, as calib::Position says; empty = not known
  std::optional<FixtureAxes> axes;     ///< of a fixture that is told angles; absent = position codes
};

/// What a register map must have beyond being sound in itself.
enum class MapUse : std::uint8_t {
  any,    ///< nothing
  device  ///< all that a device of the map's kind needs (device_needs())
};

/// Reads a register map. All mistakes at once, one per line of the message, each with "`file`:line" (a syntax error:
/// the first one, and so is a name given twice): unknown keys, quantities and actions that no device of the kind uses,
/// wrong types, values out of their limits, codes and numbers that their register cannot hold, an action that names
/// what the file does not define; of a fixture's [axes] whatever it lacks, and angles beyond their limits or of another
/// position than they are said to be. A file with `protocol = "text"` is refused: hal/maps/text_map.h reads those.
[[nodiscard]] base::Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                                           MapUse use = MapUse::any);
[[nodiscard]] base::Result<RegisterMap> read_register_map(const std::string& file);

}  // namespace soak::hal
