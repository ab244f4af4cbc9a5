// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/not_testable.h"

#include <algorithm>
#include <string_view>

namespace soak::calib::gap::reduced {

std::vector<NotTestable> not_testable_by_branches(const std::vector<Mechanism>& tried) {
  constexpr const char* kPositions = "one attitude: needs readings in several positions";
  std::vector<NotTestable> list = {
      {"g_sensitivity", kPositions},
      {"earth_rate", kPositions},
      {"cross_axis", kPositions},
      {"scale_nonlinearity", kPositions},
      {"fixture_tilt", "one attitude: a mounting that leans is part of the accelerometers' bias"},
      {"narrow_bump", "the base follows a feature that all branches share"},
      {"aging_drift", "runs over weeks are needed; a drift within the recording is a rival, never a name"},
      {"noise_vs_temperature", "needs three runs with plateaus"},
      {"quantization", "is looked at in campaigns with plateaus only"},
      {"saturation", "is looked at in campaigns with plateaus only; sensors with clipped readings were left out"}};
  const auto missing = [&](std::string_view name) {
    return std::none_of(tried.begin(), tried.end(),
                        [&](const Mechanism& mechanism) { return mechanism.effect->name == name; });
  };
  if (missing("supply_sensitivity"))
    list.push_back({"supply_sensitivity", "supply_v was not recorded, or never moved"});
  if (missing("vibration_rectification")) {
    list.push_back({"vibration_rectification", "compressor was not recorded, or never moved"});
  }
  if (missing("warmup_transient")) list.push_back({"warmup_transient", "the time since power-on is not known"});
  return list;
}

}  // namespace soak::calib::gap::reduced
