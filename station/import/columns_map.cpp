// SPDX-License-Identifier: Apache-2.0
#include "station/import/columns_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <utility>

#include "base/text.h"
#include "settings/reader.h"
#include "station/import/slow_channel.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using settings::Kind;
using settings::Table;

constexpr std::string_view kTypeNames = "i8, i16, i32, i64, u8, u16, u32, f32, f64";
constexpr settings::Limits kFiniteNumber = {-1e300, 1e300};
/// A map may name every column of a wide recording.
constexpr std::size_t kLongestMap = 1U << 20U;

bool is_label_role(ColumnRole role) {
  return role == ColumnRole::phase || role == ColumnRole::sweep || role == ColumnRole::position;
}

/// Keys in alphabetical order: that of the columns and positions of a map.
std::vector<std::string> sorted_keys(const Table& table) {
  auto keys = table.keys();
  std::sort(keys.begin(), keys.end());
  return keys;
}

char read_separator(const Table& root) {
  const std::string text = root.text("separator", "comma");
  if (text == "comma") return ',';
  if (text == "semicolon") return ';';
  if (text == "tab") return '\t';
  if (text == "space") return ' ';
  if (text.size() == 1 && std::string_view("\"\r\n.+-").find(text[0]) == std::string_view::npos &&
      std::isalnum(static_cast<unsigned char>(text[0])) == 0) {
    return text[0];
  }
  root.refuse("separator",
              "separator must be \"comma\", \"semicolon\", \"tab\", \"space\" or one other punctuation character");
  return ',';
}

// --- [columns]

void read_column_type(const Table& table, MappedColumn& column) {
  const std::string name = table.text("type", "");
  column.is_label = name == "label";
  if (column.is_label || !table.has("type")) return;
  column.type = db::sample_type_named(name);
  if (!column.type) table.refuse("type", fmt::format("unknown type '{}': known are {}, label", name, kTypeNames));
}

void read_column_labels(const Table& table, MappedColumn& column) {
  if (!table.has("labels")) return;
  column.is_label = true;
  column.labels = table.texts("labels");
  for (auto label = column.labels.begin(); label != column.labels.end(); ++label) {
    if (label->empty()) table.refuse("labels", "labels must be a list of texts that are not empty");
    if (std::find(column.labels.begin(), label, *label) == label) continue;
    table.refuse("labels", fmt::format("label '{}' is duplicated", *label));
  }
}

void read_column_table(const Table& table, MappedColumn& column) {
  table.allow_only({"as", "type", "scale", "offset", "labels"}, " (a header with dots must be in quotes)");
  column.as = table.text("as", column.source);
  if (column.as.empty()) table.refuse("as", "'as' must be one of Soak's headers, for example \"gx_dps\"");
  read_column_type(table, column);
  read_column_labels(table, column);
  column.scale = table.number("scale", kFiniteNumber, column.scale);
  column.offset = table.number("offset", kFiniteNumber, column.offset);
  if (column.scale == 0.0) table.refuse("scale", fmt::format("column '{}': scale must not be 0", column.source));
}

void check_column(const Table& columns, MappedColumn& column) {
  const auto refuse = [&](std::string why) { columns.refuse(column.source, std::move(why)); };
  const ColumnRole role = column.meaning.role;
  const bool plain = column.scale == 1.0 && column.offset == 0.0;
  if (role == ColumnRole::run && (column.type || column.is_label || !plain)) {
    refuse("the run label is kept verbatim: it takes no type, scale or offset");
  }
  if (is_label_role(role)) column.is_label = true;
  if (column.is_label && role != ColumnRole::auxiliary && !is_label_role(role)) {
    refuse(fmt::format("'{}' holds numbers, not labels", column.as));
  }
  if (column.is_label && !plain) refuse(fmt::format("'{}' holds labels: no scale or offset", column.as));
  if (column.is_label && column.type && (*column.type == db::SampleType::f32 || *column.type == db::SampleType::f64)) {
    refuse(fmt::format("'{}' holds labels: their type must be a whole-number type", column.as));
  }
  if (role == ColumnRole::time && column.scale < 0.0) refuse("the scale of the time must be above 0");
}

/// Nothing where the header means nothing.
std::optional<MappedColumn> read_column(const Table& columns, const std::string& source) {
  MappedColumn column;
  column.source = source;
  column.as = source;
  switch (columns.kind(source)) {
    case Kind::text:
      column.as = columns.text(source);
      if (column.as.empty()) column.as = source;
      break;
    case Kind::table:
      read_column_table(*columns.table(source), column);
      break;
    default:
      columns.refuse(
          source,
          fmt::format("column '{}' must be one of Soak's headers (\"gx_dps\") or a table {{ as = \"gx_dps\", ... }}",
                      source));
      return std::nullopt;
  }
  auto meaning = meaning_of_header(column.as);
  if (!meaning) {
    columns.refuse(source, meaning.error().message);
    return std::nullopt;
  }
  column.meaning = *std::move(meaning);
  check_column(columns, column);
  return column;
}

void read_columns(const Table& columns, ColumnsMap& map) {
  std::set<std::string> names;
  for (const std::string& source : sorted_keys(columns)) {
    auto column = read_column(columns, source);
    if (!column) continue;
    if (!names.insert(column->meaning.name).second) {
      columns.refuse(source, fmt::format("'{}' means {}, which another column of the map already gives", source,
                                         column->meaning.name));
    }
    map.columns.push_back(*std::move(column));
  }
}

// --- [constants]

/// The cell that every row has; empty where it is a mistake.
std::string read_cell(const Table& constants, const std::string& header) {
  switch (constants.kind(header)) {
    case Kind::text:
      return constants.text(header);
    case Kind::whole:
      return std::to_string(constants.large_whole(header, {-9.3e18, 9.3e18}));
    case Kind::real:
      return base::shortest(constants.number(header, kFiniteNumber));
    default:
      constants.refuse(header, fmt::format("constant '{}' must be a text or a finite number", header));
      return "";
  }
}

void read_constants(const Table& constants, ColumnsMap& map) {
  for (const std::string& header : sorted_keys(constants)) {
    const auto meaning = meaning_of_header(header);
    if (!meaning) {
      constants.refuse(header, meaning.error().message);
    } else if (meaning->role == ColumnRole::time || meaning->role == ColumnRole::run) {
      constants.refuse(header, fmt::format("'{}' cannot be a constant", header));
    } else {
      map.constants.emplace_back(header, read_cell(constants, header));
    }
  }
}

// --- [positions], [azimuths_deg]

/// Direction up in body axes, as a unit vector.
constexpr double kFaceCosine = 0.99939;  ///< of 2°, the most that a face of the six positions may lean

/// Whether it is one of the six as its label alone says it.
bool is_nominal(const calib::Position& position) {
  const auto named = calib::position_named(position.label);
  return named && named->up == position.up;
}

void set_up_vector(const std::vector<double>& numbers, const Table& table, const std::string& key,
                   calib::Position& position) {
  double norm = 0.0;
  if (numbers.size() == 3) norm = std::hypot(numbers[0], numbers[1], numbers[2]);
  if (norm == 0.0) {
    return table.refuse(key, fmt::format("position '{}' must be the direction up in body axes, three numbers not all "
                                         "0: [0, 0, 1], or {{ up = [0, 0, 1], rate_dps = 30 }} where the fixture turns",
                                         position.label));
  }
  std::copy(numbers.begin(), numbers.end(), position.up.begin());
  // A unit vector stays as it is, to the bit: a map that was written from stored positions must give them back.
  if (std::abs(norm - 1.0) > 1e-12) {
    for (double& component : position.up) component /= norm;
  }
}

calib::Position read_map_position(const Table& positions, const std::string& label) {
  calib::Position position{.label = label, .up = {}, .azimuth_deg = {}, .rate_dps = {}};
  if (label.empty()) positions.refuse(label, "a position needs a label");
  if (positions.kind(label) != Kind::table) {
    set_up_vector(positions.numbers(label, kFiniteNumber), positions, label, position);
  } else {
    const Table table = positions.section(label);
    table.allow_only({"up", "azimuth_deg", "rate_dps"});
    position.azimuth_deg = table.optional_number("azimuth_deg", {-360.0, 360.0});
    position.rate_dps = table.optional_number("rate_dps", {-kFastestFixture_dps, kFastestFixture_dps});
    set_up_vector(table.numbers("up", kFiniteNumber), positions, label, position);
  }
  const auto named = calib::position_named(label);
  if (!named) return position;
  position.label = named->label;
  if (position.rate_dps) {
    positions.refuse(
        label,
        fmt::format("position '{}' is one of the six fixed ones, in which nothing turns: give yours another label",
                    label));
  }
  const double cosine = position.up[0] * named->up[0] + position.up[1] * named->up[1] + position.up[2] * named->up[2];
  if (cosine < kFaceCosine) {
    positions.refuse(
        label,
        fmt::format(
            "position '{}' is one of the six fixed ones, whose faces may lean by 2° at most: give yours another label",
            label));
  }
  return position;
}

void read_map_positions(const Table& root, ColumnsMap& map) {
  const Table azimuths = root.section("azimuths_deg");
  for (const std::string& label : sorted_keys(azimuths)) {
    const double azimuth_deg = azimuths.number(label, {-360.0, 360.0});
    auto position = calib::position_named(label);
    if (!position) {
      azimuths.refuse(
          label,
          fmt::format(
              "'{}' is not one of the six named positions; positions in [positions] have their azimuth_deg there",
              label));
      continue;
    }
    position->azimuth_deg = azimuth_deg;
    const auto given = [&](const calib::Position& other) { return other.label == position->label; };
    if (std::any_of(map.positions.begin(), map.positions.end(), given)) {
      azimuths.refuse(label, fmt::format("the azimuth of '{}' is duplicated", position->label));
    }
    map.positions.push_back(*std::move(position));
  }
  const Table positions = root.section("positions");
  for (const std::string& label : sorted_keys(positions)) {
    calib::Position position = read_map_position(positions, label);
    const auto same = std::ranges::find(map.positions, position.label, &calib::Position::label);
    if (same != map.positions.end()) {
      positions.refuse(
          label,
          fmt::format("position '{}' is duplicated; where its face leans, its azimuth_deg stands beside its 'up'",
                      position.label));
      continue;
    }
    map.positions.push_back(std::move(position));
  }
}

ColumnsMap read_columns_root(const Table& root) {
  ColumnsMap map;
  root.allow_only({"separator", "skip_rows", "columns", "constants", "positions", "azimuths_deg"});
  map.separator = read_separator(root);
  map.skip_rows = static_cast<std::size_t>(root.whole("skip_rows", {0.0, 2147483647.0}, 0));
  read_columns(root.section("columns"), map);
  read_constants(root.section("constants"), map);
  read_map_positions(root, map);
  return map;
}

// --- a map as text

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
  std::set<std::string> written;
  for (const calib::Position& position : positions) {
    const auto named = calib::position_named(position.label);
    const std::string label = named ? named->label : position.label;
    if (is_nominal(position) || !written.insert(label).second) continue;
    const std::string up = fmt::format("[{}, {}, {}]", toml_number(position.up[0]), toml_number(position.up[1]),
                                       toml_number(position.up[2]));
    std::string more;
    if (position.azimuth_deg) more += ", azimuth_deg = " + toml_number(*position.azimuth_deg);
    if (position.rate_dps) more += ", rate_dps = " + toml_number(*position.rate_dps);
    const std::string value = more.empty() ? up : fmt::format("{{ up = {}{} }}", up, more);
    text += fmt::format("{} = {}\n", toml_string(label), value);
  }
  return text.empty() ? text : "\n[positions]\n" + text;
}

/// Two spellings of one of the six ("+x", "+X") are one position.
std::string azimuths_text(const std::vector<calib::Position>& positions) {
  std::string text;
  std::set<std::string> written;
  for (const calib::Position& position : positions) {
    const auto named = calib::position_named(position.label);
    if (!is_nominal(position) || !position.azimuth_deg || !written.insert(named->label).second) continue;
    text += fmt::format("{} = {}\n", toml_string(named->label), toml_number(*position.azimuth_deg));
  }
  return text.empty() ? text : "\n[azimuths_deg]\n" + text;
}

}  // namespace

base::Result<ColumnsMap> parse_columns_map(std::string_view toml, const std::string& where) {
  return settings::read(toml, where, read_columns_root, kLongestMap);
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
