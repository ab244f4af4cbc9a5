// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "db/run/run_file.h"

/// A run file with what makes reading and reducing a run hard.
namespace soak::station::testing {

template <class T>
db::Column tricky_column(db::SampleType type, const std::vector<double>& numbers, double missing_share,
                         base::Random& random, std::size_t every = 1) {
  db::Column column{type, base::Bytes(numbers.size() * sizeof(T)), std::vector<std::uint8_t>(numbers.size(), 1)};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    column.present[i] = i % every == 0 && random.uniform() >= missing_share ? 1 : 0;
    const auto number = static_cast<T>(numbers[i]);
    if (column.present[i] != 0) std::memcpy(column.raw.data() + i * sizeof(T), &number, sizeof(T));
  }
  return column;
}

/// 300 s at 100 Hz of unit SN1: two plateaus of three positions each with ramps and moves between, gaps in time, a
/// clock that resumes minutes later, sensors of several types and units with missing, stuck, clipped and knocked
/// samples, NaN among the numbers, slow thermometers, set points and labels in few rows. What of it occurs depends on
/// the seed.
inline void write_tricky_run(const std::filesystem::path& path, std::uint64_t seed) {
  constexpr std::size_t kRows = 30000;
  base::Random random(seed, 21);
  const auto now_and_then = [&](double share) { return random.uniform() < share; };
  std::vector<double> t_s(kRows);
  std::vector<double> temp(kRows);
  std::vector<double> plateau(kRows);
  std::vector<double> position(kRows);
  std::vector<double> phase(kRows);
  std::vector<std::vector<double>> sensor(6, std::vector<double>(kRows));
  double t = now_and_then(0.5) ? 0.0 : 1.7e9;
  const bool jitter = now_and_then(0.3);
  const bool resumes = now_and_then(0.5);
  const double lsb = now_and_then(0.5) ? 0.01 : 1e-6;
  for (std::size_t i = 0; i < kRows; ++i) {
    const std::size_t leg = i / 5000;
    t += 0.01 * (jitter ? random.uniform(0.2, 1.8) : 1.0);
    if (i == 8000) t += 11.0;
    if (i == 21000 && resumes) t += 400.0;
    t_s[i] = t;
    plateau[i] = leg < 3 ? 20.0 : 30.0;
    temp[i] = plateau[i] + 0.3 + 1e-4 * static_cast<double>(i % 5000) + 0.01 * random.gaussian();
    position[i] = static_cast<double>(leg % 3);
    phase[i] = i % 15000 < 1500 ? 1.0 : 0.0;
    for (std::size_t s = 0; s < 6; ++s) {
      const double force = s == 3 + leg % 3 ? 9.8 : 0.0;
      sensor[s][i] = lsb * std::round((force + 0.1 + 0.02 * random.gaussian()) / lsb);
    }
  }
  for (std::size_t s = 0; s < 6; ++s) {
    const auto from = static_cast<std::size_t>(random.uniform(0.0, 25000.0));
    if (now_and_then(0.3)) std::fill_n(sensor[s].begin() + static_cast<std::ptrdiff_t>(from), 900, sensor[s][from]);
    if (now_and_then(0.3)) {
      for (double& v : sensor[s]) v = std::min(v, 0.11);
    }
    if (now_and_then(0.3)) sensor[s][from] += 5.0;
  }
  if (now_and_then(0.5)) sensor[2][3000] = sensor[3][3000] = std::numeric_limits<double>::quiet_NaN();
  if (now_and_then(0.2)) sensor[2][12000] = std::numeric_limits<double>::infinity();
  if (now_and_then(0.3)) sensor[5].assign(kRows, 1.5);

  const auto channel = [](const std::string& name, db::SampleType type, const std::string& unit, double scale = 1.0) {
    return db::ChannelInfo{name, name, type, unit, scale, 0.0, {}};
  };
  const auto counts = [](std::vector<double> values, double scale) {
    for (double& v : values) v = std::clamp(std::round(v / scale), -32768.0, 32767.0);
    return values;
  };
  using enum db::SampleType;
  db::StreamInfo stream{"imu", "SN1", {}};
  std::vector<db::Column> columns;
  const auto add = [&](db::ChannelInfo info, db::Column column) {
    stream.channels.push_back(std::move(info));
    columns.push_back(std::move(column));
  };
  add(channel("t_s", f64, "s"), tricky_column<double>(f64, t_s, 0.0, random));
  columns.back().present.clear();
  const double missing = now_and_then(0.5) ? 0.0 : 0.03;
  add(channel("gyro_x", i16, "dps", 1e-3), tricky_column<std::int16_t>(i16, counts(sensor[0], 1e-3), missing, random));
  add(channel("gyro_y", f32, "rps"), tricky_column<float>(f32, sensor[1], 0.0, random, now_and_then(0.3) ? 4 : 1));
  add(channel("gyro_z", f64, "rps"), tricky_column<double>(f64, sensor[2], missing, random));
  add(channel("accel_x", f32, "g"), tricky_column<float>(f32, sensor[3], now_and_then(0.2) ? 0.5 : 0.0, random));
  add(channel("accel_y", i32, "mps2", 1e-4), tricky_column<std::int32_t>(i32, counts(sensor[4], 1e-3), 0.0, random));
  if (now_and_then(0.7)) add(channel("accel_z", f32, "mps2"), tricky_column<float>(f32, sensor[5], 0.0, random));
  for (double& v : temp) v += 273.15;
  add(channel("temp_c", f64, "k"), tricky_column<double>(f64, temp, now_and_then(0.3) ? 0.9 : 0.0, random, 50));
  if (now_and_then(0.4)) add(channel("temp_ax_c", f32, "k"), tricky_column<float>(f32, temp, 0.1, random, 300));
  if (now_and_then(0.8)) add(channel("plateau_c", f32, "c"), tricky_column<float>(f32, plateau, 0.0, random, 100));
  add(channel("position", u8, "label"),
      tricky_column<std::uint8_t>(u8, position, now_and_then(0.3) ? 1e-4 : 0, random));
  stream.channels.back().labels = {"+X", "+Y", "+Z", "-Z"};
  add(channel("phase", u8, "label"), tricky_column<std::uint8_t>(u8, phase, 0.001, random));
  stream.channels.back().labels = {"soak", "ramp"};

  db::RunInfo info;
  info.run_id = "01920000-0000-7000-8000-000000000000";
  auto file = db::RunFileWriter::create(path, info);
  if (!file || !file->add_stream(stream) || !file->append(0, columns) || !file->seal()) {
    throw std::runtime_error("cannot write " + path.string());
  }
}

}  // namespace soak::station::testing
