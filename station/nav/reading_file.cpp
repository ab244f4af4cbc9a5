// SPDX-License-Identifier: Apache-2.0
#include "station/nav/reading_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "base/text.h"
#include "calib/vocabulary/sensor.h"
#include "station/import/channel.h"
#include "station/io/csv_scanner.h"
#include "station/io/text_file.h"

namespace soak::station {
namespace {

using Eigen::Matrix3d;

/// Which column is what.
struct ImuColumns {
  std::array<std::size_t, calib::kSensorCount> sensor{};
  std::array<Conversion, calib::kSensorCount> to_si{};
  std::size_t time = 0;
  double time_scale = 1.0;
  std::optional<std::size_t> temp;
  Conversion temp_to_si = nullptr;
};

base::Result<ImuColumns> columns_of(const std::vector<std::string>& headers, const std::string& path) {
  ImuColumns columns;
  std::array<bool, calib::kSensorCount> found{};
  bool has_time = false;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    const auto meaning = meaning_of_header(headers[i]);
    if (!meaning) return base::bad_input(meaning.error().message, path);
    if (meaning->role == ColumnRole::time && !has_time) {
      has_time = true;
      columns.time = i;
      columns.time_scale = meaning->scale;
    }
    if (meaning->name == "temp_c") {
      columns.temp = i;
      columns.temp_to_si = conversion_to_si(meaning->unit);
    }
    const auto sensor = calib::sensor_named(meaning->name);
    if (!sensor) continue;
    if (found[calib::index_of(*sensor)]) {
      return base::bad_input(
          fmt::format("the columns '{}' and '{}' are of the same sensor: only one of them may be named",
                      headers[columns.sensor[calib::index_of(*sensor)]], headers[i]),
          path);
    }
    found[calib::index_of(*sensor)] = true;
    columns.sensor[calib::index_of(*sensor)] = i;
    columns.to_si[calib::index_of(*sensor)] = conversion_to_si(meaning->unit);
  }
  if (has_time && std::ranges::all_of(found, [](bool is) { return is; })) return columns;
  return base::bad_input(
      fmt::format("the columns must hold a time (t_s, t_ms, t_us), three gyros (gx_dps ...) and three "
                  "accelerometers (ax_mps2 ...); there are {}",
                  fmt::join(headers, ", ")),
      path);
}

base::Result<nav::ImuSample> sample_of(const std::vector<std::string_view>& cells, const ImuColumns& columns,
                                       const Matrix3d& unit_to_body, const std::string& where) {
  const auto number = [&](std::size_t index) -> base::Result<double> {
    if (index >= cells.size()) return base::bad_input(fmt::format("the row has only {} cells", cells.size()), where);
    const auto value = base::parse_double(trimmed(cells[index]));
    if (value) return *value;
    return base::bad_input(fmt::format("'{}' is no number", cells[index]), where);
  };
  nav::ImuSample sample;
  const auto time = number(columns.time);
  if (!time) return base::forward_error(time);
  sample.t_s = *time * columns.time_scale;
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto value = number(columns.sensor[calib::index_of(sensor)]);
    if (!value) return base::forward_error(value);
    const double si = columns.to_si[calib::index_of(sensor)](*value);
    const auto axis = static_cast<Eigen::Index>(calib::axis_of(sensor));
    (calib::is_gyro(sensor) ? sample.rate_rps : sample.force_mps2)(axis) = si;
  }
  sample.rate_rps = unit_to_body * sample.rate_rps;
  sample.force_mps2 = unit_to_body * sample.force_mps2;
  if (columns.temp) {
    const auto temp = number(*columns.temp);
    if (!temp) return base::forward_error(temp);
    sample.temp_c = columns.temp_to_si(*temp);
  }
  return sample;
}

}  // namespace

base::Result<std::vector<nav::ImuSample>> read_samples(const std::filesystem::path& path,
                                                       const std::vector<std::string>& names,
                                                       const Matrix3d& unit_to_body) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const std::string_view whole = *text;
  CsvScanner scanner(whole.starts_with(kByteOrderMark) ? whole.substr(kByteOrderMark.size()) : whole, ',');
  std::vector<std::string_view> cells;
  std::vector<std::string> headers = names;
  std::optional<ImuColumns> columns;
  std::vector<nav::ImuSample> samples;
  while (true) {
    const std::string before = fmt::format("{}, line {}", path.string(), scanner.line() + 1);
    const auto more = scanner.next(cells);
    if (!more) return base::bad_input(more.error().message, before);
    if (!*more) break;
    if (!columns) {
      const bool first_line_names = headers.empty();
      if (first_line_names) {
        for (const std::string_view cell : cells) headers.emplace_back(trimmed(cell));
      }
      const auto found = columns_of(headers, path.string());
      if (!found) return base::forward_error(found);
      columns = *found;
      if (first_line_names) continue;
    }
    const auto sample =
        sample_of(cells, *columns, unit_to_body, fmt::format("{}, line {}", path.string(), scanner.line()));
    if (!sample) return base::forward_error(sample);
    samples.push_back(*sample);
  }
  if (samples.empty()) return base::bad_input("the file has no rows", path.string());
  return samples;
}

}  // namespace soak::station
