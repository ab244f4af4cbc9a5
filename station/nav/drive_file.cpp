// SPDX-License-Identifier: Apache-2.0
#include "station/nav/drive_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "base/units.h"
#include "calib/vocabulary/sensor.h"
#include "settings/reader.h"
#include "station/import/channel.h"
#include "station/io/csv_scanner.h"
#include "station/io/text_file.h"
#include "station/nav/solution_file.h"

namespace soak::station {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr settings::Limits kAny = {-1e12, 1e12};

/// What a drive file says.
struct DriveFile {
  std::string name;
  Vector3d lever_arm_m = Vector3d::Zero();
  std::string imu_file;
  std::vector<std::string> columns;  ///< empty: the file's first line
  std::optional<double> start_s;     ///< absent: times are those of the fixes
  double clock_ratio = 1.0;
  double offset_s = 0.0;
  Matrix3d unit_to_body = Matrix3d::Identity();
  std::string gnss_file;
  int every = 1;
  double least_sigma_m = 0.0;
  double least_sigma_mps = 0.0;
  std::string truth_file;
};

/// Three numbers under a key; zeros where it is absent.
Vector3d three(const settings::Table& table, std::string_view key, settings::Limits limits) {
  const auto values = table.numbers(key, limits);
  if (values.empty()) return Vector3d::Zero();
  if (values.size() == 3) return {values[0], values[1], values[2]};
  table.refuse(key, fmt::format("'{}' must be three numbers", key));
  return Vector3d::Zero();
}

/// The rows that pick right, forward and up from the unit's axes: "y", "-x", "z".
Matrix3d axes_of(const settings::Table& table) {
  Matrix3d rows = Matrix3d::Zero();
  const auto labels = table.texts("axes");
  if (labels.empty()) return Matrix3d::Identity();
  for (std::size_t i = 0; i < std::min<std::size_t>(labels.size(), 3); ++i) {
    const std::size_t axis = std::string_view("xyz").find(labels[i].empty() ? ' ' : labels[i].back());
    const bool is_axis = axis < 3 && (labels[i].size() == 1 || (labels[i].size() == 2 && labels[i][0] == '-'));
    if (is_axis)
      rows(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) = labels[i].size() == 2 ? -1.0 : 1.0;
  }
  const bool turns = (rows * rows.transpose() - Matrix3d::Identity()).norm() < 1e-12 &&
                     nav::cross(rows.row(0), rows.row(1)).dot(rows.row(2)) > 0.0;
  if (labels.size() == 3 && turns) return rows;
  table.refuse("axes",
               "'axes' must name the unit's axes that point right, forward and up, such as [\"y\", \"-x\", \"z\"]: "
               "three different ones that form a right-handed frame");
  return Matrix3d::Identity();
}

DriveFile drive_file_of(const settings::Table& root) {
  DriveFile file;
  file.name = root.text("name");
  file.lever_arm_m = three(root, "lever_arm_m", {-100.0, 100.0});
  const settings::Table imu = root.section("imu", settings::kRequired);
  file.imu_file = imu.text("file");
  file.columns = imu.texts("columns");
  file.start_s = imu.optional_number("start_s", kAny);
  file.clock_ratio = imu.number("clock_ratio", {0.9, 1.1}, 1.0);
  if (imu.has("clock_ratio") && !file.start_s) {
    imu.refuse("clock_ratio",
               "'clock_ratio' needs 'start_s', the time of the first row on the receiver's scale: without it the times "
               "are on that scale already");
  }
  file.offset_s = imu.number("offset_s", {-1e6, 1e6}, 0.0);
  const Vector3d mounting = base::kRadPerDeg * three(imu, "mounting_deg", {-180.0, 180.0});
  file.unit_to_body = nav::matrix_of({mounting.x(), mounting.y(), mounting.z()}) * axes_of(imu);
  const settings::Table gnss = root.section("gnss", settings::kRequired);
  file.gnss_file = gnss.text("file");
  file.every = gnss.whole("every", {1.0, 1000.0}, 1);
  file.least_sigma_m = gnss.number("least_sigma_m", {0.0, 100.0}, 0.0);
  file.least_sigma_mps = gnss.number("least_sigma_mps", {0.0, 100.0}, 0.0);
  file.truth_file = root.section("truth").text("file", file.gnss_file);
  return file;
}

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

base::Result<std::vector<nav::ImuSample>> read_samples(const std::filesystem::path& path, const DriveFile& file) {
  const auto text = read_text_file(path);
  if (!text) return base::forward_error(text);
  const std::string_view whole = *text;
  CsvScanner scanner(whole.starts_with(kByteOrderMark) ? whole.substr(kByteOrderMark.size()) : whole, ',');
  std::vector<std::string_view> cells;
  std::vector<std::string> headers = file.columns;
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
        sample_of(cells, *columns, file.unit_to_body, fmt::format("{}, line {}", path.string(), scanner.line()));
    if (!sample) return base::forward_error(sample);
    samples.push_back(*sample);
  }
  if (samples.empty()) return base::bad_input("the file has no rows", path.string());
  const double first_s = samples.front().t_s;
  for (nav::ImuSample& sample : samples) {
    if (file.start_s) sample.t_s = *file.start_s + (sample.t_s - first_s) * file.clock_ratio;
    sample.t_s += file.offset_s;
  }
  return samples;
}

}  // namespace

base::Result<nav::Drive> read_drive(const std::string& path) {
  const auto file = settings::read_file(path, drive_file_of);
  if (!file) return base::forward_error(file);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  auto samples = read_samples(folder / file->imu_file, *file);
  if (!samples) return base::forward_error(samples);
  auto fixes = read_solutions(folder / file->gnss_file);
  if (!fixes) return base::forward_error(fixes);
  const auto truth = file->truth_file == file->gnss_file ? fixes : read_solutions(folder / file->truth_file);
  if (!truth) return base::forward_error(truth);
  nav::Drive drive;
  drive.name = file->name;
  drive.lever_arm_m = file->lever_arm_m;
  drive.unit_to_body = file->unit_to_body;
  drive.imu = *std::move(samples);
  for (std::size_t i = 0; i < fixes->size(); i += static_cast<std::size_t>(file->every)) {
    nav::GnssFix fix = (*fixes)[i];
    fix.position_sigma_m = fix.position_sigma_m.cwiseMax(file->least_sigma_m);
    fix.velocity_sigma_mps = fix.velocity_sigma_mps.cwiseMax(file->least_sigma_mps);
    drive.gnss.push_back(fix);
  }
  for (const nav::GnssFix& fix : *truth) drive.truth.push_back({fix.t_s, fix.position, fix.velocity_mps, std::nullopt});
  if (auto status = nav::validate(drive); !status) return base::forward_error(status);
  return drive;
}

}  // namespace soak::station
