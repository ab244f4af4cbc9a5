// SPDX-License-Identifier: Apache-2.0
#include "station/config/plan.h"
#include "station/config/procedure.h"

namespace soak::station {

std::string_view name_of(Purpose purpose) {
  switch (purpose) {
    case Purpose::calibration:
      return "calibration";
    case Purpose::verification:
      return "verification";
    case Purpose::diagnosis:
      return "diagnosis";
  }
  return "unknown";
}

std::string_view name_of(ProcedureKind kind) {
  switch (kind) {
    case ProcedureKind::soak:
      return "soak";
    case ProcedureKind::ramp:
      return "ramp";
    case ProcedureKind::rest:
      return "rest";
  }
  return "unknown";
}

std::string_view name_of(StepKind kind) {
  switch (kind) {
    case StepKind::turn_fixture:
      return "turn_fixture";
    case StepKind::power_on:
      return "power_on";
    case StepKind::move:
      return "move";
    case StepKind::spin:
      return "spin";
    case StepKind::set_temperature:
      return "set_temperature";
    case StepKind::wait_stable:
      return "wait_stable";
    case StepKind::record:
      return "record";
    case StepKind::check:
      return "check";
    case StepKind::warm_end:
      return "warm_end";
    case StepKind::power_off:
      return "power_off";
  }
  return "unknown";
}

}  // namespace soak::station
