// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "db/catalog/catalog.h"
#include "hal/devices/chamber.h"
#include "hal/devices/fixture.h"
#include "station/config/plan.h"
#include "station/config/procedure.h"
#include "station/config/station_config.h"
#include "station/fit/reference_rule.h"
#include "station/lab/resume.h"
#include "station/lab/station_service.h"

namespace soak::station {

struct CheckedUnit {
  Slot slot;
  std::string serial;
  calib::UnitType type;
};

/// A request whose procedure, units and ratings are sound.
struct CheckedStart {
  Plan plan;
  std::vector<CheckedUnit> units;  ///< in the order of the slots
};

/// What a request comes to as far as it is sound, and all that is wrong with it.
struct ReviewedStart {
  std::optional<Procedure> procedure;  ///< absent where its text is wrong
  std::vector<CheckedUnit> units;      ///< in the order of the slots
  std::vector<base::Error> mistakes;
};

/// Checks all that can be known before a device is touched: the procedure's text, slots and serial numbers, unit types
/// (the catalog's, else the slot's) and ratings. A mistake in one does not hide those in the others.
[[nodiscard]] ReviewedStart review_start(const StartRequest& request, const StationConfig& config,
                                         const db::Catalog& catalog);

/// The same for a campaign that is to begin: the first mistake refuses it. Errors are bad_input.
[[nodiscard]] base::Result<CheckedStart> check_start(const StartRequest& request, const StationConfig& config,
                                                     const db::Catalog& catalog);

/// Checks what a connected chamber says of its own limits. Errors are bad_input.
[[nodiscard]] base::Status check_chamber(const CheckedStart& checked, const hal::Chamber& chamber);

/// Checks that the fixture (null = turned by hand) knows the positions of the plan and can turn at its rates. Errors
/// are bad_input.
[[nodiscard]] base::Status check_fixture(const CheckedStart& checked, const hal::Fixture* fixture);

/// What the plan will write from step `first_step` on, on the safe side.
[[nodiscard]] double needed_bytes(const CheckedStart& checked, std::size_t first_step);

/// Whether the disk under `folder` holds what the plan will write from step `first_step` on (else bad_input), and as
/// much as a campaign that waited for room needs to go on (else internal: the plan is not at fault).
[[nodiscard]] base::Status check_disk(const CheckedStart& checked, std::size_t first_step,
                                      const std::filesystem::path& folder);

/// A pre-flight is done at the temperature of the room: refuses (state) a chamber that is far from it.
[[nodiscard]] base::Status check_room(const CheckedStart& checked, std::size_t first_step, double room_c, double air_c);

/// The references of the station for what the plan does from step `first_step` on, if it begins at `utc_s`. Refuses as
/// judge_references() does.
[[nodiscard]] base::Result<JudgedReferences> check_references(const db::Catalog& catalog, const CheckedStart& checked,
                                                              std::size_t first_step, double utc_s, double clock_rate);

/// What there is to say of check standards: nothing of a plan that is not for calibration, which no chart holds.
[[nodiscard]] base::Result<std::optional<std::string>> note_on_check_standards(const db::Catalog& catalog,
                                                                               const CheckedStart& checked);

/// "by eva", "by soakd, queued by eva": who began a campaign, and who had put it into the queue (empty: nobody).
[[nodiscard]] std::string begun_by(const std::string& user, const std::string& queued_by);

/// What the journal keeps of a campaign, and back. `notes` says what was remarkable at the start.
[[nodiscard]] nlohmann::json start_document(const StartRequest& request, const CheckedStart& checked,
                                            const std::vector<std::string>& notes);
[[nodiscard]] base::Result<StartRequest> request_of(const db::CampaignRow& row);

/// The way back into a campaign that was cut short. Refuses (state) a campaign whose procedure compiles to another plan
/// than it did when it was started.
[[nodiscard]] base::Result<WayBack> way_to_resume(const db::Catalog& catalog, const db::CampaignRow& row,
                                                  double room_c);

}  // namespace soak::station
