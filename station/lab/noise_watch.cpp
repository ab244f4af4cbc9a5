// SPDX-License-Identifier: Apache-2.0
#include "station/lab/noise_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "station/io/output.h"
#include "station/lab/segment_capture.h"

namespace soak::station {
namespace {

using calib::signal::AllanStream;
using calib::signal::PhaseRecord;
using nlohmann::json;

constexpr std::size_t kFewestTerms = 30;
constexpr std::size_t kBreak = PhaseRecord::kBridge + 1;  ///< missing samples that end a stretch
constexpr double kFigureTau_s = 1.0;
constexpr std::chrono::seconds kNoiseRefresh{2};
constexpr double kMissingReading = std::numeric_limits<double>::quiet_NaN();

std::vector<AllanStream> new_streams(double rate_hz) {
  std::vector<AllanStream> streams;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) streams.push_back(AllanStream::create(rate_hz).value());
  return streams;
}

/// The nearest of the averaging times of an AllanStream: 1, 2, 3, then 4, 5, 6 and 7 times powers of two.
std::size_t nearest_multiple(double samples) {
  const int octave = std::max(0, std::ilogb(std::max(samples, 1.0)) - 2);
  const double step = std::ldexp(1.0, octave);
  return static_cast<std::size_t>(std::max(1.0, std::round(samples / step)) * step);
}

/// Beyond kExact the stream counts only every 2^j-th difference, of averages of up to kExact steps of that size.
bool has_enough_terms(const AllanStream::Point& point) {
  return point.terms >= std::max(kFewestTerms, std::min(point.multiple, AllanStream::kExact));
}

std::vector<AllanStream::Point> reliable_points(const AllanStream& stream) {
  std::vector<AllanStream::Point> points = stream.points();
  std::erase_if(points, [](const AllanStream::Point& point) { return !has_enough_terms(point); });
  return points;
}

/// Of three sensors, the first of them sensor number `first`: figures that people compare need more behind them than a
/// curve does.
std::optional<std::array<double, 3>> three_at(std::span<const AllanStream> streams, std::size_t first,
                                              std::size_t multiple) {
  std::array<double, 3> values{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto points = streams[first + axis].points();
    const auto at = std::ranges::find(points, multiple, &AllanStream::Point::multiple);
    if (at == points.end() || at->terms < kFewestTerms * multiple) return std::nullopt;
    values[axis] = at->overlapping * calib::printed_per_si(calib::kSensors[first + axis]);
  }
  return values;
}

/// One member of the points, null for averaging times that only other sensors have.
json deviation_list(std::span<const AllanStream::Point> points, double AllanStream::Point::* member, double factor,
                    std::size_t length) {
  json list = json::array();
  for (const AllanStream::Point& point : points) list.push_back(number_or_null(factor * point.*member));
  while (list.size() < length) list.push_back(nullptr);
  return list;
}

}  // namespace

NoiseWatch::NoiseWatch(double rate_hz) : rate_hz_(rate_hz), streams_(new_streams(rate_hz)) { begin_run(); }

void NoiseWatch::begin_run() {
  const std::lock_guard lock(mutex_);
  streams_ = new_streams(rate_hz_);
  samples_ = 0;
  last_s_.reset();
  figures_ = {static_cast<double>(nearest_multiple(kFigureTau_s * rate_hz_)) / rate_hz_, std::nullopt, std::nullopt};
  figures_are_old_ = false;
}

void NoiseWatch::begin_recording() { last_s_.reset(); }

std::size_t NoiseWatch::missing_before(const hal::ImuSample& sample) const {
  if (!last_s_) return kBreak;
  const double steps = std::round((sample.t_s - *last_s_) * rate_hz_);
  return static_cast<std::size_t>(std::clamp(steps - 1.0, 0.0, static_cast<double>(kBreak)));
}

void NoiseWatch::add(std::span<const hal::ImuSample> samples) {
  if (samples.empty()) return;
  std::vector<std::size_t> missing;
  for (const hal::ImuSample& sample : samples) {
    missing.push_back(missing_before(sample));
    last_s_ = sample.t_s;
  }
  const std::lock_guard lock(mutex_);
  for (std::size_t s = 0; s < streams_.size(); ++s) {
    readings_.clear();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      readings_.insert(readings_.end(), missing[i], kMissingReading);
      const double value = reading_of(samples[i], s);
      readings_.push_back(std::isfinite(value) ? value : kMissingReading);
    }
    // It refuses infinite values only, and there are none.
    static_cast<void>(streams_[s].push(readings_));
  }
  samples_ += samples.size();
  figures_are_old_ = true;
}

void NoiseWatch::refresh(std::chrono::steady_clock::time_point host_now) {
  if (!figures_are_old_ || host_now < next_refresh_) return;
  next_refresh_ = host_now + kNoiseRefresh;
  figures_are_old_ = false;
  const std::size_t multiple = nearest_multiple(kFigureTau_s * rate_hz_);
  const std::lock_guard lock(mutex_);
  figures_.gyro_dps = three_at(streams_, 0, multiple);
  figures_.accel_mps2 = three_at(streams_, 3, multiple);
}

json NoiseWatch::document(const std::string& serial) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::vector<AllanStream::Point>> points;
  for (const AllanStream& stream : streams_) points.push_back(reliable_points(stream));
  const auto& longest = *std::ranges::max_element(points, {}, &std::vector<AllanStream::Point>::size);
  json tau_s = json::array();
  for (const AllanStream::Point& point : longest) tau_s.push_back(static_cast<double>(point.multiple) / rate_hz_);
  json sensors = json::object();
  for (const calib::Sensor sensor : calib::kSensors) {
    const auto& of = points[calib::index_of(sensor)];
    const double factor = calib::printed_per_si(sensor);
    sensors[std::string(calib::name_of(sensor))] = {
        {"unit", calib::printed_unit(sensor)},
        {"oadev", deviation_list(of, &AllanStream::Point::overlapping, factor, longest.size())},
        {"mdev", deviation_list(of, &AllanStream::Point::modified, factor, longest.size())}};
  }
  return {{"unit", serial},
          {"rate_hz", rate_hz_},
          {"samples", samples_},
          {"tau_s", std::move(tau_s)},
          {"sensors", std::move(sensors)}};
}

}  // namespace soak::station
