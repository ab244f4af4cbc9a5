// SPDX-License-Identifier: Apache-2.0
// What the parameter files of autopilots say in their comments of where the numbers come from.
#include <gtest/gtest.h>

#include <string>

#include "calib/deploy/export.h"
#include "tests/calib/calibration_file_samples.h"

namespace soak::calib {
namespace {

using samples::golden_fis;
using samples::golden_referenced;

std::vector<std::string> files_of(const Calibration& calibration) {
  return {export_px4(calibration, {})->text, export_ardupilot(calibration, {})->text};
}

TEST(ExportComment, NamesTheReferencesAndTheirWaivers) {
  for (const std::string& text : files_of(golden_referenced())) {
    for (const char* part :
         {"\n# reference: chamber_probe probe 3, certificate D-K-15048-2026-07, issued 2026-01-01T00:00:00Z, due "
          "2027-01-01T00:00:00Z, standard uncertainty 0.025 K\n",
          "\n# reference: fixture_squareness cube 7, certificate PTB 5.31-4012, issued 2024-01-01T00:00:00Z, due "
          "2025-01-01T00:00:00Z, ",
          " deg\n#   WAIVER, signed 2025-12-01T12:00:00Z by Ann Example: a new cube is ordered; its faces were "
          "compared on 2025-11-28\n"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part;
    }
  }
  for (const std::string& text : files_of(golden_fis())) EXPECT_EQ(text.find("reference:"), std::string::npos);
}

TEST(ExportComment, WhatPeopleWroteCannotBecomeAParameter) {
  Calibration calibration = golden_referenced();
  calibration.references[1].reference.name = "cube\nTC_A_ENABLE 0";
  calibration.references[1].waiver->reason = "because\r\nINS_TCAL1_ENABLE 0\n";
  for (const std::string& text : files_of(calibration)) {
    EXPECT_EQ(text.find("\nTC_A_ENABLE 0"), std::string::npos);
    EXPECT_EQ(text.find("\nINS_TCAL1_ENABLE 0"), std::string::npos);
    EXPECT_NE(text.find("cube_TC_A_ENABLE 0"), std::string::npos);
  }
}

}  // namespace
}  // namespace soak::calib
