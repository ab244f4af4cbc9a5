// SPDX-License-Identifier: Apache-2.0
// The thermal history that the deployment runtime follows on a device, with files of this test's own: what the formats
// and docs/gap-terms.md say, written out in double precision. Against the simulation:
// tests/forward/device_history_test.cpp.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "calib/deploy/calibration_file.h"
#include "calib/model/deployed_terms.h"
#include "calib/runtime/soak_history.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/runtime_c/runtime_as_c.h"

namespace soak::calib {
namespace {

using namespace samples;
using Six = std::array<float, 6>;

constexpr double kWidth_c = 8.0;
constexpr float kNoTemperature = std::numeric_limits<float>::quiet_NaN();
constexpr Six kRaw = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};

/// gyro_x remembers with the size of 0.02 + 1e-4 (T - 20) rad/s; its curve keeps 0.004 at 0 °C to 0.008 at 40 °C.
AcceptedTerm memory_of_gyro_x() {
  return {"thermal_hysteresis",
          false,
          {Sensor::gyro_x},
          {{"amplitude", 0.02},
           {"amplitude_per_c", 1e-4},
           {"width_c", kWidth_c},
           {"reference_c", 20.0},
           {"mean_1_c", 0.0},
           {"mean_1", 0.004},
           {"mean_2_c", 40.0},
           {"mean_2", 0.008}}};
}

Calibration with(std::vector<AcceptedTerm> terms) {
  Calibration calibration = golden_mixed();
  calibration.terms = std::move(terms);
  return calibration;
}

/// A file in memory with what the runtime loads from it.
struct Device {
  base::Bytes bytes;
  soak_cal cal{};
  soak_terms terms{};
  soak_history history{};
  soak_status status = SOAK_E_ARGUMENT;

  explicit Device(const Calibration& calibration) : bytes(*encode(calibration)) {
    EXPECT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    EXPECT_GE(soak_load_terms(&terms, &cal), SOAK_OK);
    status = soak_load_history(&history, &cal);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void go(double from_c, double to_c) {
    constexpr int kSteps = 200;
    for (int k = 0; k <= kSteps; ++k) {
      EXPECT_EQ(soak_history_step(&history, static_cast<float>(std::lerp(from_c, to_c, k / double{kSteps}))), SOAK_OK);
    }
  }
  [[nodiscard]] Six apply(double temp_c, const Six& raw, std::uint32_t& flags) const {
    Six out{};
    EXPECT_GE(
        soak_apply_history(&cal, &terms, &history, static_cast<float>(temp_c), 0.0F, raw.data(), out.data(), &flags),
        SOAK_OK);
    return out;
  }
  [[nodiscard]] Six still(double temp_c, const Six& raw) const {
    Six out{};
    std::uint32_t flags = 0;
    EXPECT_GE(soak_apply(&cal, static_cast<float>(temp_c), raw.data(), out.data(), &flags), SOAK_OK);
    return out;
  }
};

TEST(RuntimeHistory, TakesOffWhatTheMemoryAddsBeyondTheMean) {
  Device device(with({memory_of_gyro_x()}));
  ASSERT_EQ(device.status, SOAK_OK);
  soak_history_start(&device.history, -1.0F);
  device.go(0.0, 30.0);
  // The dead band takes a quarter of a kelvin off the way.
  const double memory = 1.0 - 2.0 * std::exp(-29.75 / kWidth_c);
  const double added = (0.02 + 1e-4 * 10.0) * memory - 0.007;
  Six freed = kRaw;
  freed[0] -= static_cast<float>(added);
  std::uint32_t flags = 0;
  const Six out = device.apply(30.0, kRaw, flags);
  const Six expected = device.still(30.0, freed);
  // A way of less than 1/512 K still waits.
  EXPECT_NEAR(out[0], expected[0], 0.021 * 2.0 / 512.0 / kWidth_c * std::exp(-29.75 / kWidth_c) + 1e-6);
  for (std::size_t i = 1; i < 6; ++i) EXPECT_EQ(out[i], expected[i]) << i;
}

TEST(RuntimeHistory, OfAnUnknownPastIsZeroAndKnownWithTheWay) {
  Device device(with({memory_of_gyro_x()}));
  float bound = 0.0F;
  ASSERT_EQ(soak_history_unknown(&device.history, SOAK_GYRO_X, 20.0F, &bound), SOAK_OK);
  EXPECT_FLOAT_EQ(bound, 0.02F);
  EXPECT_EQ(soak_history_unknown(&device.history, SOAK_GYRO_Y, 20.0F, &bound), SOAK_OK);
  EXPECT_EQ(bound, 0.0F);
  Device heated(with({memory_of_gyro_x()}));
  Device cooled(with({memory_of_gyro_x()}));
  soak_history_start(&heated.history, 1.0F);
  soak_history_start(&cooled.history, -1.0F);
  double from_c = 20.0;
  for (const double to_c : {26.0, 14.0, 30.0, 29.0}) {
    for (Device* each : {&device, &heated, &cooled}) each->go(from_c, to_c);
    ASSERT_EQ(soak_history_unknown(&device.history, SOAK_GYRO_X, 20.0F, &bound), SOAK_OK);
    const double off = 0.02 * std::max(std::abs(device.history.state.memory[0] - heated.history.state.memory[0]),
                                       std::abs(device.history.state.memory[0] - cooled.history.state.memory[0]));
    EXPECT_LE(off, bound * (1.0 + 1e-4) + 1e-8) << to_c;
    EXPECT_GT(off, 0.9 * bound - 1e-8) << to_c;
    from_c = to_c;
  }
  EXPECT_LT(bound, 0.02F * 0.05F);  // after more than three widths
  ASSERT_EQ(soak_history_unknown(&heated.history, SOAK_GYRO_X, 20.0F, &bound), SOAK_OK);
  EXPECT_EQ(bound, 0.0F);
}

TEST(RuntimeHistory, HoldsWhereTheThermometerFails) {
  Device device(with({memory_of_gyro_x()}));
  soak_history_start(&device.history, 1.0F);
  for (const float bad : {kNoTemperature, std::numeric_limits<float>::infinity(), -300.0F, 1e9F}) {
    EXPECT_EQ(soak_history_step(&device.history, bad), SOAK_INVALID);
    EXPECT_EQ(device.history.state.begun, 0U);
  }
  device.go(20.0, 10.0);
  const float before = device.history.state.memory[0];
  for (const float bad : {kNoTemperature, -std::numeric_limits<float>::infinity(), -300.0F, 1e9F}) {
    EXPECT_EQ(soak_history_step(&device.history, bad), SOAK_INVALID);
  }
  EXPECT_EQ(device.history.state.memory[0], before);
  Six out{};
  std::uint32_t flags = 0;
  EXPECT_EQ(soak_apply_history(&device.cal, &device.terms, &device.history, kNoTemperature, 0.0F, kRaw.data(),
                               out.data(), &flags),
            SOAK_INVALID);
  EXPECT_EQ(out, kRaw);
  // A gap counts as one way.
  EXPECT_EQ(soak_history_step(&device.history, 40.0F), SOAK_OK);
  EXPECT_NEAR(device.history.state.memory[0], 1.0 - (1.0 - before) * std::exp(-29.5 / kWidth_c), 1e-6);
}

TEST(RuntimeHistory, GoesOnAfterAPowerCycle) {
  Device device(with({memory_of_gyro_x()}));
  device.go(20.0, 35.0);
  const soak_memory kept = device.history.state;
  Device restarted(with({memory_of_gyro_x()}));
  ASSERT_EQ(soak_history_resume(&restarted.history, &kept), SOAK_OK);
  device.go(34.0, 12.0);
  restarted.go(34.0, 12.0);
  EXPECT_EQ(restarted.history.state.memory[0], device.history.state.memory[0]);
  EXPECT_EQ(restarted.history.state.unknown[0], device.history.state.unknown[0]);
  soak_memory broken = kept;
  broken.memory[3] = 1.5F;
  EXPECT_EQ(soak_history_resume(&restarted.history, &broken), SOAK_INVALID);
  EXPECT_EQ(restarted.history.state.unknown[0], 1.0F);
  broken = kept;
  broken.followed_c = kNoTemperature;
  EXPECT_EQ(soak_history_resume(&restarted.history, &broken), SOAK_INVALID);
}

TEST(RuntimeHistory, IsTheSameAsCAndWithoutItAsAlways) {
  const Calibration calibration =
      with({memory_of_gyro_x(), {"temperature_rate", false, {Sensor::gyro_x}, {{"per_kps", 0.01}}}});
  Device device(calibration);
  const Six path = {5.0F, 25.0F, 12.0F, 12.1F, kNoTemperature, 30.0F};
  for (const float temp_c : path) (void)soak_history_step(&device.history, temp_c);
  std::uint32_t flags = 0;
  const Six out = device.apply(30.0, kRaw, flags);
  Six in_c{};
  std::uint32_t flags_in_c = 0;
  EXPECT_EQ(runtime_as_c_apply_history(device.bytes.data(), device.bytes.size(), path.data(), path.size(), 0.0F,
                                       kRaw.data(), in_c.data(), &flags_in_c),
            SOAK_ABSENT);
  EXPECT_EQ(in_c, out);
  EXPECT_EQ(flags_in_c, flags);

  Device without(with({}));
  EXPECT_EQ(without.status, SOAK_ABSENT);
  without.go(0.0, 30.0);
  EXPECT_EQ(without.apply(30.0, kRaw, flags), without.still(30.0, kRaw));
}

/// Overwrites four bytes, and mends the check sum.
void overwrite(base::Bytes& file, std::size_t at, std::uint32_t bits) {
  const auto put = [&](std::size_t where, std::uint32_t number) {
    for (std::size_t k = 0; k < 4; ++k) file[where + k] = static_cast<std::uint8_t>(number >> (8 * k));
  };
  put(at, bits);
  put(file.size() - 4, soak_crc32c(file.data(), file.size() - 4));
}

/// Overwrites a number of the file's only term.
void write_parameter(base::Bytes& file, std::size_t parameter, float value) {
  constexpr std::size_t kHead = 8;
  std::size_t at = soak_u32(file.data() + 16);
  while (soak_u16(file.data() + at) != SOAK_SECTION_TERM) at += kHead + soak_u32(file.data() + at + 4);
  overwrite(file, at + kHead + 4 + 4 * parameter, soak_bits_of(value));
}

/// The file as one of version 1.`minor_version`.
base::Bytes of_version(base::Bytes file, std::uint32_t minor_version) {
  overwrite(file, 8, 1U | minor_version << 16U);
  return file;
}

void expect_refused(const base::Bytes& file) {
  soak_cal cal;
  soak_history history;
  ASSERT_EQ(soak_load(&cal, file.data(), file.size()), SOAK_OK);
  EXPECT_EQ(soak_load_history(&history, &cal), SOAK_E_FORMAT);
  EXPECT_EQ(history.count, 0U);
  EXPECT_EQ(history.width_c[0], 0.0F);
  EXPECT_FALSE(decode(file));
}

TEST(RuntimeHistory, PassesOverWhatIsLabOnlyAndRefusesWhatBreaksTheFormat) {
  AcceptedTerm lab_only = memory_of_gyro_x();
  lab_only.lab_only = true;
  EXPECT_EQ(Device(with({lab_only})).status, SOAK_ABSENT);
  // No writer of ours makes such files: numbers are changed in the bytes, names by a letter of their own.
  const auto bytes = *encode(with({memory_of_gyro_x()}));
  for (const auto& [parameter, value] : {std::pair<std::size_t, float>{2, 0.0F}, {2, -3.0F}, {6, 0.0F}, {6, -1.0F}}) {
    base::Bytes broken = bytes;
    write_parameter(broken, parameter, value);
    expect_refused(broken);
  }
  AcceptedTerm odd = memory_of_gyro_x();
  odd.parameters.pop_back();
  EXPECT_FALSE(encode(with({odd})));
  odd.parameters.emplace_back("bean_2", 0.0);
  EXPECT_FALSE(encode(with({odd})));
  odd = memory_of_gyro_x();
  odd.parameters[2].second = 0.0;
  EXPECT_FALSE(encode(with({odd})));
}

TEST(RuntimeHistory, IsOfVersion17AndNoOtherTermNeedsIt) {
  AcceptedTerm term = memory_of_gyro_x();
  EXPECT_EQ(get<std::uint16_t>(*encode(with({term})), 10), 7);
  term.lab_only = true;
  EXPECT_EQ(get<std::uint16_t>(*encode(with({term})), 10), 0);
  term = {"temperature_rate", false, {Sensor::gyro_x}, {{"per_kps", 0.25}}};
  EXPECT_EQ(get<std::uint16_t>(*encode(with({term})), 10), 0);
}

// Files of 1.0 to 1.6 may hold a memory that says nothing of its width or of what the curves hold: nothing forbade it.
TEST(RuntimeHistory, OfAnOlderFileIsReadAndNotFollowed) {
  const base::Bytes file = of_version(*encode(with({memory_of_gyro_x()})), 6);
  base::Bytes without_width = file;
  write_parameter(without_width, 2, 0.0F);
  for (const base::Bytes& older : {file, without_width}) {
    soak_cal cal;
    soak_history history;
    ASSERT_EQ(soak_load(&cal, older.data(), older.size()), SOAK_OK);
    EXPECT_EQ(soak_load_history(&history, &cal), SOAK_ABSENT);
    const auto read = decode(older);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(read->terms[0].lab_only);
    EXPECT_TRUE(moving_terms(*read).empty());
  }
  expect_refused(of_version(without_width, 7));
}

TEST(RuntimeHistory, StaysWithinItsBoundsWhateverTheThermometerSays) {
  Device device(with({memory_of_gyro_x()}));
  std::uint32_t random = 7U;
  for (int k = 0; k < 20000; ++k) {
    random = random * 1664525U + 1013904223U;
    (void)soak_history_step(&device.history, soak_float_of(random));  // any bits
    ASSERT_LE(std::abs(device.history.state.memory[0]), 1.0F);
    ASSERT_TRUE(std::isfinite(device.history.state.followed_c));
  }
}

TEST(DeployedTerms, OfAMemoryCarryItsMeanAndComeBackWithIt) {
  ModelTerm term;
  term.name = "thermal_hysteresis";
  TermPart part;
  part.sensors = {Sensor::gyro_z};
  part.parameters = {{"amplitude", 0.25, "rad/s"}, {"width_c", 6.0, "K"}, {"starts_along", -1.0, "1"}};
  part.centre = {{-20.0, 0.5}, {0.0, 0.125}, {30.0, -0.25}};
  term.parts = {part};
  Calibration calibration = with(deployed_term(term));
  ASSERT_EQ(calibration.terms.size(), 1U);
  EXPECT_FALSE(calibration.terms[0].lab_only);
  const auto read = decode(*encode(calibration));
  ASSERT_TRUE(read);
  const std::vector<ModelTerm> back = moving_terms(*read);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].parts[0].centre, part.centre);
  EXPECT_EQ(back[0].parts[0].value("width_c"), 6.0);
  EXPECT_FALSE(back[0].parts[0].value("starts_along")) << "that is of the recording it was found in";
  EXPECT_EQ(Device(calibration).history.means[2], 3U);

  // What float32 cannot hold apart, or the file not at all, stays in the laboratory.
  term.parts[0].centre = {{20.0, 0.5}, {20.0 + 1e-9, 0.6}};
  EXPECT_TRUE(deployed_term(term)[0].lab_only);
  EXPECT_TRUE(moving_terms(with(deployed_term(term))).empty());
  term.parts[0].centre.clear();
  for (int k = 0; k < 130; ++k) term.parts[0].centre.emplace_back(k, 0.0);
  EXPECT_TRUE(deployed_term(term)[0].lab_only);
  EXPECT_TRUE(encode(with(deployed_term(term))));
}

TEST(DeployedTerms, ThatNoFileCarriesAreLabOnlyInTheModelToo) {
  TermPart part;
  part.sensors = {Sensor::gyro_z};
  part.parameters = {{"amplitude", 0.25, "rad/s"}, {"width_c", 6.0, "K"}};
  const auto of_set_points = [&](const char* name, int count) {
    ModelTerm term;
    term.name = name;
    part.centre.clear();
    for (int k = 0; k < count; ++k) part.centre.emplace_back(k, 0.0);
    term.parts = {part};
    return term;
  };
  std::vector<ModelTerm> terms = {of_set_points("thermal_hysteresis", 124),
                                  of_set_points("thermal_hysteresis", 130),
                                  of_set_points("temperature_rate", 130),
                                  {}};
  terms.back().lab_only = true;
  keep_in_the_lab_what_no_file_carries(terms);
  EXPECT_FALSE(terms[0].lab_only);
  EXPECT_TRUE(terms[1].lab_only);
  EXPECT_FALSE(terms[2].lab_only) << "it has no mean to carry";
  EXPECT_TRUE(terms[3].lab_only);
}

}  // namespace
}  // namespace soak::calib
