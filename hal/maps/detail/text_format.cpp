// SPDX-License-Identifier: Apache-2.0
// What a text map has that a register map has not: commands, the fields of their answers, words.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "hal/maps/detail/map_format.h"

namespace soak::hal {
namespace {

using settings::Table;

constexpr settings::Limits kFieldLimits{1, 64};

/// A text that goes over the wire: a control character in it would end the line early.
std::string read_line_of_text(const Table& table, std::string_view key, const std::optional<std::string>& fallback) {
  std::string text = table.text(key, fallback);
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!printable) table.refuse(key, fmt::format("'{}' must be printable ASCII", key));
  if (!fallback && table.has(key) && text.empty()) table.refuse(key, fmt::format("'{}' is empty", key));
  return text;
}

LinkSettings read_text_link(const Table& link) {
  LinkSettings settings;
  const bool serial = link.has("serial");
  if (serial == link.has("tcp")) link.refuse("", "'link' needs either 'tcp' or 'serial'");
  if (serial) settings.address = read_serial_line(link, "serial", {4800, 9600, 19200, 38400, 57600, 115200});
  if (link.has("tcp")) settings.address = read_host_port(link);
  settings.prefix = read_line_of_text(link, "prefix", "");
  settings.line_end =
      link.choice<std::string>("line_end", {{"\r\n", "\r\n"}, {"\r", "\r"}, {"\n", "\n"}}, settings.line_end);
  settings.response_timeout_s = link.number("response_timeout_s", {0.05, 30.0}, 3.0);
  settings.gap_s = link.number("gap_s", {0.0, 0.5}, 0.0);
  settings.poll_s = link.number("poll_s", {0.1, 60.0}, settings.poll_s);
  settings.second_connection = link.flag("second_connection", settings.second_connection);
  return settings;
}

TextField read_field(const Table& table) {
  TextField from;
  from.ask = read_line_of_text(table, "ask", {});
  from.fields = table.optional_whole("fields", kFieldLimits);
  from.field = table.whole("field", kFieldLimits, from.field);
  if (from.fields && from.field > *from.fields) table.refuse("field", "'field' is greater than 'fields'");
  return from;
}

/// The words in the order of the text; their numbers by the names of the codes.
void read_words(const Table& table, Quantity& quantity) {
  const auto words = table.table("words");
  if (!words) return;
  std::set<std::string> seen;
  for (const std::string& code : words->keys()) {
    const std::string word = read_line_of_text(*words, code, {});
    quantity.codes[code] = static_cast<int>(quantity.text.words.size());
    quantity.text.words.push_back(word);
    if (!seen.insert(word).second) words->refuse(code, fmt::format("two codes have the word '{}'", word));
  }
  if (seen.empty()) table.refuse("words", "'words' names no code");
}

Quantity read_text_quantity(const Table& table) {
  Quantity quantity;
  quantity.text.from = read_field(table);
  read_words(table, quantity);
  quantity.text.write = read_line_of_text(table, "write", "");
  quantity.text.decimals = table.whole("decimals", {0, 6}, quantity.text.decimals);
  read_write_limits(table, quantity);
  if (quantity.writable() && quantity.text.write.find("{}") == std::string::npos) {
    table.refuse("write", "'write' must show with {} where the value goes");
  }
  for (const char* key : {"min", "max", "decimals"}) {
    if (!table.has(key)) continue;
    if (!quantity.writable()) {
      table.refuse(key, fmt::format("'{}' belongs to a write, but there is no 'write'", key));
    } else if (!quantity.text.words.empty()) {
      table.refuse(key, fmt::format("'{}' belongs to a number, not to 'words'", key));
    }
  }
  return quantity;
}

std::vector<std::string> read_known_texts(const Table& table, std::string_view key) {
  std::vector<std::string> texts = table.texts(key, settings::kRequired);
  if (table.has(key) && texts.empty()) table.refuse(key, fmt::format("'{}' names no text", key));
  return texts;
}

void read_text_probe(const Table& table, Probe& probe) {
  probe.text.from = read_field(table);
  probe.text.expected = read_known_texts(table, "expected");
}

void read_text_alarm(const Table& table, AlarmRule& rule) {
  rule.text.from = read_field(table);
  rule.text.inactive = read_known_texts(table, "inactive");
}

bool text_holds(const Quantity& quantity, double value) {
  const auto& words = quantity.text.words;
  if (words.empty()) return true;
  return value >= 0.0 && value < static_cast<double>(words.size()) && value == static_cast<int>(value);
}

/// Beginnings of answers: an empty one would begin every answer.
void read_text_root(const Table& root, DeviceMap& map) {
  const auto refuse_empty = [](const Table& table, std::string_view key, const std::vector<std::string>& beginnings) {
    if (std::find(beginnings.begin(), beginnings.end(), "") == beginnings.end()) return;
    table.refuse(key, "an empty text would match every answer");
  };
  map.refusals = root.texts("refusals");
  refuse_empty(root, "refusals", map.refusals);
  if (const auto table = root.table("confirm")) {
    map.confirm = TextConfirm{read_line_of_text(*table, "ask", {}), read_known_texts(*table, "accepted")};
    refuse_empty(*table, "accepted", map.confirm->accepted);
  }
}

}  // namespace

const MapFormat& text_format() {
  static const MapFormat format = {MapProtocol::text,
                                   {{"chamber", "chamber"}, {"power", "power"}},
                                   read_text_link,
                                   read_text_quantity,
                                   read_text_probe,
                                   read_text_alarm,
                                   text_holds,
                                   read_text_root,
                                   "write"};
  return format;
}

}  // namespace soak::hal
