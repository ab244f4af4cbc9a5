// SPDX-License-Identifier: Apache-2.0
#include "calib/deploy/export.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "calib/deploy/calibration_file.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using namespace samples;

/// The numbers 0x.. between the braces of the header's array.
base::Bytes array_bytes(const std::string& header) {
  const std::size_t first = header.find("= {");
  std::istringstream in(header.substr(first + 3, header.find("};") - first - 3));
  base::Bytes bytes;
  for (std::string field; std::getline(in, field, ',');) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(field, nullptr, 16)));
  }
  return bytes;
}

/// Compiles a program around the header with the C compiler as C99, and runs it; its exit status, or -1.
int compile_and_run(const std::string& header, const std::string& options) {
  const std::string folder = testing::TempDir();
  std::string name = "soak_export_c_";
  name += testing::UnitTest::GetInstance()->current_test_info()->name();
  const std::string source = folder + name + ".c";
  std::ofstream(source) << header << R"(
int main(void) {
  static soak_cal cal;
  const float raw[6] = {0.5f, -0.25f, 0.125f, 1.5f, -2.25f, 9.75f};
  float out[6];
  uint32_t flags;
  if (soak_load(&cal, soak_calibration_SN_0001, sizeof soak_calibration_SN_0001) != SOAK_OK) return 10;
  if (soak_apply(&cal, 20.0f, raw, out, &flags) != SOAK_OK) return 11;
  return out[0] < 0.5f && out[5] > 9.75f ? 0 : 12;
}
)";
  std::string command = "cc -std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -I";
  command.append(SOAK_TEST_FOLDER).append("/../calib/runtime ").append(options).append(" -o ").append(folder);
  command.append(name).append(" ").append(source).append(" -lm 2> ").append(folder).append(name).append(".log");
  if (std::system(command.c_str()) != 0) return -1;
  const int status = std::system((folder + name).c_str());
  return status >> 8;
}

TEST(ExportC, HeaderCompilesAndCorrects) {
  const auto header = export_c(golden_fis());
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(compile_and_run(*header, ""), 0);
}

TEST(ExportC, SimulatedHeaderDoesNotCompileUnlessAccepted) {
  Calibration calibration = golden_fis();
  calibration.simulated = true;
  const auto header = export_c(calibration);
  ASSERT_TRUE(header);
  EXPECT_NE(header->find("SIMULATED SIMULATED SIMULATED"), std::string::npos);
  EXPECT_EQ(compile_and_run(*header, ""), -1);
  EXPECT_EQ(compile_and_run(*header, "-DSOAK_ACCEPT_SIMULATED"), 0);
}

TEST(ExportC, HeaderThatIsNotReleasedDoesNotCompileUnlessAccepted) {
  Calibration calibration = golden_fis();
  calibration.unreleased = true;
  const auto header = export_c(calibration);
  ASSERT_TRUE(header);
  EXPECT_NE(header->find("NOT RELEASED"), std::string::npos);
  EXPECT_EQ(compile_and_run(*header, ""), -1);
  EXPECT_EQ(compile_and_run(*header, "-DSOAK_ACCEPT_UNRELEASED"), 0);
}

TEST(ExportC, ArrayIsTheCalibrationFile) { EXPECT_EQ(array_bytes(*export_c(golden_mixed())), *encode(golden_mixed())); }

TEST(ExportC, CommentSaysWhereTheNumbersComeFrom) {
  const std::string header = *export_c(golden_fis());
  for (const char* part : {"unit: SN-0001", "model version: 7", "epoch: 2", "created: 2026-11-21T08:00:00Z",
                           "gyro_x: anfis, valid from -30 to 70 degC, scale unknown",
                           "run: ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"}) {
    EXPECT_NE(header.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(header.find("SIMULATED"), std::string::npos);
  EXPECT_EQ(header.find("RELEASED"), std::string::npos);
}

TEST(ExportC, CommentNamesTheReferencesAndTheirWaivers) {
  const std::string header = *export_c(golden_referenced());
  for (const char* part :
       {" * reference: chamber_probe probe 3, certificate D-K-15048-2026-07, issued 2026-01-01T00:00:00Z, due "
        "2027-01-01T00:00:00Z, standard uncertainty 0.025 K\n",
        " * reference: fixture_squareness cube 7, certificate PTB 5.31-4012, issued 2024-01-01T00:00:00Z, due "
        "2025-01-01T00:00:00Z, standard uncertainty 0.00572957795130823",
        " deg\n *   WAIVER, signed 2025-12-01T12:00:00Z by Ann Example: a new cube is ordered; its faces were compared "
        "on "
        "2025-11-28\n"}) {
    EXPECT_NE(header.find(part), std::string::npos) << part << header.substr(0, 2000);
  }
  EXPECT_EQ(export_c(golden_fis())->find("reference"), std::string::npos);
}

TEST(ExportC, ReferenceCannotBreakOutOfTheComment) {
  Calibration calibration = golden_referenced();
  calibration.references[1].reference.name = "*/\n#error";
  calibration.references[1].waiver->reason = "*/\n#error";
  const std::string header = *export_c(calibration);
  EXPECT_EQ(header.find("\n#error"), std::string::npos);
  EXPECT_EQ(header.find("*/"), header.find("*/\n#ifndef"));
}

TEST(ExportC, SerialNumberCannotBreakOutOfTheComment) {
  Calibration calibration = golden_fis();
  calibration.unit = "*/\n#error \"out\" /*\\";
  const std::string header = *export_c(calibration);
  EXPECT_EQ(header.find("\n#error"), std::string::npos);
  EXPECT_EQ(header.find("*/"), header.find("*/\n#ifndef"));
  EXPECT_NE(header.find("uint8_t soak_calibration_____error__out_____["), std::string::npos);
}

TEST(ExportC, FailsAsEncodingDoes) {
  Calibration calibration = golden_fis();
  calibration.unit.clear();
  EXPECT_FALSE(export_c(calibration));
}

}  // namespace
}  // namespace soak::calib
