// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/imu/imu.h"
#include "station/config/station_config.h"

namespace soak::station {

/// How a slot answered.
enum class SlotAnswer : std::uint8_t {
  identified,  ///< it said who it is
  anonymous,   ///< it sends bytes, and does not say who it is
  silent,      ///< nothing came
  failed,      ///< its link cannot be opened, or broke
};

/// What one look found in a slot.
struct SlotFinding {
  std::string slot;
  std::optional<int> power_output;  ///< that feeds the slot; absent = not switched by us
  SlotAnswer answer = SlotAnswer::silent;
  hal::ImuIdentity identity;  ///< where identified
  std::string trouble;        ///< where failed or anonymous: why, as far as it is known
};

/// Opens the links of all slots beside each other, each on a thread of its own, asks who is there, closes them.
/// Switches nothing. A unit is told what to send, as it is before a run. Takes some 7 s at most (and the resolver's
/// time where a host is a name), less where all answer or where `stop` becomes true. The caller sees to it that nobody
/// else has one of the links open. Findings are in the order of `slots`. Error `internal`: the host gives no thread.
[[nodiscard]] base::Result<std::vector<SlotFinding>> look_into_slots(const std::vector<Slot>& slots,
                                                                     const std::atomic<bool>& stop);

/// docs/http-api.md: the answer of POST /api/v1/campaign/look.
[[nodiscard]] nlohmann::json look_document(const std::vector<SlotFinding>& findings);

/// The same as one line of the event log.
[[nodiscard]] std::string look_text(const std::vector<SlotFinding>& findings);

}  // namespace soak::station
