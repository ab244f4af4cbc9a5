// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <string>

#include "calib/calibration_file.h"
#include "calib/runtime/soak_runtime.h"
#include "tests/calib/calibration_file_samples.h"
#include "tests/calib/runtime_c/runtime_as_c.h"

namespace soak::calib {
namespace {

TEST(RuntimeAsC, GivesTheSameBitsAsInCpp) {
  for (const Calibration& calibration : {samples::golden_fis(), samples::golden_mixed()}) {
    const base::Bytes bytes = *encode(calibration);
    soak_cal cal;
    ASSERT_EQ(soak_load(&cal, bytes.data(), bytes.size()), SOAK_OK);
    const std::array<float, 6> raw = {0.1F, -0.2F, 0.3F, 1.0F, -2.0F, 9.8F};
    for (float temp_c = -40.0F; temp_c <= 80.0F; temp_c += 0.375F) {
      std::array<float, 6> in_cpp{};
      std::array<float, 6> in_c{};
      std::uint32_t flags_cpp = 0;
      std::uint32_t flags_c = 0;
      EXPECT_EQ(soak_apply(&cal, temp_c, raw.data(), in_cpp.data(), &flags_cpp),
                runtime_as_c_apply(bytes.data(), bytes.size(), temp_c, raw.data(), in_c.data(), &flags_c));
      EXPECT_EQ(in_cpp, in_c);
      EXPECT_EQ(flags_cpp, flags_c);
    }
  }
}

TEST(RuntimeAsC, CompilesWithoutWarningInStrictC99) {
  const std::string flags = " -std=c99 -Wall -Wextra -Wconversion -pedantic -Werror -O2 -o /dev/null -I";
  const std::string tests = SOAK_TEST_FOLDER;
  int compilers = 0;
  for (const char* compiler : {"gcc", "clang", "clang-19"}) {
    std::string command = "command -v ";
    command.append(compiler).append(" > /dev/null");
    if (std::system(command.c_str()) != 0) continue;
    ++compilers;
    command = compiler;
    command.append(flags).append(tests).append("/.. -c ").append(tests).append("/calib/runtime_c/runtime_as_c.c");
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }
  EXPECT_GT(compilers, 0);
}

}  // namespace
}  // namespace soak::calib
