// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/result.h"
#include "hal/devices/devices.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

/// How to reach a controller that answers lines of text with lines of text. Times are host time.
struct TextLinkSettings {
  std::variant<TcpAddress, SerialAddress> address;
  std::string prefix;             ///< sent before each command: an address on a bus
  std::string line_end = "\r\n";  ///< of commands and answers
  double response_timeout_s = 3.0;
  double gap_s = 0.0;   ///< pause before each command
  double poll_s = 1.0;  ///< process time between readings
};

/// Where a value stands in the answer to a command.
struct TextField {
  std::string ask;            ///< the command
  std::optional<int> fields;  ///< that the answer must have; absent = `field` at least
  int field = 1;              ///< counted from 1, separated by commas
};

/// One named value of the controller: a number, or one of a few words.
struct TextQuantity {
  TextField from;
  std::vector<std::pair<std::string, std::string>> words;  ///< code and the word that stands for it; empty = a number
  std::string write;                                       ///< command with {} for the value; empty = read only
  int decimals = 1;                                        ///< of a number that is written
  std::optional<double> min;                               ///< of the value, for writing
  std::optional<double> max;

  /// Number of the code in `words`; nothing where there is none of that name.
  [[nodiscard]] std::optional<int> code(std::string_view name) const;
};

/// A command whose answer must be known after connecting.
struct TextProbe {
  std::string name;
  TextField from;
  std::vector<std::string> expected;  ///< any of these
  std::string otherwise;              ///< what to tell the operator if it is something else
};

/// An alarm is active while the field holds none of `inactive`.
struct TextAlarm {
  std::string name;
  TextField from;
  std::vector<std::string> inactive;
  bool outputs_off = false;
};

/// A command whose answer says whether the command before it, which has no answer of its own, was accepted.
struct TextConfirm {
  std::string ask;
  std::vector<std::string> accepted;  ///< beginnings of answers that accept it
};

/// A controller of a chamber or of unit power that speaks lines of text, as data: docs/register-maps.md describes the
/// file.
struct TextMap {
  std::string name;
  std::string kind = "chamber";  ///< chamber, power
  std::string file;
  TextLinkSettings link;
  std::vector<std::string> refusals;   ///< beginnings of answers that refuse a command
  std::optional<TextConfirm> confirm;  ///< where commands that write are not answered
  std::map<std::string, TextQuantity> quantities;
  std::vector<TextProbe> probes;
  std::map<std::string, std::vector<ActionStep>> actions;
  std::vector<TextAlarm> alarms;
  WritePolicy write_policy;
};

/// Reads a text map, as parse_register_map() does a register map: all mistakes at once, each with its line.
[[nodiscard]] base::Result<TextMap> parse_text_map(std::string_view text, const std::string& file,
                                                   MapUse use = MapUse::any);

/// Refuse (bad_input) a map of another kind, or one that lacks a quantity which every device of the kind needs. Nothing
/// is opened yet.
[[nodiscard]] base::Result<std::unique_ptr<Chamber>> make_text_chamber(const TextMap& map);
[[nodiscard]] base::Result<std::unique_ptr<UnitPower>> make_text_power(const TextMap& map);

}  // namespace soak::hal
