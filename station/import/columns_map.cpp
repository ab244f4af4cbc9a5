// SPDX-License-Identifier: Apache-2.0
#include "station/import/columns_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "station/import/slow_channel.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

constexpr std::string_view kTypeNames = "i8, i16, i32, i64, u8, u16, u32, f32, f64";

/// A mistake in the file; they are reported together, in the order of lines.
struct Mistake {
  std::size_t line;
  std::string text;
};

bool is_label_role(ColumnRole role) {
  return role == ColumnRole::phase || role == ColumnRole::sweep || role == ColumnRole::position;
}

class MapParser {
 public:
  base::Result<ColumnsMap> parse(const toml::table& root, const std::string& where) {
    for (const auto& [key, node] : root) top_level(key.str(), node);
    check_duplicates();
    if (mistakes_.empty()) return std::move(map_);
    std::sort(mistakes_.begin(), mistakes_.end(),
              [](const auto& a, const auto& b) { return std::tie(a.line, a.text) < std::tie(b.line, b.text); });
    std::string message;
    for (const Mistake& mistake : mistakes_) {
      message += fmt::format("{}line {}: {}", message.empty() ? "" : "\n", mistake.line, mistake.text);
    }
    return base::bad_input(message, where);
  }

 private:
  void mistake(const toml::node& node, std::string text) {
    mistakes_.push_back({static_cast<std::size_t>(node.source().begin.line), std::move(text)});
  }

  void top_level(std::string_view key, const toml::node& node) {
    if (key == "separator") return separator(node);
    if (key == "skip_rows") return skip_rows(node);
    if (key != "columns" && key != "constants" && key != "positions" && key != "azimuths_deg") {
      return mistake(node, fmt::format("unknown key '{}': known are separator, skip_rows, [columns], [constants], "
                                       "[positions], [azimuths_deg]",
                                       key));
    }
    const toml::table* table = node.as_table();
    if (table == nullptr) return mistake(node, fmt::format("'{}' must be a table", key));
    for (const auto& [name, entry] : *table) {
      if (key == "columns") column(name.str(), entry);
      if (key == "constants") constant(name.str(), entry);
      if (key == "positions") position(name.str(), entry);
      if (key == "azimuths_deg") named_azimuth(name.str(), entry);
    }
  }

  void separator(const toml::node& node) {
    const auto text = node.value_exact<std::string>();
    if (text == "comma") {
      map_.separator = ',';
    } else if (text == "semicolon") {
      map_.separator = ';';
    } else if (text == "tab") {
      map_.separator = '\t';
    } else if (text == "space") {
      map_.separator = ' ';
    } else if (text && text->size() == 1 && std::string_view("\"\r\n.+-").find((*text)[0]) == std::string_view::npos &&
               std::isalnum(static_cast<unsigned char>((*text)[0])) == 0) {
      map_.separator = (*text)[0];
    } else {
      mistake(node,
              "separator must be \"comma\", \"semicolon\", \"tab\", \"space\" or one other punctuation character");
    }
  }

  void skip_rows(const toml::node& node) {
    const auto count = node.value_exact<std::int64_t>();
    if (!count || *count < 0) return mistake(node, "skip_rows must be a whole number, 0 or more");
    map_.skip_rows = static_cast<std::size_t>(*count);
  }

  void column(std::string_view source, const toml::node& node) {
    MappedColumn column;
    column.source = source;
    if (const auto text = node.value_exact<std::string>()) {
      column.as = *text;
    } else if (const toml::table* table = node.as_table()) {
      column_table(column, *table);
    } else {
      return mistake(node, fmt::format("column '{}' must be one of our headers (\"gx_dps\") or a table "
                                       "{{ as = \"gx_dps\", ... }}",
                                       source));
    }
    if (column.as.empty()) column.as = column.source;
    auto meaning = meaning_of_header(column.as);
    if (!meaning) return mistake(node, meaning.error().message);
    column.meaning = *std::move(meaning);
    check_column(column, node);
    lines_.push_back(static_cast<std::size_t>(node.source().begin.line));
    map_.columns.push_back(std::move(column));
  }

  void column_table(MappedColumn& column, const toml::table& table) {
    for (const auto& [key, node] : table) {
      if (key == "as") {
        const auto text = node.value_exact<std::string>();
        if (!text || text->empty()) mistake(node, "'as' must be one of our headers, for example \"gx_dps\"");
        column.as = text.value_or("");
      } else if (key == "type") {
        column_type(column, node);
      } else if (key == "scale") {
        column.scale = finite_number(node, "scale");
      } else if (key == "offset") {
        column.offset = finite_number(node, "offset");
      } else if (key == "labels") {
        column_labels(column, node);
      } else {
        mistake(node, fmt::format("column '{}' has the unknown key '{}': known are as, type, scale, offset, labels "
                                  "(a header with dots stands in quotes)",
                                  column.source, key.str()));
      }
    }
    if (column.scale == 0.0) mistake(table, fmt::format("column '{}': scale must not be 0", column.source));
  }

  void column_type(MappedColumn& column, const toml::node& node) {
    const std::string name = node.value_exact<std::string>().value_or("");
    if (name == "label") {
      column.is_label = true;
      return;
    }
    column.type = db::sample_type_named(name);
    if (!column.type) mistake(node, fmt::format("unknown type '{}': known are {}, label", name, kTypeNames));
  }

  void column_labels(MappedColumn& column, const toml::node& node) {
    column.is_label = true;
    const toml::array* list = node.as_array();
    if (list == nullptr) return mistake(node, "labels must be a list of texts");
    for (const toml::node& entry : *list) {
      const auto text = entry.value_exact<std::string>();
      if (!text || text->empty()) return mistake(entry, "labels must be a list of texts that are not empty");
      if (std::find(column.labels.begin(), column.labels.end(), *text) != column.labels.end()) {
        return mistake(entry, fmt::format("label '{}' stands there twice", *text));
      }
      column.labels.push_back(*text);
    }
  }

  void check_column(MappedColumn& column, const toml::node& node) {
    const ColumnRole role = column.meaning.role;
    const bool plain = column.scale == 1.0 && column.offset == 0.0;
    if (role == ColumnRole::run && (column.type || column.is_label || !plain)) {
      mistake(node, "the run label is kept verbatim: it takes no type, scale or offset");
    }
    if (is_label_role(role)) column.is_label = true;
    if (column.is_label && role != ColumnRole::auxiliary && !is_label_role(role)) {
      mistake(node, fmt::format("'{}' holds numbers, not labels", column.as));
    }
    if (column.is_label && !plain) mistake(node, fmt::format("'{}' holds labels: no scale or offset", column.as));
    if (column.is_label && column.type &&
        (*column.type == db::SampleType::f32 || *column.type == db::SampleType::f64)) {
      mistake(node, fmt::format("'{}' holds labels: their type must be a whole-number type", column.as));
    }
    if (role == ColumnRole::time && column.scale < 0.0) mistake(node, "the scale of the time must be above 0");
  }

  void constant(std::string_view header, const toml::node& node) {
    auto meaning = meaning_of_header(header);
    if (!meaning) return mistake(node, meaning.error().message);
    if (meaning->role == ColumnRole::time || meaning->role == ColumnRole::run) {
      return mistake(node, fmt::format("'{}' cannot be a constant", header));
    }
    std::string cell;
    if (const auto text = node.value_exact<std::string>()) {
      cell = *text;
    } else if (const auto whole = node.value_exact<std::int64_t>()) {
      cell = std::to_string(*whole);
    } else if (const auto real = node.value_exact<double>(); real && std::isfinite(*real)) {
      cell = base::shortest(*real);
    } else {
      return mistake(node, fmt::format("constant '{}' must be a text or a finite number", header));
    }
    map_.constants.emplace_back(header, std::move(cell));
  }

  void position(std::string_view label, const toml::node& node) {
    if (label.empty()) return mistake(node, "a position needs a label");
    if (calib::position_named(label)) {
      return mistake(node, fmt::format("position '{}' is one of the six fixed ones: give yours another label, or its "
                                       "azimuth in [azimuths_deg]",
                                       label));
    }
    calib::Position position{.label = std::string(label), .up = {}, .azimuth_deg = {}, .rate_dps = {}};
    if (const toml::table* table = node.as_table()) return position_table(std::move(position), *table, node);
    up_vector(position, node, node.as_array());
    map_.positions.push_back(std::move(position));
  }

  void position_table(calib::Position position, const toml::table& table, const toml::node& node) {
    const toml::array* list = nullptr;
    for (const auto& [key, entry] : table) {
      if (key == "up") {
        list = entry.as_array();
      } else if (key == "rate_dps") {
        position.rate_dps = finite_number(entry, "rate_dps");
        if (std::abs(*position.rate_dps) > kFastestFixture_dps) {
          mistake(entry, fmt::format("position '{}': rate_dps is {}, but a fixture turns at up to {} deg/s",
                                     position.label, *position.rate_dps, kFastestFixture_dps));
        }
      } else if (key == "azimuth_deg") {
        position.azimuth_deg = azimuth(entry);
      } else {
        mistake(entry, fmt::format("position '{}' has the unknown key '{}': known are up, azimuth_deg, rate_dps",
                                   position.label, key.str()));
      }
    }
    up_vector(position, node, list);
    map_.positions.push_back(std::move(position));
  }

  /// The azimuth of one of the six.
  void named_azimuth(std::string_view label, const toml::node& node) {
    auto position = calib::position_named(label);
    if (!position) {
      return mistake(node, fmt::format("'{}' is none of the six named positions: those of [positions] have their "
                                       "azimuth_deg there",
                                       label));
    }
    position->azimuth_deg = azimuth(node);
    const auto given = [&](const calib::Position& other) { return other.label == position->label; };
    if (std::any_of(map_.positions.begin(), map_.positions.end(), given)) {
      return mistake(node, fmt::format("the azimuth of '{}' stands there twice", position->label));
    }
    map_.positions.push_back(*std::move(position));
  }

  double azimuth(const toml::node& node) {
    const double azimuth_deg = finite_number(node, "azimuth_deg");
    if (std::abs(azimuth_deg) > 360.0) mistake(node, "azimuth_deg must lie between -360 and 360");
    return azimuth_deg;
  }

  void up_vector(calib::Position& position, const toml::node& node, const toml::array* list) {
    bool valid = list != nullptr && list->size() == 3;
    for (std::size_t i = 0; valid && i < 3; ++i) {
      const auto number = list->get(i)->value<double>();
      valid = number && std::isfinite(*number);
      if (valid) position.up[i] = *number;
    }
    const double norm = std::hypot(position.up[0], position.up[1], position.up[2]);
    if (!valid || norm == 0.0) {
      return mistake(node, fmt::format("position '{}' must be the direction up in body axes, three numbers not all 0: "
                                       "[0, 0, 1], or {{ up = [0, 0, 1], rate_dps = 30 }} where the fixture turns",
                                       position.label));
    }
    // A unit vector stays as it is, to the bit: a map that was written from stored positions must give them back.
    if (std::abs(norm - 1.0) > 1e-12) {
      for (double& component : position.up) component /= norm;
    }
  }

  double finite_number(const toml::node& node, std::string_view name) {
    const auto number = node.value<double>();
    if (number && std::isfinite(*number)) return *number;
    mistake(node, fmt::format("{} must be a finite number", name));
    return 1.0;
  }

  void check_duplicates() {
    std::set<std::string> names;
    for (std::size_t i = 0; i < map_.columns.size(); ++i) {
      if (names.insert(map_.columns[i].meaning.name).second) continue;
      mistakes_.push_back({lines_[i], fmt::format("'{}' stands for {}, which another column of the map gives already",
                                                  map_.columns[i].source, map_.columns[i].meaning.name)});
    }
  }

  ColumnsMap map_;
  std::vector<std::size_t> lines_;  // of map_.columns
  std::vector<Mistake> mistakes_;
};

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    } else {
      result += c;
    }
  }
  return result + '"';
}

std::string toml_number(double value) {
  const std::string text = base::shortest(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string column_text(const MappedColumn& column) {
  std::string text = fmt::format("{} = {{ as = {}", toml_string(column.source), toml_string(column.as));
  if (column.type) text += fmt::format(", type = \"{}\"", db::name_of(*column.type));
  if (column.scale != 1.0) text += ", scale = " + toml_number(column.scale);
  if (column.offset != 0.0) text += ", offset = " + toml_number(column.offset);
  if (column.is_label) {
    std::vector<std::string> labels;
    labels.reserve(column.labels.size());
    for (const std::string& label : column.labels) labels.push_back(toml_string(label));
    text += fmt::format(", labels = [{}]", fmt::join(labels, ", "));
  }
  return text + " }\n";
}

std::string positions_text(const std::vector<calib::Position>& positions) {
  std::string text;
  for (const calib::Position& position : positions) {
    if (calib::position_named(position.label)) continue;
    const std::string up = fmt::format("[{}, {}, {}]", toml_number(position.up[0]), toml_number(position.up[1]),
                                       toml_number(position.up[2]));
    std::string more;
    if (position.azimuth_deg) more += ", azimuth_deg = " + toml_number(*position.azimuth_deg);
    if (position.rate_dps) more += ", rate_dps = " + toml_number(*position.rate_dps);
    const std::string value = more.empty() ? up : fmt::format("{{ up = {}{} }}", up, more);
    text += fmt::format("{} = {}\n", toml_string(position.label), value);
  }
  return text.empty() ? text : "\n[positions]\n" + text;
}

/// Two spellings of one of the six ("+x", "+X") are one position.
std::string azimuths_text(const std::vector<calib::Position>& positions) {
  std::string text;
  std::set<std::string> written;
  for (const calib::Position& position : positions) {
    const auto named = calib::position_named(position.label);
    if (!named || !position.azimuth_deg || !written.insert(named->label).second) continue;
    text += fmt::format("{} = {}\n", toml_string(named->label), toml_number(*position.azimuth_deg));
  }
  return text.empty() ? text : "\n[azimuths_deg]\n" + text;
}

}  // namespace

base::Result<ColumnsMap> parse_columns_map(std::string_view toml, const std::string& where) {
  try {
    return MapParser().parse(toml::parse(toml), where);
  } catch (const toml::parse_error& error) {
    return base::bad_input(fmt::format("line {}: {}", error.source().begin.line, error.description()), where);
  }
}

base::Result<ColumnsMap> read_columns_map(const std::filesystem::path& path) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  return parse_columns_map(*text, path.string());
}

std::string columns_map_text(const ColumnsMap& map) {
  std::string text;
  if (map.separator != ',') text += fmt::format("separator = {}\n", toml_string(std::string_view(&map.separator, 1)));
  if (map.skip_rows != 0) text += fmt::format("skip_rows = {}\n", map.skip_rows);
  if (!map.columns.empty()) text += "\n[columns]\n";
  for (const MappedColumn& column : map.columns) text += column_text(column);
  if (!map.constants.empty()) text += "\n[constants]\n";
  for (const auto& [header, cell] : map.constants)
    text += fmt::format("{} = {}\n", toml_string(header), toml_string(cell));
  return text + positions_text(map.positions) + azimuths_text(map.positions);
}

}  // namespace soak::station
