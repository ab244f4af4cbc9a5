// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "db/catalog/catalog.h"
#include "tests/db/sample_catalog.h"
#include "tests/db/support.h"

/// A data folder with runs whose files are there.
namespace soak::station::testing {

inline constexpr std::size_t kStoredRows = 100'000;  // 1000 s at 100 Hz
inline constexpr std::size_t kSlowEvery = 50;
inline constexpr const char* kStoredRunId = db::testing::kRunId;

/// What the file of stored_run() holds, in memory.
struct StoredNumbers {
  std::vector<double> t_s = db::testing::times(kStoredRows, 0.01);
  std::vector<float> gyro_x = db::testing::noise(kStoredRows, 7);
  std::vector<std::int16_t> accel_x;  ///< counts of 0.001 g
  std::vector<float> temp_c;          ///< one in kSlowEvery rows

  StoredNumbers() : accel_x(kStoredRows), temp_c(kStoredRows) {
    for (std::size_t i = 0; i < kStoredRows; ++i) {
      accel_x[i] = static_cast<std::int16_t>(1000 + static_cast<int>(20.0F * gyro_x[i]));
      temp_c[i] = 20.0F + 1e-4F * static_cast<float>(i);
    }
  }
};

/// A row of the catalog for a run whose file holds `numbers`, a chamber's log and unit SN1; writes the file.
inline db::RunRow stored_run(const db::Catalog& catalog, const StoredNumbers& numbers,
                             const std::string& run_id = kStoredRunId, const std::string& label = "r1") {
  using db::SampleType;
  using db::testing::channel;
  using db::testing::column_of;
  db::RunRow row = db::testing::run_row(run_id, label);
  row.rows = kStoredRows;
  db::RunInfo info = db::testing::run_info();
  info.run_id = run_id;
  auto file = db::RunFileWriter::create(catalog.run_file_path(row), info);
  db::ChannelInfo accel = channel("accel_x", SampleType::i16, "g");
  accel.scale = 0.001;
  std::vector<std::uint8_t> slow(kStoredRows);
  for (std::size_t i = 0; i < kStoredRows; i += kSlowEvery) slow[i] = 1;
  const auto imu = file->add_stream({"imu",
                                     "SN1",
                                     {channel("t_s", SampleType::f64, "s"), channel("gyro_x", SampleType::f32, "dps"),
                                      accel, channel("temp_c", SampleType::f32, "c")}});
  const auto chamber = file->add_stream(
      {"chamber", "", {channel("t_s", SampleType::f64, "s"), channel("chamber_c", SampleType::f64, "c")}});
  const bool written =
      imu && chamber &&
      file->append(*imu, {column_of(numbers.t_s), column_of(numbers.gyro_x), column_of(numbers.accel_x),
                          column_of(numbers.temp_c, slow)}) &&
      file->append(*chamber, {column_of(db::testing::times(1000, 1.0)), column_of(std::vector<double>(1000, -20.0))});
  const auto sealed = file->seal();
  if (!written || !sealed) throw std::runtime_error("cannot write the run file");
  row.file_sha256 = *sealed;
  return row;
}

}  // namespace soak::station::testing
