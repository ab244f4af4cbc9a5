// SPDX-License-Identifier: Apache-2.0
// Whose calibration a file is, as firmware asks before it uses one.
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "calib/deploy/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/loaded_file.h"

namespace soak::calib {
namespace {

using samples::golden_fis;
using samples::Loaded;

TEST(Identity, IsThatOfTheCalibration) {
  Calibration calibration = golden_fis();
  calibration.epoch = -3;
  const Loaded file(calibration);
  soak_identity identity{};
  ASSERT_EQ(soak_identify(&file.cal, &identity), SOAK_OK);
  EXPECT_EQ(std::string_view(identity.serial, identity.serial_length), "SN-0001");
  EXPECT_EQ(std::string_view(identity.unit_type, identity.unit_type_length), "demo");
  EXPECT_EQ(identity.epoch, -3);
  EXPECT_EQ(identity.model_version, 7);
}

TEST(Identity, OnlyTheWholeSerialNumberIsTheUnit) {
  const Loaded file(golden_fis());
  EXPECT_EQ(soak_is_of_unit(&file.cal, "SN-0001"), 1);
  for (const char* other : {"", "SN-000", "SN-00011", "SN-0002", "sn-0001", "SN-0001demo"}) {
    EXPECT_EQ(soak_is_of_unit(&file.cal, other), 0) << other;
  }
  EXPECT_EQ(soak_is_of_unit(&file.cal, nullptr), 0);
}

TEST(Identity, OfARefusedFileIsNobodys) {
  base::Bytes bytes = *encode(golden_fis());
  bytes[bytes.size() / 2] ^= 1U;
  soak_cal cal;
  soak_identity identity{};
  ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_E_CHECK);
  EXPECT_EQ(soak_identify(&cal, &identity), SOAK_ABSENT);
  EXPECT_EQ(soak_is_of_unit(&cal, "SN-0001"), 0);
  EXPECT_EQ(soak_is_of_unit(&cal, ""), 0);
  EXPECT_EQ(soak_identify(nullptr, &identity), SOAK_E_ARGUMENT);
}

}  // namespace
}  // namespace soak::calib
