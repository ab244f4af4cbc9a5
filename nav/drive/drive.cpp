// SPDX-License-Identifier: Apache-2.0
#include "nav/drive/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace soak::nav {
namespace {

constexpr double kHighestLatitude_rad = 89.0 * base::kRadPerDeg;
/// No inertial unit of a vehicle reads more: 5700 deg/s, 1000 g.
constexpr double kMostRate_rps = 100.0;
constexpr double kMostForce_mps2 = 10000.0;
/// Pieces shorter than this are rounding.
constexpr double kShortest_s = 1e-9;

bool is_finite(const Geodetic& place) {
  return std::isfinite(place.latitude_rad) && std::isfinite(place.longitude_rad) && std::isfinite(place.height_m);
}

template <class Row>
base::Status check_times(const std::vector<Row>& rows, const char* what, const std::string& where) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (std::isfinite(rows[i].t_s) && (i == 0 || rows[i].t_s > rows[i - 1].t_s)) continue;
    return base::bad_input(fmt::format("{} {}: the time must be a number above that of the one before", what, i + 1),
                           where);
  }
  return {};
}

base::Status check_sample(const std::vector<ImuSample>& imu, std::size_t index, const std::string& where) {
  const ImuSample& sample = imu[index];
  if (!sample.rate_rps.allFinite() || !sample.force_mps2.allFinite()) {
    return base::bad_input(fmt::format("sample {}: all readings must be numbers", index + 1), where);
  }
  if (sample.rate_rps.cwiseAbs().maxCoeff() > kMostRate_rps ||
      sample.force_mps2.cwiseAbs().maxCoeff() > kMostForce_mps2) {
    return base::bad_input(fmt::format("sample {}: rates must lie within ±{:.0f} deg/s, specific forces within ±{:.0f} "
                                       "m/s²",
                                       index + 1, kMostRate_rps / base::kRadPerDeg, kMostForce_mps2),
                           where);
  }
  if (index == 0 || sample.t_s - imu[index - 1].t_s <= kLongestInterval_s) return {};
  return base::bad_input(
      fmt::format("sample {}: comes {:.3f} s after the one before; the filter needs one every {} s at least: begin the "
                  "recording after the gap, or end it before",
                  index + 1, sample.t_s - imu[index - 1].t_s, kLongestInterval_s),
      where);
}

base::Status check_fix(const GnssFix& fix, std::size_t index, const std::string& where) {
  const bool is_number = is_finite(fix.position) && fix.velocity_mps.allFinite() && fix.position_sigma_m.allFinite() &&
                         fix.velocity_sigma_mps.allFinite();
  if (!is_number) return base::bad_input(fmt::format("fix {}: all values must be numbers", index + 1), where);
  if (std::abs(fix.position.latitude_rad) >= kHighestLatitude_rad) {
    return base::bad_input(fmt::format("fix {}: the latitude must lie within ±89 degrees", index + 1), where);
  }
  if (fix.position_sigma_m.minCoeff() > 0.0 && fix.velocity_sigma_mps.minCoeff() > 0.0) return {};
  return base::bad_input(fmt::format("fix {}: standard deviations must be above 0", index + 1), where);
}

}  // namespace

base::Status validate(const Drive& drive) {
  if (drive.imu.size() < 2) return base::bad_input("a drive needs at least 2 samples of the unit", drive.name);
  if (auto status = check_times(drive.imu, "sample", drive.name); !status) return status;
  if (auto status = check_times(drive.gnss, "fix", drive.name); !status) return status;
  if (auto status = check_times(drive.truth, "truth", drive.name); !status) return status;
  for (std::size_t i = 0; i < drive.imu.size(); ++i) {
    if (auto status = check_sample(drive.imu, i, drive.name); !status) return status;
  }
  for (std::size_t i = 0; i < drive.gnss.size(); ++i) {
    if (auto status = check_fix(drive.gnss[i], i, drive.name); !status) return status;
  }
  const auto is_bad = [](const TruthPoint& point) {
    return !is_finite(point.position) || !point.velocity_mps.allFinite();
  };
  if (std::ranges::any_of(drive.truth, is_bad))
    return base::bad_input("all values of the truth must be numbers", drive.name);
  return {};
}

Drive with_outage(const Drive& drive, const Outage& outage) {
  Drive seen{drive.name, {}, {}, {}, drive.lever_arm_m, drive.unit_to_body};
  // One sample beyond the end: the outage may end within its interval.
  auto last = std::ranges::lower_bound(drive.imu, outage.end_s, {}, &ImuSample::t_s);
  if (last != drive.imu.end()) ++last;
  seen.imu.assign(drive.imu.begin(), last);
  std::ranges::copy_if(drive.gnss, std::back_inserter(seen.gnss),
                       [&](const GnssFix& fix) { return fix.t_s <= outage.begin_s; });
  return seen;
}

ImuFeed::ImuFeed(const std::vector<ImuSample>& samples, double start_s) : samples_(samples), now_s_(start_s) {
  const auto first = std::ranges::upper_bound(samples, start_s + kShortest_s, {}, &ImuSample::t_s);
  index_ = static_cast<std::size_t>(first - samples.begin());
}

std::optional<ImuFeed::Piece> ImuFeed::next(double until_s) {
  if (index_ >= samples_.size() || until_s - now_s_ < kShortest_s) return std::nullopt;
  const ImuSample& sample = samples_[index_];
  const double end_s = std::min(sample.t_s, until_s);
  const Piece piece{&sample, end_s - now_s_};
  now_s_ = end_s;
  if (sample.t_s - now_s_ < kShortest_s) ++index_;
  return piece;
}

}  // namespace soak::nav
