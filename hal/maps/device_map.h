// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "hal/links/addresses.h"

/// A controller of a chamber, a fixture or of unit power as data: docs/register-maps.md describes the file.
namespace soak::hal {

/// What a controller speaks. What else differs between the two stands in members called `modbus` and `text`.
enum class MapProtocol : std::uint8_t { modbus, text };

/// How to reach the controller and how fast it may be asked. Times are host time.
struct LinkSettings {
  ControllerAddress address;
  double response_timeout_s = 1.0;
  std::optional<double> gap_s;  ///< pause before each request; absent = 0.03 s on a serial line of Modbus, else none
  double poll_s = 1.0;          ///< process time between readings
  /// Whether a controller that is reached by TCP may be asked over another connection at the same time.
  bool second_connection = false;
  int unit = 1;                   ///< Modbus: number of the device on its bus
  int max_block = 32;             ///< Modbus: registers per request
  std::string prefix;             ///< text: sent before each command, an address on a bus
  std::string line_end = "\r\n";  ///< text: of commands and answers; empty = an answer ends when nothing more comes
  std::string separator = ",";    ///< text: between fields, one character; one beyond ASCII is a byte of Latin-1 there
};

enum class RegisterType : std::uint8_t { u16, i16, f32 };
enum class WordOrder : std::uint8_t { low_first, high_first };

/// Where a controller on Modbus keeps a value.
struct RegisterPlace {
  int address = 0;  ///< PDU address, from 0
  RegisterType type = RegisterType::u16;
  WordOrder word_order = WordOrder::low_first;
  double scale = 1.0;                    ///< value = scale · number
  std::optional<int> decimals_register;  ///< then value = scale · number · 10^-(content of that register)
  int read_function = 3;                 ///< 3 or 4
  std::optional<int> write_function;     ///< 6 or 16; absent = read only
};

/// Where a value stands in the answer to a command.
struct TextField {
  std::string ask;              ///< the command
  std::optional<int> fields;    ///< that the answer must have; absent = `field` at least
  int field = 1;                ///< counted from 1
  int character = 0;            ///< the one that the field consists of, counted from 1 in the answer; 0 = all of it
  std::optional<int> length;    ///< characters that the answer must have; absent = any number
  std::string separator = ",";  ///< between fields; blanks: any number of them
};

/// A value of a controller that speaks lines of text.
struct TextPlace {
  TextField from;
  std::vector<std::string> words;     ///< word n stands for the number n; empty = a number is answered
  std::string write;                  ///< command with {} for the value; empty = read only
  int decimals = 1;                   ///< of a number that is written
  int width = 0;                      ///< of a number that is written: filled up with zeros to so many characters
  std::vector<std::string> accepted;  ///< beginnings of answers that accept a write; empty = any but a refusal
};

/// One named value of the controller.
struct Quantity {
  RegisterPlace modbus;
  TextPlace text;
  std::map<std::string, int> codes;  ///< names of an enumeration's numbers
  std::optional<double> min;         ///< of the value, for writing
  std::optional<double> max;
  bool command = false;  ///< takes commands: written whatever it holds, never read

  [[nodiscard]] bool writable() const { return modbus.write_function || !text.write.empty(); }
};

enum class LinkKind : std::uint8_t { tcp, serial };

struct RegisterProbe {
  int address = 0;
  RegisterType type = RegisterType::u16;
  std::vector<int> expected;  ///< any of these
};

struct TextProbe {
  TextField from;
  std::vector<std::string> expected;  ///< any of these
};

/// What must be known of the controller after connecting: another answer means another controller or another setting.
struct Probe {
  std::string name;
  std::string otherwise;         ///< what to tell the operator if it is something else
  std::optional<LinkKind> link;  ///< asked over such a link alone; absent = over any
  RegisterProbe modbus;
  TextProbe text;
};

/// Holding registers that tell of an alarm. It is active while one of them says so: by holding none of `inactive`, or
/// one of `active`, or a set bit of `mask`, whichever of the three is given.
struct RegisterAlarm {
  std::vector<int> addresses;
  std::vector<int> inactive;
  std::vector<int> active;
  std::optional<int> mask;
};

/// An alarm is active while the field holds none of `inactive`.
struct TextAlarm {
  TextField from;
  std::vector<std::string> inactive;
};

struct AlarmRule {
  std::string name;
  bool outputs_off = false;
  RegisterAlarm modbus;
  TextAlarm text;
};

/// One write of a sequence.
struct ActionStep {
  std::string quantity;
  double value = 0.0;
  double delay_s = 0.0;  ///< afterwards
};

struct WritePolicy {
  bool only_on_change = true;
  bool read_back = true;
};

/// A command whose answer says whether the command before it, which has no answer of its own, was accepted.
struct TextConfirm {
  std::string ask;
  std::vector<std::string> accepted;  ///< beginnings of answers that accept it
};

enum class FixtureAxis : std::uint8_t { outer, inner };

struct AxisAngles {
  double outer_deg = 0.0;
  double inner_deg = 0.0;
};

/// A fixture of two axes that are told angles: the outer one stands still in the room and carries the inner one, which
/// carries the units.
struct FixtureAxes {
  double tolerance_deg = 0.0;          ///< an angle read within it counts as reached
  std::vector<AxisAngles> angles_deg;  ///< of DeviceMap::positions
  std::optional<FixtureAxis> spins;    ///< the axis without an end, which can turn at a rate
  double rate_tolerance_dps = 0.0;
  /// Of those positions, where the axis that spins is vertical: +1 if a positive rate of it is counter-clockwise seen
  /// from above, -1 if clockwise; 0 elsewhere.
  std::vector<int> spin_sign;
};

struct DeviceMap {
  MapProtocol protocol = MapProtocol::modbus;
  std::string name;
  std::string kind;  ///< chamber, fixture (Modbus only), power
  std::string file;
  LinkSettings link;
  std::map<std::string, Quantity> quantities;
  std::vector<Probe> probes;
  std::map<std::string, std::vector<ActionStep>> actions;
  std::vector<AlarmRule> alarms;
  WritePolicy write_policy;
  std::vector<std::string> refusals;   ///< text: beginnings of answers that refuse a command
  std::optional<TextConfirm> confirm;  ///< text: where commands that write are not answered
  std::vector<std::string> positions;  ///< of a fixture: label of position code 1, 2, ..., or of a pair of angles
  std::vector<double> azimuths_deg;    ///< of those positions, as calib::Position says; empty = not known
  /// Of those positions whose up is known better than by its label, degrees by which the true up leans from the label's
  /// direction: towards the fixture's axis that follows it cyclically (x after z), and towards the one after that.
  std::map<std::string, std::array<double, 2>> leans_deg;
  std::optional<FixtureAxes> axes;  ///< of a fixture that is told angles; absent = position codes
};

/// What a map must have beyond being sound in itself.
enum class MapUse : std::uint8_t {
  any,    ///< nothing
  device  ///< all that a device of the map's kind needs
};

/// Reads a map; `protocol` in it says what its controller speaks, Modbus where it is absent. Refuses (bad_input) all
/// mistakes at once, one per line of the message, each with "`file`:line" (a syntax error: the first one, and so is a
/// name given twice): unknown keys, quantities and actions that no device of the kind uses, wrong types, values out of
/// their limits, codes and numbers that their register cannot hold, an action that names what the file does not define;
/// of a fixture's [axes] whatever it lacks, and angles beyond their limits or of another position than they are said to
/// be.
[[nodiscard]] base::Result<DeviceMap> parse_device_map(std::string_view text, const std::string& file,
                                                       MapUse use = MapUse::any);
[[nodiscard]] base::Result<DeviceMap> read_device_map(const std::string& file, MapUse use = MapUse::any);

/// Whether the link is a TCP connection or a serial line.
[[nodiscard]] LinkKind link_kind(const DeviceMap& map);

/// Refuses (bad_input) a map of another kind, or one that lacks what every device of the kind needs.
[[nodiscard]] base::Status require_device(const DeviceMap& map, std::string_view kind);

}  // namespace soak::hal
