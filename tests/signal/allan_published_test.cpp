// SPDX-License-Identifier: Apache-2.0
// Published deviations: NIST SP 1065, and the files of Stable32 for the recordings that belong to others.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "calib/signal/allan/allan.h"

namespace soak::calib::signal {
namespace {

namespace fs = std::filesystem;

struct Named {
  AllanKind kind;
  const char* name;
};
constexpr Named kNamed[] = {{AllanKind::plain, "adev"},
                            {AllanKind::overlapping, "oadev"},
                            {AllanKind::modified, "mdev"},
                            {AllanKind::hadamard, "hdev"},
                            {AllanKind::overlapping_hadamard, "ohdev"}};

PhaseRecord from_rate(const std::vector<double>& rate) { return *PhaseRecord::from_rate(rate, 1.0); }

/// n <- 16807 n mod 2^31 - 1 from 1234567890, y = n/(2^31 - 1) [NIST SP 1065 §12.4].
std::vector<double> nist_1000_points() {
  std::vector<double> y;
  std::uint64_t n = 1234567890;
  for (int i = 0; i < 1000; ++i) {
    y.push_back(static_cast<double>(n) / 2147483647.0);
    n = 16807 * n % 2147483647;
  }
  return y;
}

std::ifstream vector_file(const std::string& name) {
  return std::ifstream(fs::path(SOAK_TEST_FOLDER) / "data" / "vectors" / name);
}

/// A unit of the last printed digit of a number printed with so many after the point of its mantissa.
double last_digit(double printed, int decimals) {
  return std::pow(10.0, std::floor(std::log10(std::abs(printed)) + 1e-9) - decimals);
}

TEST(AllanPublished, FileOfTheNistSetHoldsItsRecipe) {
  std::ifstream file = vector_file("nist_sp1065_1000.csv");
  std::string header;
  ASSERT_TRUE(std::getline(file, header));
  std::vector<double> y;
  for (double value = 0.0; file >> value;) y.push_back(value);
  const std::vector<double> recipe = nist_1000_points();
  ASSERT_EQ(y.size(), recipe.size());
  // The file has 17 digits.
  for (std::size_t i = 0; i < y.size(); ++i) EXPECT_NEAR(y[i], recipe[i], 1e-16 * 2.0);
}

TEST(AllanPublished, NistSetOf1000PointsHasAllDigitsOfOurVectors) {
  const auto vectors = nlohmann::json::parse(vector_file("nist_sp1065_1000.json"));
  const PhaseRecord record = from_rate(nist_1000_points());
  for (const Named& of : {kNamed[0], kNamed[1], kNamed[2]}) {
    ASSERT_EQ(vectors.at(of.name).size(), 3U);
    for (const auto& [multiple, expected] : vectors.at(of.name).items()) {
      // The vectors were computed in double precision: sums of 1000 terms, rounding 1e-13 at most.
      const double deviation = allan_point(record, of.kind, std::stoul(multiple)).deviation;
      EXPECT_NEAR(deviation / expected.get<double>(), 1.0, 1e-12) << of.name << " " << multiple;
    }
  }
}

TEST(AllanPublished, NistSetOf1000PointsHasAllPrintedDigits) {
  // [NIST SP 1065 table 31], seven digits. The Hadamard deviation at 100 is 0.03910860560 in exact fractions, printed
  // as 3.910860e-02: one unit.
  const struct {
    AllanKind kind;
    double at[3];
  } table[] = {{AllanKind::plain, {2.922319e-01, 9.965736e-02, 3.897804e-02}},
               {AllanKind::overlapping, {2.922319e-01, 9.159953e-02, 3.241343e-02}},
               {AllanKind::modified, {2.922319e-01, 6.172376e-02, 2.170921e-02}},
               {AllanKind::hadamard, {2.943883e-01, 1.052754e-01, 3.910860e-02}},
               {AllanKind::overlapping_hadamard, {2.943883e-01, 9.581083e-02, 3.237638e-02}}};
  const PhaseRecord record = from_rate(nist_1000_points());
  for (const auto& row : table) {
    std::size_t multiple = 1;
    for (const double printed : row.at) {
      const double units = row.kind == AllanKind::hadamard && multiple == 100 ? 1.0 : 0.5;
      EXPECT_NEAR(allan_point(record, row.kind, multiple).deviation, printed, units * last_digit(printed, 6))
          << multiple;
      multiple *= 10;
    }
  }
}

TEST(AllanPublished, NistSetOfTenPointsHasAllPrintedDigits) {
  // [NIST SP 1065 table 30]. Both Hadamard deviations at 1 are the same by definition, 70.806073 in exact fractions;
  // printed as 70.80608 and 70.80607: one unit for these.
  const PhaseRecord record = from_rate({892, 809, 823, 798, 671, 644, 883, 903, 677});
  const struct {
    AllanKind kind;
    double at[2];
    double tolerance[2];
  } table[] = {{AllanKind::plain, {91.22945, 115.8082}, {5e-6, 5e-5}},
               {AllanKind::overlapping, {91.22945, 85.95287}, {5e-6, 5e-6}},
               {AllanKind::modified, {91.22945, 74.78849}, {5e-6, 5e-6}},
               {AllanKind::hadamard, {70.80608, 116.7980}, {1e-5, 5e-5}},
               {AllanKind::overlapping_hadamard, {70.80607, 85.61487}, {1e-5, 5e-6}}};
  for (const auto& row : table) {
    for (std::size_t m = 1; m <= 2; ++m) {
      EXPECT_NEAR(allan_point(record, row.kind, m).deviation, row.at[m - 1], row.tolerance[m - 1]) << m;
    }
  }
}

/// One line of a file of Stable32: AF, Tau, #, Alpha, Min Sigma, Sigma, Max Sigma.
struct Row {
  std::size_t multiple = 0;
  std::size_t terms = 0;
  double sigma = 0.0;
};

fs::path recordings() {
  const char* folder = std::getenv("SOAK_TEST_DATA");
  const fs::path data = folder != nullptr && *folder != '\0' ? fs::path(folder)
                                                             : fs::path(SOAK_TEST_FOLDER) / ".." / ".." / "shared/data";
  return data / "allan_stable32";
}

std::vector<Row> stable32_rows(const fs::path& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream columns(line);
    Row row;
    double tau = 0.0, terms = 0.0, alpha = 0.0, low = 0.0;
    if (!(columns >> row.multiple >> tau >> terms >> alpha >> low >> row.sigma)) continue;
    row.terms = static_cast<std::size_t>(terms);
    rows.push_back(row);
  }
  return rows;
}

/// Numbers of a file, comments left out.
std::vector<double> numbers(const fs::path& path) {
  std::ifstream file(path);
  std::vector<double> values;
  for (std::string line; std::getline(file, line);) {
    char* end = nullptr;
    const double value = std::strtod(line.c_str(), &end);
    if (end != line.c_str()) values.push_back(value);
  }
  return values;
}

std::vector<AllanPoint> points_at(const PhaseRecord& record, AllanKind kind, const std::vector<Row>& rows) {
  std::vector<std::size_t> multiples;
  for (const Row& row : rows) multiples.push_back(row.multiple);
  return allan_points(record, kind, multiples);
}

/// Each row of the file, its number of terms exactly and its deviation to so many units of the last of five digits.
void expect_printed_digits(const PhaseRecord& record, AllanKind kind, const fs::path& path, std::size_t row_count,
                           double units) {
  const std::vector<Row> rows = stable32_rows(path);
  ASSERT_EQ(rows.size(), row_count) << path;
  const std::vector<AllanPoint> points = points_at(record, kind, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(points[i].terms, rows[i].terms) << path << " at " << rows[i].multiple;
    EXPECT_NEAR(points[i].deviation, rows[i].sigma, units * last_digit(rows[i].sigma, 4))
        << path << " at " << rows[i].multiple;
  }
}

void expect_ratio(const PhaseRecord& record, AllanKind kind, const fs::path& path, double tolerance) {
  const std::vector<Row> rows = stable32_rows(path);
  ASSERT_GE(rows.size(), 12U) << path;
  const std::vector<AllanPoint> points = points_at(record, kind, rows);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_NEAR(points[i].deviation / rows[i].sigma, 1.0, tolerance) << path << " at " << rows[i].multiple;
  }
}

/// The differences without overlap end earlier.
std::size_t rows_of(AllanKind kind, std::size_t overlapping, std::size_t plain) {
  return kind == AllanKind::plain || kind == AllanKind::hadamard ? plain : overlapping;
}

TEST(AllanPublished, PhaseDatMatchesStable32ToItsPrintedDigits) {
  const fs::path folder = recordings() / "phasedat";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const auto record = PhaseRecord::from_phase(numbers(folder / "PHASE.DAT"), 1.0);
  ASSERT_TRUE(record) << record.error().message;
  ASSERT_EQ(record->phase().size(), 1001U);
  for (const Named& of : kNamed) {
    const std::string stem = std::string("phase_dat_") + of.name;
    const std::size_t octaves = stable32_rows(folder / (stem + "_octave.txt")).size();
    ASSERT_GE(octaves, 7U);
    // A ten-thousandth of a unit for values on the border of rounding.
    expect_printed_digits(*record, of.kind, folder / (stem + "_octave.txt"), octaves, 0.5001);
    expect_printed_digits(*record, of.kind, folder / (stem + ".txt"), rows_of(of.kind, 139, 125), 0.5001);
  }
}

/// Fractional frequency of the 10 MHz oscillator; nothing where the recording is absent.
std::optional<PhaseRecord> oscillator(const fs::path& folder) {
  if (!fs::exists(folder)) return std::nullopt;
  std::vector<double> fraction = numbers(folder / "ocxo_frequency.txt");
  for (double& f : fraction) f = (f - 1e7) / 1e7;
  return from_rate(fraction);
}

TEST(AllanPublished, OscillatorMatchesStable32AtAllAveragingTimesToItsPrintedDigits) {
  const fs::path folder = recordings() / "ocxo";
  const auto record = oscillator(folder);
  if (!record) GTEST_SKIP() << folder << " is absent";
  ASSERT_EQ(record->phase().size(), 19983U);
  // One of the 1341 values lies on the border of rounding: modified Allan, 1994 s, 6.9926501e-12 printed as 6.9926e-12.
  for (const Named& of : kNamed) {
    expect_printed_digits(*record, of.kind, folder / (std::string("stable32_") + of.name + "_alltau.txt"),
                          rows_of(of.kind, 273, 261), 0.502);
  }
}

TEST(AllanPublished, OscillatorMatchesStable32AtOctaves) {
  const fs::path folder = recordings() / "ocxo";
  const auto record = oscillator(folder);
  if (!record) GTEST_SKIP() << folder << " is absent";
  // These files are of another reading of the recording (their frequencies have the 1 in front), and do not agree among
  // themselves: at 1 s the plain and the overlapping deviation are one by definition, but printed as 7.6106e-11 and
  // 7.6143e-11. The file of all averaging times has 7.6106e-11 for both.
  expect_ratio(*record, AllanKind::plain, folder / "adev_octave.txt", 2e-4);
  expect_ratio(*record, AllanKind::hadamard, folder / "hdev_octave.txt", 2e-4);
  expect_ratio(*record, AllanKind::overlapping, folder / "oadev_octave.txt", 2e-3);
  expect_ratio(*record, AllanKind::modified, folder / "mdev_octave.txt", 2e-3);
  expect_ratio(*record, AllanKind::overlapping_hadamard, folder / "ohdev_octave.txt", 2e-3);
}

}  // namespace
}  // namespace soak::calib::signal
