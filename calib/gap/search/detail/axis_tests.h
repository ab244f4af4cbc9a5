// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/search/score.h"
#include "calib/gap/search/structure_kind.h"

namespace soak::calib::gap {

/// An axis along which something unknown may sit, as free levels, tested: it names no physics.
struct AxisTest {
  StructureKind kind;
  std::string name;  ///< "time since the fixture turned", ...
  CandidateTest test;
  Standing standing;
  bool of_history = false;
};

/// Tests the axes that a campaign can show. `typical`: median heterogeneity of the library; `price`: of one parameter.
[[nodiscard]] std::vector<AxisTest> test_axes(const CampaignModel& model, double typical, double price);

}  // namespace soak::calib::gap
