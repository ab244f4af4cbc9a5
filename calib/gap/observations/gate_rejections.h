// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calib/gap/campaign/campaign.h"

namespace soak::calib::gap {

/// Readings of one run that the data gate (data_gate.h) keeps out of the search.
struct LeftOut {
  std::string run;               ///< label
  std::optional<Sensor> sensor;  ///< absent = whole segments; those are not counted for their sensors again
  std::size_t segments = 0;      ///< in which they are left out
  std::size_t of = 0;            ///< soak segments of the run
  std::string code;              ///< of the first finding that rejects
  std::string why;               ///< its sentence
};

/// All that the gate left out, in the order of runs: whole segments first, then sensors.
[[nodiscard]] std::vector<LeftOut> left_out_by_gate(const LoggedCampaign& campaign);

/// The first three in words, and how many more there are.
[[nodiscard]] std::string in_words(const std::vector<LeftOut>& left_out);

/// Whether more than half of the segments of a run are left out.
[[nodiscard]] bool any_run_lost(const std::vector<LeftOut>& left_out);

}  // namespace soak::calib::gap
