// SPDX-License-Identifier: Apache-2.0
#include "station/commands/run_document.h"

#include <nlohmann/json.hpp>

#include "station/io/output.h"

namespace soak::station {

nlohmann::json run_document(const db::RunRow& run) {
  return {{"unit", run.unit},
          {"campaign", run.campaign},
          {"run", run.label},
          {"run_id", run.run_id},
          {"procedure", run.procedure},
          {"purpose", run.purpose},
          {"epoch", run.epoch},
          {"created_utc_s", run.created_utc_s},
          {"clock_rate", run.clock_rate},
          {"rows", run.rows},
          {"duration_s", run.duration_s},
          {"sealed", run.sealed},
          {"voided", run.voided},
          {"simulated", run.simulated},
          {"file", run.file_name},
          {"file_sha256", run.file_sha256},
          {"content_sha256", run.content_sha256},
          {"site",
           {{"latitude_deg", number_or_null(run.site.latitude_deg)},
            {"height_m", number_or_null(run.site.height_m)},
            {"azimuth_deg", number_or_null(run.site.azimuth_deg)},
            {"gravity_mps2", number_or_null(run.site.gravity_mps2)}}}};
}

}  // namespace soak::station
