// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/estimate/model_term.h"
#include "calib/gap/campaign/campaign.h"
#include "calib/gap/report/gap_report.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// Unix time at which each run began, on the clock of the laboratory: that of a simulated one goes `clock_rate` times
/// as fast from the first run on. Nothing for runs that soakd did not record, whose files were made later, and for
/// those of another clock rate than most.
[[nodiscard]] std::vector<std::optional<double>> begun_utc_s(const std::vector<db::RunInfo>& runs);

/// The runs of `input`, each with what its file logged between the segments; `with_samples`: samples are looked at for
/// what means do not show, sensor by sensor. Fails (corrupt) where a run file cannot be read.
[[nodiscard]] base::Result<calib::gap::LoggedCampaign> with_logs(const db::Catalog& catalog, calib::UnitInput input,
                                                                 bool with_samples);

/// The runs that a fit of the unit takes (load_unit()), each with its log and its samples looked at. Fails as
/// load_unit() and with_logs() do.
[[nodiscard]] base::Result<calib::gap::LoggedCampaign> load_logged_campaign(const db::Catalog& catalog,
                                                                            const std::string& unit,
                                                                            const std::optional<std::string>& campaign);

/// A search for what the newest model of a unit lacks.
struct GapSearch {
  db::ModelRow model;
  std::vector<calib::ModelTerm> terms;  ///< that the model carries
  calib::gap::LoggedCampaign campaign;  ///< less the terms
  calib::gap::GapReport report;
  std::vector<std::string> warnings;  ///< sentences: terms that some run cannot evaluate, a rest that cannot be read
};

/// Looks in the runs that a fit takes, of one campaign where it is given. `begin` is told what is done from then on:
/// "reading", "searching". Refuses (bad_input) an unknown unit, and one without a model of its present epoch.
[[nodiscard]] base::Result<GapSearch> search_gap(const db::Catalog& catalog, const std::string& unit,
                                                 const std::optional<std::string>& campaign,
                                                 const std::function<void(std::string_view)>& begin);

/// Sets beside each slow noise the bias instability of the unit's longest rest, if that is half an hour or longer:
/// reads that recording and works for about a second a sensor. One that cannot be read becomes a warning.
[[nodiscard]] base::Status set_beside_rest(const db::Catalog& catalog, GapSearch& search);

/// The same as the newest kept search in that model has it, without reading anything.
[[nodiscard]] base::Status set_beside_rest_as_found(const db::Catalog& catalog, GapSearch& search);

}  // namespace soak::station
