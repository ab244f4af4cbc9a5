// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <memory>

#include "base/bytes.h"
#include "base/hash.h"
#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/fuzz/runtime_c/exercise.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

/// Encoding takes a hundred times as long as reading: one file in so many.
constexpr std::uint32_t kEncodeOneIn = 64;

/// Sections that the runtime passes over: references, temperatures visited one way, accepted terms.
constexpr std::array<std::uint32_t, 3> kPassedOver = {0x0002, 0x0015, SOAK_SECTION_TERM};

bool has_passed_over(const soak_cal& cal, Input bytes) {
  for (std::uint32_t at = cal.sections[0]; at < cal.sections[1]; at += 8U + soak_u32(bytes.data() + at + 4)) {
    if (std::ranges::find(kPassedOver, soak_u16(bytes.data() + at)) != kPassedOver.end()) return true;
  }
  return false;
}

void check_agreement(const soak_cal& cal, const calib::Calibration& calibration) {
  require(calibration.simulated == (cal.simulated != 0), "both readers agree on the simulated bit");
  std::size_t present = 0;
  for (const soak_sensor& sensor : cal.sensor) present += sensor.present;
  require(present == calibration.sensors.size(), "both readers find as many sensors");
  for (const calib::SensorCalibration& sensor : calibration.sensors) {
    const soak_sensor& other = cal.sensor[calib::index_of(sensor.sensor)];
    require(other.present != 0, "both readers find the same sensors");
    require(static_cast<float>(sensor.temp_min_c) == other.temp_min_c, "both readers find the same range");
    require(static_cast<float>(sensor.temp_max_c) == other.temp_max_c, "both readers find the same range");
    require(sensor.scale_ppm.has_value() == (other.curve[1].payload != nullptr), "both readers find a scale curve");
    for (const double temp_c : {sensor.temp_min_c, 20.0, sensor.temp_max_c}) (void)evaluate(sensor.bias, temp_c);
  }
  require(calibration.accel_misalignment.has_value() == (cal.misalignment != nullptr), "both find a misalignment");
  require(calibration.g_sensitivity.has_value() == (cal.g_sensitivity != nullptr), "both find a g-sensitivity");
}

void check_encoder(const calib::Calibration& calibration) {
  const auto again = calib::encode(calibration);
  require(again || again.error().kind == base::ErrorKind::bad_input, "a file that was read is written or refused");
}

/// Whether both readers accept the file.
bool check(Input input) {
  // Exactly as large as the file, so that a sanitizer sees the first byte read beyond it.
  const auto exact = std::make_unique<std::uint8_t[]>(input.size());
  std::copy(input.begin(), input.end(), exact.get());
  const Input file(exact.get(), input.size());

  const char* broken = nullptr;
  const int status = runtime_exercise(file.data(), file.size(), &broken);
  require(broken == nullptr, broken == nullptr ? "" : broken);
  soak_cal cal;
  require(soak_load(&cal, file.data(), file.size()) == status, "the runtime as C and as C++ say the same");
  const auto calibration = calib::decode(file);
  if (status != SOAK_OK) {
    require(!calibration, "what the runtime refuses decode() refuses");
    require(!calibration.error().message.empty(), "a refusal says why");
    return false;
  }
  require(calibration || has_passed_over(cal, file), "what the runtime accepts decode() accepts");
  if (!calibration) return false;
  check_agreement(cal, *calibration);
  if (base::crc32c(file) % kEncodeOneIn == 0) check_encoder(*calibration);
  return true;
}

/// With magic, size field and CRC made right: no fuzzer finds a CRC.
bool check_sealed(Input input) {
  constexpr std::size_t kShortest = 28;
  if (input.size() < kShortest) return false;
  base::Bytes bytes(input.begin(), input.end());
  static constexpr std::uint8_t kMagic[] = {0x89, 'S', 'O', 'A', 'K', 0x0D, 0x0A, 0x1A};
  std::copy(std::begin(kMagic), std::end(kMagic), bytes.begin());
  const auto size = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(bytes.data() + 12, &size, sizeof size);
  const std::uint32_t crc = base::crc32c(std::span(bytes).first(bytes.size() - 4));
  std::memcpy(bytes.data() + bytes.size() - 4, &crc, sizeof crc);
  return check(bytes);
}

}  // namespace

bool runtime_load(Input input) {
  (void)check(input);
  return check_sealed(input);
}

}  // namespace soak::fuzz
