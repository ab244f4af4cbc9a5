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

bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// Whether a text is one printable character of Latin-1 beyond ASCII: U+00A1 to U+00FF, two bytes in UTF-8.
bool is_one_latin_1(std::string_view text) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  if (text.size() != 2) return false;
  return (byte(0) == 0xC2 && byte(1) > 0xA0 && byte(1) < 0xC0) ||
         (byte(0) == 0xC3 && byte(1) >= 0x80 && byte(1) < 0xC0);
}

/// A text that goes over the wire: a control character in it would end the line early. A separator of Latin-1 may stand
/// in it, whichever the link has: the link knows no other (check_separators()).
std::string read_line_of_text(const Table& table, std::string_view key, const std::optional<std::string>& fallback) {
  std::string text = table.text(key, fallback);
  std::string rest;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (is_one_latin_1(std::string_view(text).substr(i, 2))) {
      ++i;
    } else {
      rest += text[i];
    }
  }
  if (!is_plain(rest)) table.refuse(key, fmt::format("'{}' must be printable ASCII", key));
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
      link.choice<std::string>("line_end", {{"\r\n", "\r\n"}, {"\r", "\r"}, {"\n", "\n"}, {"", ""}}, settings.line_end);
  settings.separator = link.text("separator", settings.separator);
  const bool is_ascii = settings.separator.size() == 1 && is_plain(settings.separator);
  if (!is_ascii && !is_one_latin_1(settings.separator)) {
    link.refuse("separator", "'link.separator' must be one printable character of ASCII or Latin-1");
  }
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
  from.character = table.whole("character", kFieldLimits, 0);
  from.length = table.optional_whole("length", {1, 1024});
  if (from.character > from.length.value_or(from.character)) {
    table.refuse("character", "'character' is greater than 'length'");
  }
  if (from.character > 0 && (from.fields || from.field > 1)) {
    table.refuse("character", "'character' counts in the whole answer: without 'field' and 'fields'");
  }
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
  quantity.command = table.flag("command", false);
  if (!quantity.command) quantity.text.from = read_field(table);
  read_words(table, quantity);
  quantity.text.write = read_line_of_text(table, "write", "");
  quantity.text.decimals = table.whole("decimals", {0, 6}, quantity.text.decimals);
  quantity.text.width = table.whole("width", {0, 12}, quantity.text.width);
  quantity.text.accepted = table.texts("accepted");
  if (quantity.command && !quantity.writable()) table.refuse("command", "a command is written: it needs a 'write'");
  read_write_limits(table, quantity);
  if (quantity.writable() && quantity.text.write.find("{}") == std::string::npos) {
    table.refuse("write", "'write' must show with {} where the value goes");
  }
  if (table.has("accepted") && !quantity.writable()) table.refuse("accepted", "'accepted' belongs to a write");
  for (const char* key : {"min", "max", "decimals", "width"}) {
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
  for (auto& [name, quantity] : map.quantities) {
    quantity.text.from.separator = map.link.separator;
    if (map.confirm && !quantity.text.accepted.empty()) {
      root.refuse("confirm", fmt::format("with 'confirm' there is no answer that '{}' could accept", name));
    }
  }
  for (Probe& probe : map.probes) probe.text.from.separator = map.link.separator;
  for (AlarmRule& rule : map.alarms) rule.text.from.separator = map.link.separator;
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
