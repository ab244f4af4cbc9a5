// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/chamber_survey.h"

#include <algorithm>

#include "hal/devices/detail/surveys.h"

namespace soak::hal {

bool ChamberSurvey::sound() const {
  return std::all_of(entries.begin(), entries.end(), [](const SurveyEntry& entry) { return entry.trouble.empty(); });
}

base::Result<ChamberSurvey> survey_chamber(const ChamberMap& map) {
  return std::visit([](const auto& one) { return survey(one); }, map);
}

}  // namespace soak::hal
