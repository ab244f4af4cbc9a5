// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/http/parameters.h"
#include "station/jobs/job_runner.h"
#include "station/runs/run_archive.h"

namespace soak::station {

/// A question about units and the jobs that are done for them: GET /api/v1/NAME.
struct JobQuestion {
  std::string_view name;
  /// Refuses (bad_input, where == the parameter's name) a parameter that is missing, wrong or not known.
  base::Result<nlohmann::json> (*answer)(RunArchive& runs, const JobRunner& jobs, const Parameters& parameters);
};

/// A command for jobs: POST /api/v1/NAME with a JSON object.
struct JobOrder {
  std::string_view name;
  /// Refuses (bad_input) a body that is not the command's: where == "body" or the name of the member.
  base::Result<nlohmann::json> (*carry_out)(JobRunner& jobs, const nlohmann::json& body);
};

/// docs/http-api.md.
[[nodiscard]] const std::vector<JobQuestion>& job_questions();
[[nodiscard]] const std::vector<JobOrder>& job_orders();

inline constexpr std::string_view kCancelJob = "jobs/cancel";
/// The job that the body of that command names; nothing where none is kept that it could name.
[[nodiscard]] std::optional<nlohmann::json> job_to_cancel(const JobRunner& jobs, const nlohmann::json& body);

/// GET /api/v1/job/file. Refuses as a question does.
[[nodiscard]] base::Result<JobRunner::MadeFile> job_file(const JobRunner& jobs, const Parameters& parameters);

}  // namespace soak::station
