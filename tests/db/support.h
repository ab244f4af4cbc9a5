// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "base/random.h"
#include "db/catalog/catalog.h"
#include "db/run/run_file.h"

/// What several tests of the room db need.
namespace soak::db::testing {

/// A folder of its own, removed at the end of its scope.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "soak-db-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
    path_ = name;
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

template <class T>
constexpr SampleType type_of() {
  if constexpr (std::is_same_v<T, double>) return SampleType::f64;
  if constexpr (std::is_same_v<T, float>) return SampleType::f32;
  if constexpr (std::is_same_v<T, std::int8_t>) return SampleType::i8;
  if constexpr (std::is_same_v<T, std::uint8_t>) return SampleType::u8;
  if constexpr (std::is_same_v<T, std::int16_t>) return SampleType::i16;
  if constexpr (std::is_same_v<T, std::uint16_t>) return SampleType::u16;
  if constexpr (std::is_same_v<T, std::int32_t>) return SampleType::i32;
  if constexpr (std::is_same_v<T, std::uint32_t>) return SampleType::u32;
  return SampleType::i64;
}

template <class T>
Column column_of(const std::vector<T>& numbers, std::vector<std::uint8_t> present = {}) {
  Column column{type_of<T>(), base::Bytes(numbers.size() * sizeof(T)), std::move(present)};
  if (!numbers.empty()) std::memcpy(column.raw.data(), numbers.data(), column.raw.size());
  for (std::size_t row = 0; row < column.present.size(); ++row) {
    if (column.present[row] == 0) std::memset(column.raw.data() + row * sizeof(T), 0, sizeof(T));
  }
  return column;
}

/// Times first, first + 1, ... in steps of `step_s`.
inline std::vector<double> times(std::size_t count, double step_s, std::size_t first = 0) {
  std::vector<double> t_s(count);
  for (std::size_t i = 0; i < count; ++i) t_s[i] = static_cast<double>(first + i) * step_s;
  return t_s;
}

inline std::vector<float> noise(std::size_t count, std::uint64_t stream) {
  base::Random random(1, stream);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(random.gaussian());
  return values;
}

inline RunInfo run_info() {
  RunInfo info;
  info.run_id = "01890a5d-ac96-774b-bcce-b302099a8057";
  info.label = "day 1, \"cold\"";
  info.campaign = "c1";
  info.procedure = "soak";
  info.purpose = "verification";
  info.created_utc_s = 1700000000.125;
  info.clock_rate = 20.0;
  info.simulated = true;
  info.source = "import a.csv";
  info.site.latitude_deg = -33.85;
  info.site.gravity_mps2 = 9.797;
  return info;
}

inline ChannelInfo channel(std::string name, SampleType type, std::string unit = "") {
  ChannelInfo info;
  info.name = std::move(name);
  info.type = type;
  info.unit = std::move(unit);
  return info;
}

/// Stream "imu" of unit SN1: t_s (f64) and value (f32).
inline StreamInfo noise_stream() {
  return {"imu", "SN1", {channel("t_s", SampleType::f64, "s"), channel("value", SampleType::f32, "dps")}};
}

/// A sealed file with `rows` rows of noise_stream().
inline void write_noise_file(const std::filesystem::path& path, std::size_t rows) {
  auto writer = RunFileWriter::create(path, run_info());
  ASSERT_TRUE(writer) << writer.error().message;
  ASSERT_TRUE(writer->add_stream(noise_stream()));
  ASSERT_TRUE(writer->append(0, {column_of(times(rows, 0.01)), column_of(noise(rows, 7))}));
  const auto sealed = writer->seal();
  ASSERT_TRUE(sealed) << sealed.error().message;
}

inline std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs `work` in a child process; its return value is the exit status. Returns the process id.
inline pid_t in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  return child;
}

/// Exit status of a child; -signal where one ended it.
inline int status_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace soak::db::testing
