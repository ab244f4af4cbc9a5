// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/detail/checks.h"

namespace soak::calib::gate {
namespace {

void add(const View& view, std::optional<Finding> SensorSummary::* check, std::vector<Finding>& findings) {
  for (const SensorSummary& summary : view.state.sensor) {
    if (summary.*check) findings.push_back(*(summary.*check));
  }
}

/// One for the whole segment. Sensors without missing samples share their times: the first of them speaks for all.
void add_irregular_sampling(const View& view, std::vector<Finding>& findings) {
  bool judged_complete = false;
  for (const SensorSummary& summary : view.state.sensor) {
    if (!summary.sampling_judged || (summary.complete && judged_complete)) continue;
    judged_complete = summary.complete;
    if (!summary.irregular_sampling) continue;
    findings.push_back(*summary.irregular_sampling);
    return;
  }
}

}  // namespace

void sensor_findings(const View& view, std::vector<Finding>& findings) {
  add(view, &SensorSummary::saturated, findings);
  add(view, &SensorSummary::stuck, findings);
  add(view, &SensorSummary::dropouts, findings);
  add_irregular_sampling(view, findings);
}

}  // namespace soak::calib::gate
