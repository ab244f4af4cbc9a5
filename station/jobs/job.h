// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/jobs/child.h"

namespace soak::station {

/// Kinds of jobs that are of several units, and not of one: of all, or of those of a campaign.
inline constexpr std::string_view kFitAll = "fit_all";
inline constexpr std::string_view kVerifyAll = "verify_all";
inline constexpr std::string_view kKeptVerdicts = "verdicts.jsonl";  ///< in the folder of such a job
inline constexpr std::string_view kReleaseAll = "release_all";
inline constexpr std::string_view kExportAll = "export_all";            ///< what is handed over, in one file
inline constexpr std::string_view kReportCampaign = "report_campaign";  ///< of the units of a campaign
[[nodiscard]] bool is_of_all(std::string_view kind);

/// What somebody at the page wants to be done with a unit, or with all.
struct JobRequest {
  /// "fit", "verify", "report", "release", "export", "gap_find", "gap_accept", "gap_show", or one that is_of_all()
  std::string kind;
  std::string unit;        ///< serial number; empty: of all
  std::string campaign;    ///< verify, kVerifyAll: of the fresh runs; kReportCampaign
  std::string format;      ///< export, kExportAll: one of export_formats()
  bool simulated = false;  ///< export, kExportAll: also of a model that was made from simulated data
  std::string user;
  std::vector<std::string> effects = {};             ///< gap_accept: names of those to be taken, one at least
  bool sign = false;                                 ///< export as blob: with the station's key
  std::optional<std::int32_t> model = std::nullopt;  ///< export: version of the model; absent = the newest
  /// export as px4: device id of the accelerometers, and of the gyros if that is another
  std::optional<std::int32_t> accel_id = std::nullopt;
  std::optional<std::int32_t> gyro_id = std::nullopt;
};

/// A command line of `soak` that does it.
struct JobCommand {
  std::vector<std::string> arguments;
  std::string file;  ///< name of the file that it makes in the job's folder; empty = none
};

/// Refuses (bad_input, where == the member) a request that is not one: another kind or format, a unit that the catalog
/// does not have, a campaign or effects that are missing, a signature without a key or on what takes none, a version
/// that there is not or of what is of no model.
[[nodiscard]] base::Status check_job(const db::Catalog& catalog, const JobRequest& request);

/// The command for a request that check_job() lets pass, in an empty folder; a verification's calibration file, made
/// of the newest model, is put there. Refuses (bad_input) a verification of a unit that has no model. What may be
/// released, and that a withdrawn model is not exported, `soak` itself decides.
[[nodiscard]] base::Result<JobCommand> job_command(const db::Catalog& catalog, const JobRequest& request,
                                                   const std::filesystem::path& folder);

/// What of the document that `soak` printed is kept with the job; null where it printed none.
[[nodiscard]] nlohmann::json job_result(const std::string& kind, const std::string& output);

/// Version of the model that a job works on; none where it is of none: a fit, a job of all units, values of the noise,
/// a unit without a model.
[[nodiscard]] base::Result<std::optional<std::int32_t>> job_model(const db::Catalog& catalog,
                                                                  const JobRequest& request);

/// What a job is doing.
struct JobStep {
  std::string doing;            ///< "fitting"
  std::optional<double> share;  ///< that is done of it, 0 to 1; none where nobody knows

  bool operator==(const JobStep&) const = default;
};

/// The last step that it has told on standard error, "soak: fitting: 12 %" or "soak: searching: ..."; none where it has
/// told none.
[[nodiscard]] std::optional<JobStep> job_step(std::string_view errors);

/// Why it failed, in the words of `soak --json` on standard error.
[[nodiscard]] std::string job_message(const ChildEnd& end);

/// What a verification of all that printed nothing had come to: the result as far as the file kKeptVerdicts in its
/// folder goes (`soak verify --keep`); null where there is none. A line that is torn is left out.
[[nodiscard]] nlohmann::json kept_verdicts(const std::filesystem::path& folder);

}  // namespace soak::station
