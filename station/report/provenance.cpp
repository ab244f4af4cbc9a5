// SPDX-License-Identifier: Apache-2.0
#include "station/report/provenance.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "calib/estimate/site.h"
#include "db/run/run_file.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

using nlohmann::json;

/// Void records of one kind: the whole run, or parts of it withdrawn for one reason by one user.
struct Withdrawal {
  bool whole = false;
  std::string reason;
  std::string user;
  double utc_s = 0.0;  ///< of the first
  std::size_t records = 0;
};

/// The station withdraws each repeated segment on its own: hundreds of records may say the same.
std::vector<Withdrawal> withdrawals_of(const std::vector<db::VoidRecord>& voids) {
  std::vector<Withdrawal> list;
  for (const db::VoidRecord& record : voids) {
    const bool whole = !record.visit;
    const auto same = std::find_if(list.begin(), list.end(), [&](const Withdrawal& other) {
      return other.whole == whole && other.reason == record.reason && other.user == record.user;
    });
    if (same == list.end()) {
      list.push_back({whole, record.reason, record.user, record.utc_s, 1});
    } else {
      same->utc_s = std::min(same->utc_s, record.utc_s);
      ++same->records;
    }
  }
  return list;
}

json voids_json(const std::vector<db::VoidRecord>& voids) {
  json list = json::array();
  for (const Withdrawal& entry : withdrawals_of(voids)) {
    list.push_back({{"what", entry.whole ? "run" : "segments"},
                    {"records", entry.records},
                    {"reason", entry.reason},
                    {"user", entry.user},
                    {"utc_s", entry.utc_s}});
  }
  return list;
}

/// Where the samples came from, as the run file says; null where it cannot be read.
json source_of(const db::Catalog& catalog, const db::RunRow& run) {
  const auto file = db::RunFileReader::open(catalog.run_file_path(run));
  return file ? json(file->info().source) : json();
}

/// `gravity`: as a fit takes it for this run.
json run_json(const db::Catalog& catalog, const UsedRun& used, const calib::Gravity& gravity) {
  const db::RunRow& run = used.run;
  return {{"label", run.label},
          {"run_id", run.run_id},
          {"campaign", run.campaign},
          {"procedure", run.procedure},
          {"purpose", run.purpose},
          {"epoch", run.epoch},
          {"created_utc_s", run.created_utc_s},
          {"duration_s", run.duration_s},
          {"rows", run.rows},
          {"source", source_of(catalog, run)},
          {"clock_rate", run.clock_rate},
          {"simulated", run.simulated},
          {"gravity_mps2", gravity.mps2},
          {"gravity", gravity.assumed ? "assumed" : "known"},
          {"latitude_deg", number_or_null(run.site.latitude_deg)},
          {"height_m", number_or_null(run.site.height_m)},
          {"content_sha256", run.content_sha256},
          {"use", name_of(used.use)},
          {"voids", voids_json(used.voids)}};
}

}  // namespace

base::Result<json> provenance_json(const db::Catalog& catalog, const db::ModelRow& model,
                                   const calib::Calibration& calibration, const RunsOfModel& runs) {
  json list = json::array();
  for (const UsedRun& used : runs.runs) {
    const auto references = references_of(catalog, calibration, used);
    if (!references) return base::forward_error(references);
    list.push_back(run_json(catalog, used, gravity_at(with_reference_gravity(used.run.site, *references))));
  }
  base::Sha256 hash;
  hash.update(model.document);
  return json{{"model_sha256", base::to_hex(hash.finish())}, {"runs", std::move(list)}};
}

}  // namespace soak::station
