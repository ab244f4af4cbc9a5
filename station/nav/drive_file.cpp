// SPDX-License-Identifier: Apache-2.0
#include "station/nav/drive_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "base/units.h"
#include "nav/filter/smoother.h"
#include "nav/outages/pipeline.h"
#include "settings/reader.h"
#include "station/nav/outage_batch.h"
#include "station/nav/reading_file.h"
#include "station/nav/solution_file.h"

namespace soak::station {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr settings::Limits kAny = {-1e12, 1e12};

/// Between two points of a smoothed truth: a car goes some metres meanwhile.
constexpr double kSmoothedEvery_s = 0.25;

/// A smoothed truth may lie so far from a fix, however often there are fixes.
constexpr double kLeastReach_s = 2.0;

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
  bool smoothed_truth = false;
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
  const settings::Table truth = root.section("truth");
  file.truth_file = truth.text("file", file.gnss_file);
  file.smoothed_truth = truth.flag("smoothed", false);
  if (file.smoothed_truth && truth.has("file")) {
    truth.refuse("smoothed",
                 "'smoothed' makes the truth from the fixes and the readings: it must not stand beside 'file'");
  }
  return file;
}

/// Puts the times of the rows on the receiver's scale.
void set_clock(std::vector<nav::ImuSample>& samples, const DriveFile& file) {
  const double first_s = samples.front().t_s;
  for (nav::ImuSample& sample : samples) {
    if (file.start_s) sample.t_s = *file.start_s + (sample.t_s - first_s) * file.clock_ratio;
    sample.t_s += file.offset_s;
  }
}

nav::Drive drive_without_fixes(const DriveFile& file, std::vector<nav::ImuSample> samples) {
  nav::Drive drive;
  drive.name = file.name;
  drive.lever_arm_m = file.lever_arm_m;
  drive.unit_to_body = file.unit_to_body;
  drive.imu = std::move(samples);
  return drive;
}

std::vector<nav::GnssFix> believable(std::vector<nav::GnssFix> fixes, const DriveFile& file) {
  for (nav::GnssFix& fix : fixes) {
    fix.position_sigma_m = fix.position_sigma_m.cwiseMax(file.least_sigma_m);
    fix.velocity_sigma_mps = fix.velocity_sigma_mps.cwiseMax(file.least_sigma_mps);
  }
  return fixes;
}

void set_truth(nav::Drive& drive, const std::vector<nav::GnssFix>& points) {
  double variance_m2 = 0.0;
  for (const nav::GnssFix& point : points) {
    drive.truth.push_back({point.t_s, point.position, point.velocity_mps, std::nullopt});
    variance_m2 += point.position_sigma_m.head<2>().squaredNorm() / static_cast<double>(points.size());
  }
  drive.truth_sigma_m = std::sqrt(variance_m2);
}

/// Further away from any fix than two of the usual intervals a smoothed truth is little more than the filter's own
/// word.
double reach_s(const std::vector<nav::GnssFix>& fixes) {
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < fixes.size(); ++i) intervals_s.push_back(fixes[i].t_s - fixes[i - 1].t_s);
  return intervals_s.empty() ? kLeastReach_s : std::max(kLeastReach_s, 2.0 * base::median(intervals_s));
}

/// Where the truth is smoothed: from `start_s`, that of a fix, to the last fix or sample, within reach of a fix.
std::vector<double> smoothed_times(const nav::Drive& drive, double start_s) {
  const double end_s = std::min(drive.gnss.back().t_s, drive.imu.back().t_s);
  const double within_s = reach_s(drive.gnss);
  std::vector<double> t_s;
  for (int i = 1; start_s + i * kSmoothedEvery_s <= end_s; ++i) {
    const double at_s = start_s + i * kSmoothedEvery_s;
    const auto next = std::ranges::lower_bound(drive.gnss, at_s, {}, &nav::GnssFix::t_s);
    if (std::min(next->t_s - at_s, at_s - std::prev(next)->t_s) <= within_s) t_s.push_back(at_s);
  }
  return t_s;
}

/// By all fixes of the drive and the filter of `raw`.
base::Status smooth_truth(nav::Drive& drive) {
  const auto setup = nav::set_up(raw_filter(), drive);
  if (!setup) return base::forward_error(setup);
  const std::vector<double> t_s = smoothed_times(drive, setup->start.t_s);
  double variance_m2 = 0.0;
  for (const nav::SmoothedPoint& point : nav::smoothed(drive, setup->start, setup->options, t_s)) {
    drive.truth.push_back({point.t_s, point.antenna, point.antenna_velocity_mps, point.state.body_to_level});
    variance_m2 += point.antenna_covariance_m2.topLeftCorner<2, 2>().trace() / static_cast<double>(t_s.size());
  }
  drive.truth_source = nav::TruthSource::smoother;
  drive.truth_sigma_m = std::sqrt(variance_m2);
  return {};
}

}  // namespace

base::Result<nav::Drive> read_drive(const std::string& path) {
  const auto file = settings::read_file(path, drive_file_of);
  if (!file) return base::forward_error(file);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  auto samples = read_samples(folder / file->imu_file, file->columns, file->unit_to_body);
  if (!samples) return base::forward_error(samples);
  set_clock(*samples, *file);
  auto fixes = read_solutions(folder / file->gnss_file);
  if (!fixes) return base::forward_error(fixes);
  nav::Drive drive = drive_without_fixes(*file, *std::move(samples));
  drive.gnss = believable(*fixes, *file);
  if (file->smoothed_truth) {
    if (auto status = nav::validate(drive); !status) return base::forward_error(status);
    if (auto status = smooth_truth(drive); !status) return base::forward_error(status);
  } else if (file->truth_file == file->gnss_file) {
    drive.truth_source = nav::TruthSource::fixes;
    set_truth(drive, *fixes);
  } else {
    const auto truth = read_solutions(folder / file->truth_file);
    if (!truth) return base::forward_error(truth);
    drive.truth_source = nav::TruthSource::file;
    set_truth(drive, *truth);
  }
  std::size_t number = 0;
  std::erase_if(drive.gnss, [&](const nav::GnssFix&) { return number++ % static_cast<std::size_t>(file->every) != 0; });
  if (auto status = nav::validate(drive); !status) return base::forward_error(status);
  return drive;
}

}  // namespace soak::station
