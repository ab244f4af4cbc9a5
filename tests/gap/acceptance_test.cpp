// SPDX-License-Identifier: Apache-2.0
// What a model keeps of an effect that is accepted.
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "calib/gap/report/gap_report.h"

namespace soak::calib::gap {
namespace {

// The report of a unit calls these "explained nearly as much", so what the search has ruled out may not be among them.
TEST(AcceptedTerm, KeepsOnlyRivalsThatAreNotOut) {
  Effect found;
  found.name = "found";
  Effect out;
  out.name = "out";
  Effect open;
  open.name = "open";
  Effect unknown;
  unknown.name = "unknown";
  NamedEffect named;
  named.effect = &found;
  named.rivals = {{&out, 0.9e-6}, {&open, 0.02}, {&unknown, std::nullopt}};
  GapReport report;
  report.conclusion = Conclusion::named;
  report.effects = {named};
  const auto terms = accepted_terms({}, report, {});
  ASSERT_TRUE(terms) << terms.error().message;
  ASSERT_EQ(terms->size(), 1U);
  EXPECT_EQ(terms->front().confusable_with, (std::vector<std::string>{"open", "unknown"}));
}

}  // namespace
}  // namespace soak::calib::gap
