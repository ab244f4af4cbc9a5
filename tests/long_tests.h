// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>

/// First in a test that `./run test` leaves to `./run prove long-tests`: a sibling shows the main of it.
#define SOAK_LONG_TEST()                                                                         \
  if (const char* wanted = std::getenv("SOAK_LONG_TESTS"); wanted == nullptr || *wanted == '\0') \
  GTEST_SKIP() << "long: ./run prove long-tests"
