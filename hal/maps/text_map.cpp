// SPDX-License-Identifier: Apache-2.0
#include "hal/maps/text_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "hal/maps/detail/action_reader.h"
#include "hal/maps/detail/address_reader.h"
#include "hal/maps/detail/text_needs.h"
#include "hal/maps/detail/vocabulary.h"
#include "settings/reader.h"

namespace soak::hal {
namespace {

constexpr Limits kAnyNumber{-1e9, 1e9};
constexpr Limits kFieldLimits{1, 64};

/// A text that goes over the wire: a control character in it would end the line early.
std::string read_command(const SettingsTable& table, std::string_view key, const std::optional<std::string>& fallback) {
  std::string text = table.text(key, fallback);
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!printable) table.refuse(key, fmt::format("'{}' must be printable ASCII", key));
  if (!fallback && table.has(key) && text.empty()) table.refuse(key, fmt::format("'{}' is empty", key));
  return text;
}

SerialAddress read_serial(const SettingsTable& link) {
  const std::vector<int> bauds = {4800, 9600, 19200, 38400, 57600, 115200};
  SerialAddress address;
  address.device = link.text("serial");
  if (link.has("serial") && address.device.empty()) link.refuse("serial", "'link.serial' must name a serial device");
  address.baud = link.whole("baud", kAnyNumber, 9600);
  if (std::find(bauds.begin(), bauds.end(), address.baud) == bauds.end()) {
    link.refuse("baud", fmt::format("'link.baud' must be one of {}", fmt::join(bauds, ", ")));
  }
  return address;
}

TextLinkSettings read_text_link(const SettingsTable& link) {
  TextLinkSettings settings;
  const bool serial = link.has("serial");
  if (serial == link.has("tcp")) link.refuse("", "'link' needs either 'tcp' or 'serial'");
  if (serial) settings.address = read_serial(link);
  if (link.has("tcp")) settings.address = read_host_port(link, "tcp");
  settings.prefix = read_command(link, "prefix", "");
  settings.line_end =
      link.choice<std::string>("line_end", {{"\r\n", "\r\n"}, {"\r", "\r"}, {"\n", "\n"}}, settings.line_end);
  settings.response_timeout_s = link.number("response_timeout_s", {0.05, 30.0}, settings.response_timeout_s);
  settings.gap_s = link.number("gap_s", {0.0, 0.5}, settings.gap_s);
  settings.poll_s = link.number("poll_s", {0.1, 60.0}, settings.poll_s);
  return settings;
}

TextField read_field(const SettingsTable& table) {
  TextField from;
  from.ask = read_command(table, "ask", {});
  from.fields = table.optional_whole("fields", kFieldLimits);
  from.field = table.whole("field", kFieldLimits, from.field);
  if (from.fields && from.field > *from.fields) table.refuse("field", "'field' is beyond 'fields'");
  return from;
}

std::vector<std::pair<std::string, std::string>> read_words(const SettingsTable& quantity) {
  std::vector<std::pair<std::string, std::string>> words;
  const auto table = quantity.table("words");
  if (!table) return words;
  std::set<std::string> seen;
  for (const std::string& code : table->keys()) {
    words.emplace_back(code, read_command(*table, code, {}));
    if (!seen.insert(words.back().second).second) {
      table->refuse(code, fmt::format("two codes have the word '{}'", words.back().second));
    }
  }
  if (words.empty()) quantity.refuse("words", "'words' names no code");
  return words;
}

void check_write(const SettingsTable& table, const TextQuantity& quantity) {
  if (quantity.write.empty()) {
    for (const char* key : {"min", "max", "decimals"}) {
      if (table.has(key)) table.refuse(key, fmt::format("'{}' belongs to a write, but there is no 'write'", key));
    }
  } else if (quantity.write.find("{}") == std::string::npos) {
    table.refuse("write", "'write' must say with {} where the value stands");
  }
  if (quantity.min && quantity.max && *quantity.min > *quantity.max) table.refuse("min", "'min' is above 'max'");
  if (quantity.words.empty()) return;
  for (const char* key : {"min", "max", "decimals"}) {
    if (table.has(key)) table.refuse(key, fmt::format("'{}' belongs to a number, not to 'words'", key));
  }
}

TextQuantity read_quantity(const SettingsTable& table) {
  constexpr Limits decimals{0, 6};
  TextQuantity quantity;
  quantity.from = read_field(table);
  quantity.words = read_words(table);
  quantity.write = read_command(table, "write", "");
  quantity.decimals = table.whole("decimals", decimals, quantity.decimals);
  quantity.min = table.optional_number("min", kAnyNumber);
  quantity.max = table.optional_number("max", kAnyNumber);
  check_write(table, quantity);
  return quantity;
}

std::vector<std::string> read_known_texts(const SettingsTable& table, std::string_view key) {
  std::vector<std::string> texts = table.texts(key, true);
  if (table.has(key) && texts.empty()) table.refuse(key, fmt::format("'{}' names no text", key));
  return texts;
}

TextProbe read_probe(const SettingsTable& table) {
  TextProbe probe;
  probe.name = table.text("name");
  probe.from = read_field(table);
  probe.expected = read_known_texts(table, "expected");
  probe.otherwise = table.text("otherwise");
  return probe;
}

std::vector<TextAlarm> read_alarms(const SettingsTable& root) {
  std::vector<TextAlarm> alarms;
  std::set<std::string> names;
  for (const SettingsTable& table : root.tables("alarm")) {
    TextAlarm& alarm = alarms.emplace_back();
    alarm.name = table.text("name");
    alarm.from = read_field(table);
    alarm.inactive = read_known_texts(table, "inactive");
    alarm.outputs_off = table.flag("outputs_off", false);
    if (!names.insert(alarm.name).second) table.refuse("name", fmt::format("alarm '{}' occurs twice", alarm.name));
  }
  return alarms;
}

std::optional<StepTarget> step_target(const TextMap& map, const std::string& name) {
  const auto found = map.quantities.find(name);
  if (found == map.quantities.end()) return std::nullopt;
  const TextQuantity& quantity = found->second;
  StepTarget target{!quantity.write.empty(), "write", quantity.min, quantity.max, {}, [](double) { return true; }};
  for (const auto& [code, word] : quantity.words) target.codes[code] = *quantity.code(code);
  if (!quantity.words.empty()) {
    target.fits = [codes = quantity.words.size()](double value) {
      return value >= 0.0 && value < static_cast<double>(codes) && value == static_cast<int>(value);
    };
  }
  return target;
}

void check_names(const SettingsTable& quantities, const TextMap& map) {
  const std::set<std::string> acted_on = written_by(map.actions);
  for (const auto& [name, quantity] : map.quantities) {
    if (asks_for(map.kind, name) || acted_on.contains(name)) continue;
    quantities.refuse(name, fmt::format("a device of kind \"{}\" does not use the quantity '{}', nor does an action",
                                        map.kind, name));
  }
}

/// What does not begin so is a refusal: an empty text would accept everything.
std::optional<TextConfirm> read_confirm(const SettingsTable& root) {
  const auto table = root.table("confirm");
  if (!table) return std::nullopt;
  TextConfirm confirm{read_command(*table, "ask", {}), read_known_texts(*table, "accepted")};
  if (std::find(confirm.accepted.begin(), confirm.accepted.end(), "") != confirm.accepted.end()) {
    table->refuse("accepted", "an empty text begins every answer");
  }
  return confirm;
}

WritePolicy read_policy(const SettingsTable& root) {
  WritePolicy policy;
  if (const auto table = root.table("write_policy")) {
    policy.only_on_change = table->flag("only_on_change", policy.only_on_change);
    policy.read_back = table->flag("read_back", policy.read_back);
  }
  return policy;
}

TextMap read_map(const SettingsTable& root, MapUse use) {
  TextMap map;
  map.name = root.text("name");
  (void)root.choice<bool>("protocol", {{"text", true}});
  map.kind = root.choice<std::string>("kind", {{"chamber", "chamber"}, {"power", "power"}});
  map.refusals = root.texts("refusals");
  if (std::find(map.refusals.begin(), map.refusals.end(), "") != map.refusals.end()) {
    root.refuse("refusals", "an empty text begins every answer");
  }
  if (const auto link = root.table("link", true)) map.link = read_text_link(*link);
  map.confirm = read_confirm(root);
  const auto quantities = root.table("quantity", true);
  if (quantities) {
    for (const std::string& name : quantities->keys()) {
      if (const auto table = quantities->table(name)) map.quantities[name] = read_quantity(*table);
    }
  }
  for (const SettingsTable& probe : root.tables("probe")) map.probes.push_back(read_probe(probe));
  const std::set<std::string> actions = map.kind == "chamber" ? chamber_vocabulary().actions : std::set<std::string>();
  map.actions =
      read_actions(root, map.kind, actions, [&map](const std::string& quantity) { return step_target(map, quantity); });
  if (quantities && !map.kind.empty()) check_names(*quantities, map);
  map.alarms = read_alarms(root);
  map.write_policy = read_policy(root);
  const auto needs = use == MapUse::device ? text_needs(map) : std::vector<std::string>();
  if (!needs.empty()) root.refuse("kind", fmt::format("{}", fmt::join(needs, "; ")));
  return map;
}

}  // namespace

std::optional<int> TextQuantity::code(std::string_view name) const {
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& word) { return word.first == name; });
  if (found == words.end()) return std::nullopt;
  return static_cast<int>(found - words.begin());
}

base::Result<TextMap> parse_text_map(std::string_view text, const std::string& file, MapUse use) {
  const auto reader = SettingsReader::parse(text, file);
  if (!reader) return base::forward_error(reader);
  TextMap map = read_map(reader->root(), use);
  if (auto status = reader->finish(); !status) return base::forward_error(status);
  map.file = file;
  return map;
}

}  // namespace soak::hal
