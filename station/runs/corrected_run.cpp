// SPDX-License-Identifier: Apache-2.0
#include "station/runs/corrected_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text.h"
#include "calib/forward/thermal_history.h"
#include "calib/runtime/soak_history.h"
#include "station/import/channel.h"
#include "station/io/csv_scanner.h"

namespace soak::station {
namespace {

constexpr double kBlock_s = 30.0;
/// Between steps of the thermal history, each with the mean of the readings since the last: the laboratory finds the
/// effect in means of as much, and what a reading scatters by is no way.
constexpr double kStep_s = 10.0;
constexpr std::int32_t kMoves = -1;

/// What firmware keeps of a file.
struct Device {
  soak_cal cal{};
  soak_terms terms{};
  soak_history history{};
};

base::Status load(const base::Bytes& file, Device& device) {
  const bool good = soak_load(&device.cal, file.data(), file.size()) == SOAK_OK &&
                    soak_load_terms(&device.terms, &device.cal) >= SOAK_OK &&
                    soak_load_history(&device.history, &device.cal) >= SOAK_OK;
  if (good) return {};
  return base::corrupt("the deployment runtime cannot load the file", "calibration file");
}

/// Sums over the rows of a block.
struct Sums {
  std::size_t rows = 0;
  double t_s = 0.0;
  double temp_c = 0.0;
  std::array<double, calib::kSensorCount> raw{};
  std::array<std::size_t, calib::kSensorCount> raw_rows{};
  std::array<double, calib::kSensorCount> corrected{};
  std::array<std::size_t, calib::kSensorCount> corrected_rows{};

  [[nodiscard]] CorrectedBlock block(std::string position) const {
    CorrectedBlock made;
    made.position = std::move(position);
    made.t_s = t_s / static_cast<double>(rows);
    made.temp_c = temp_c / static_cast<double>(rows);
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      if (raw_rows[s] > 0) made.raw[s] = raw[s] / static_cast<double>(raw_rows[s]);
      if (corrected_rows[s] > 0) made.corrected[s] = corrected[s] / static_cast<double>(corrected_rows[s]);
    }
    return made;
  }
};

bool is_left_raw(std::uint32_t flags, std::size_t sensor) {
  return (flags & (SOAK_FLAG_ABSENT(sensor) | SOAK_FLAG_INVALID(sensor))) != 0U;
}

/// The unit's thermometer where it read something, for the slope that the moving terms want.
calib::forward::Series rate_of(const calib::Recording& recording) {
  calib::forward::Series temp_c;
  for (std::size_t k = 0; k < recording.rows(); ++k) {
    if (!std::isfinite(recording.temp_c[k])) continue;
    temp_c.t_s.push_back(recording.t_s[k]);
    temp_c.values.push_back(recording.temp_c[k]);
  }
  return calib::forward::rate_of(temp_c);
}

std::int32_t position_at(const calib::Recording& recording, std::size_t row) {
  return recording.position.empty() ? 0 : recording.position[row];
}

std::string position_name(const calib::Recording& recording, std::int32_t position) {
  return recording.position.empty() || position == kMoves
             ? ""
             : recording.positions[static_cast<std::size_t>(position)].label;
}

/// Corrects one row after the other.
class Corrector {
 public:
  Corrector(Device device, const calib::Recording& recording) : device_(device), recording_(recording) {
    raw_.fill(std::numeric_limits<float>::quiet_NaN());
    if (device_.terms.count > 0) rate_ = rate_of(recording);
  }

  void add(std::size_t row, Sums& sums) {
    const auto temp_c = static_cast<float>(recording_.temp_c[row]);
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      const auto& values = recording_.sensor[s];
      fresh_[s] = !values.empty() && std::isfinite(values[row]);
      if (fresh_[s]) raw_[s] = static_cast<float>(values[row]);
    }
    step(recording_.t_s[row], temp_c);
    const float rate_kps = rate_.empty() ? 0.0F : static_cast<float>(rate_.at(recording_.t_s[row]));
    std::array<float, calib::kSensorCount> out{};
    std::uint32_t flags = 0;
    const soak_status status = soak_apply_history(&device_.cal, &device_.terms, &device_.history, temp_c, rate_kps,
                                                  raw_.data(), out.data(), &flags);
    if (status < SOAK_OK || !std::isfinite(temp_c)) return;
    ++rows;
    if ((flags & 0x3FU) != 0U) ++clamped;
    if (position_at(recording_, row) != kMoves) add(row, out, flags, sums);
  }

  [[nodiscard]] double unknown() const {
    double most = 0.0;
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      if (device_.history.width_c[s] > 0.0F)
        most = std::max(most, static_cast<double>(device_.history.state.unknown[s]));
    }
    return most;
  }

  std::size_t rows = 0;
  std::size_t clamped = 0;

 private:
  /// The first reading at once, then means.
  void step(double t_s, float temp_c) {
    if (!std::isfinite(temp_c)) return;
    if (readings_ > 0 && t_s >= step_s_) {
      (void)soak_history_step(&device_.history, static_cast<float>(readings_c_ / static_cast<double>(readings_)));
      readings_c_ = 0.0;
      readings_ = 0;
    }
    if (readings_ == 0) step_s_ = t_s + kStep_s;
    readings_c_ += static_cast<double>(temp_c);
    ++readings_;
    if (device_.history.state.begun == 0U) (void)soak_history_step(&device_.history, temp_c);
  }

  void add(std::size_t row, const std::array<float, calib::kSensorCount>& out, std::uint32_t flags, Sums& sums) const {
    ++sums.rows;
    sums.t_s += recording_.t_s[row];
    sums.temp_c += recording_.temp_c[row];
    for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
      if (!fresh_[s]) continue;
      sums.raw[s] += static_cast<double>(raw_[s]);
      ++sums.raw_rows[s];
      if (is_left_raw(flags, s)) continue;
      sums.corrected[s] += static_cast<double>(out[s]);
      ++sums.corrected_rows[s];
    }
  }

  Device device_;
  const calib::Recording& recording_;
  calib::forward::Series rate_;
  double step_s_ = 0.0;  ///< when the history is stepped next
  double readings_c_ = 0.0;
  std::size_t readings_ = 0;
  std::array<float, calib::kSensorCount> raw_{};
  std::array<bool, calib::kSensorCount> fresh_{};
};

std::string cell(const std::optional<double>& value, calib::Sensor sensor) {
  return value ? fmt::format(",{:.8g}", *value * calib::printed_per_si(sensor)) : ",";
}

}  // namespace

base::Result<CorrectedRun> correct_run(const base::Bytes& file, const calib::Recording& recording, double past) {
  Device device;
  if (auto loaded = load(file, device); !loaded) return base::forward_error(loaded);
  soak_history_start(&device.history, static_cast<float>(past));
  CorrectedRun run;
  run.moving = device.terms.count > 0;
  run.history = device.history.count > 0;
  Corrector corrector(device, recording);
  Sums sums;
  double end_s = 0.0;
  std::int32_t position = kMoves;
  const auto end_block = [&] {
    if (sums.rows > 0) run.blocks.push_back(sums.block(position_name(recording, position)));
    sums = {};
  };
  for (std::size_t row = 0; row < recording.rows(); ++row) {
    if (row == 0 || recording.t_s[row] >= end_s || position_at(recording, row) != position) {
      end_block();
      end_s = recording.t_s[row] + kBlock_s;
      position = position_at(recording, row);
    }
    corrector.add(row, sums);
  }
  end_block();
  run.rows = corrector.rows;
  run.clamped = corrector.clamped;
  run.unknown_at_end = corrector.unknown();
  return run;
}

std::string corrected_csv(const CorrectedRun& run) {
  std::string text = "t_s,temp_c,position";
  std::string corrected;
  for (const calib::Sensor sensor : calib::kSensors) {
    const std::string header = canonical_header(calib::name_of(sensor));
    const std::size_t unit = header.find('_');
    text += ',' + header;
    corrected += ',' + header.substr(0, unit) + "_corrected" + header.substr(unit);
  }
  text += corrected + '\n';
  for (const CorrectedBlock& block : run.blocks) {
    text += fmt::format("{:.3f},{:.4f},{}", block.t_s, block.temp_c, csv_cell(block.position));
    for (const calib::Sensor sensor : calib::kSensors) text += cell(block.raw[calib::index_of(sensor)], sensor);
    for (const calib::Sensor sensor : calib::kSensors) text += cell(block.corrected[calib::index_of(sensor)], sensor);
    text += '\n';
  }
  return text;
}

}  // namespace soak::station
