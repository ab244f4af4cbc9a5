// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Which report to make, and what only the caller knows.
struct ReportRequest {
  std::string unit;                   ///< serial number
  std::optional<std::int32_t> model;  ///< version; absent = the newest
  calib::Limits limits;
  std::optional<std::string> limits_source;  ///< where they stand; absent: those of the unit's type, if it has any
  bool with_noise = true;                    ///< false: without an analysis of the noise, which takes the longest
  double created_utc_s = 0.0;
  std::string software;                  ///< name and version of this program
  std::function<bool(double)> progress;  ///< is told the share that is done; false stops the work
};

/// Everything that a unit's report holds (docs/schema/report.schema.json but for `file`, `bytes` and `sha256`);
/// report_page() makes a page of it. Refuses an unknown unit and one without such a model; a run file that is missing
/// is damage.
[[nodiscard]] base::Result<nlohmann::json> report_document(const db::Catalog& catalog, const ReportRequest& request);

}  // namespace soak::station
