// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <string>

#include "calib/deploy/calibration_file.h"
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

/// Exit status of a shell command.
int run(const std::string& command) { return std::system(command.c_str()); }

/// Compiles the runtime as strict C99 with every warning an error.
int compile_strictly(const std::string& compiler, const std::string& options) {
  const std::string tests = SOAK_TEST_FOLDER;
  std::string command = compiler + " -std=c99 -Wall -Wextra -Wconversion -Wdouble-promotion -pedantic -Werror -O2 ";
  command += options + " -o /dev/null -I" + tests + "/.. -c " + tests + "/calib/runtime_c/runtime_as_c.c";
  return run(command);
}

TEST(RuntimeAsC, CompilesWithoutWarningInStrictC99) {
  int compilers = 0;
  for (const std::string compiler : {"gcc", "clang", "clang-19"}) {
    if (run("command -v " + compiler + " > /dev/null") != 0) continue;
    ++compilers;
    EXPECT_EQ(compile_strictly(compiler, ""), 0) << compiler;
  }
  EXPECT_GT(compilers, 0);
}

TEST(RuntimeAsC, CompilesWithTheHeadersOfAFreestandingCompilerAlone) {
  // without a C library: <string.h> and <math.h> are not found
  EXPECT_EQ(compile_strictly("gcc", "-ffreestanding -nostdinc -isystem $(gcc -print-file-name=include)"), 0);
  if (run("command -v clang-19 > /dev/null") == 0) {
    EXPECT_EQ(compile_strictly("clang-19", "-ffreestanding -nostdlibinc"), 0);
  }
}

}  // namespace
}  // namespace soak::calib
