// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/segments/long_run.h"
#include "db/run/run_file.h"
#include "station/import/channel.h"

namespace soak::station {

/// A unit's rows in a run file, stretch by stretch, as read_axes() and read_sensor() give them for the whole run; of
/// the auxiliary channels only the visits. Keeps the last block of each channel: rows that are asked for in order are
/// read once.
class LongRunRows : public calib::RunRows {
 public:
  /// Null where the run holds what cannot be read in parts: rates of the fixture, times since power-on, thermometers of
  /// single sensors; and where set points, positions or temperatures are missing. `file` must stay where it is. Reads
  /// the slow channels once.
  [[nodiscard]] static base::Result<std::unique_ptr<LongRunRows>> open(const db::RunFileReader& file,
                                                                       std::string_view unit);

  [[nodiscard]] std::size_t rows() const override { return rows_; }
  [[nodiscard]] base::Result<calib::Recording> axes(std::size_t first, std::size_t last) override;
  [[nodiscard]] bool has(calib::Sensor sensor) const override {
    return channel_named(calib::name_of(sensor)) != nullptr;
  }
  [[nodiscard]] base::Status samples(calib::Sensor sensor, std::size_t first, std::size_t last,
                                     std::vector<double>& values) override;

 private:
  /// One channel and the block of it that was read last.
  struct Channel {
    std::size_t index = 0;
    Conversion to_si{};
    bool is_si = false;
    double hold_s = 0.0;  ///< of slow channels
    std::optional<std::size_t> block = {};
    std::vector<double> values = {};
  };

  LongRunRows(const db::RunFileReader& file, std::string_view unit, std::size_t stream)
      : file_(file), unit_(unit), stream_(stream), rows_(file.rows(stream)) {}
  [[nodiscard]] const Channel* channel_named(std::string_view name) const;
  [[nodiscard]] base::Status find_hold_limits();
  [[nodiscard]] base::Status read(std::string_view name, std::size_t first, std::size_t last,
                                  std::vector<double>& values);
  [[nodiscard]] base::Status read_block(Channel& channel, std::size_t block);
  [[nodiscard]] base::Status read_held(std::string_view name, std::size_t first, std::size_t last,
                                       std::vector<double>& values);
  [[nodiscard]] base::Status read_labels(std::size_t first, std::size_t last, calib::Recording& recording);
  [[nodiscard]] base::Status read_positions_of(std::size_t first, std::size_t last, calib::Recording& recording);

  const db::RunFileReader& file_;
  std::string unit_;
  std::size_t stream_;
  std::size_t rows_;
  std::map<std::string, Channel, std::less<>> channels_;
  std::map<std::string, std::vector<std::string>, std::less<>> labels_;  ///< of the label channels
  std::vector<calib::Position> defined_;
  std::vector<double> scratch_;
};

}  // namespace soak::station
