// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_unit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>
#include <utility>
#include <vector>

#include "calib/estimate/run_copies.h"
#include "calib/model/model_document.h"
#include "station/config/unit_type_file.h"
#include "station/fit/reference_rule.h"
#include "station/io/host.h"
#include "station/io/output.h"

namespace soak::station {
namespace {

constexpr std::string_view kCalibration = "calibration";
constexpr std::size_t kCampaignsListed = 10;

std::string reason_without_runs(const std::string& unit, const std::optional<std::string>& campaign,
                                const std::vector<db::RunRow>& runs) {
  const std::string where = campaign ? fmt::format(" in campaign '{}'", *campaign) : "";
  if (runs.empty()) return fmt::format("unit {} has no run{}; import or record one first", unit, where);
  std::size_t voided = 0;
  std::size_t verification = 0;
  std::size_t diagnosis = 0;
  std::size_t unsealed = 0;
  for (const db::RunRow& run : runs) {
    voided += run.voided ? 1 : 0;
    unsealed += run.sealed ? 0 : 1;
    verification += run.purpose == "verification" ? 1 : 0;
    diagnosis += run.purpose == "diagnosis" ? 1 : 0;
  }
  return fmt::format(
      "unit {} has no run to fit{}: of {} runs {} are voided, {} unsealed, {} verification runs, {} diagnosis runs, "
      "the rest of an earlier epoch",
      unit, where, runs.size(), voided, unsealed, verification, diagnosis);
}

/// Fits the sensors that have rows, each on the first free thread.
std::array<std::optional<base::Result<calib::SensorFit>>, calib::kSensorCount> fit_sensors(
    const calib::UnitRows& rows, const calib::CurveFitOptions& options, int jobs) {
  std::array<std::optional<base::Result<calib::SensorFit>>, calib::kSensorCount> fits;
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t s = next++; s < calib::kSensorCount && !interrupted(); s = next++) {
      if (rows.bias[s]) fits[s] = calib::fit_sensor(rows, calib::kSensors[s], options);
    }
  };
  const auto threads =
      static_cast<std::size_t>(jobs > 0 ? jobs : static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::jthread> pool;
  for (std::size_t t = 1; t < std::clamp<std::size_t>(threads, 1, calib::kSensorCount); ++t) pool.emplace_back(work);
  work();
  pool.clear();
  return fits;
}

}  // namespace

base::Result<calib::UnitInput> unit_of(const calib::Calibration& calibration) {
  auto type = known_unit_type(calibration.unit_type);
  if (!type) return base::forward_error(type);
  calib::UnitInput input;
  input.unit = calibration.unit;
  input.type = *std::move(type);
  input.epoch = calibration.epoch;
  return input;
}

base::Result<calib::RunInput> load_run(const db::Catalog& catalog, const db::RunRow& run) {
  // Statistics without the samples they came from could not be checked any more.
  if (auto sound = catalog.check_run_file(run); !sound) return base::forward_error(sound);
  auto segments = catalog.segments(run.run_id, run.unit, true);
  if (!segments) return base::forward_error(segments);
  const auto own_thermometer = calib::own_thermometers(*segments);
  return calib::RunInput{run.run_id,    run.label, run.campaign,         run.content_sha256,
                         run.simulated, run.site,  *std::move(segments), own_thermometer};
}

base::Status check_campaign_known(const db::Catalog& catalog, const std::string& campaign) {
  auto names = catalog.campaigns();
  if (!names) return base::forward_error(names);
  if (std::ranges::find(*names, campaign) != names->end()) return {};
  if (names->empty()) return base::bad_input(fmt::format("there is no campaign '{}', nor any other", campaign));
  const std::size_t all = names->size();
  if (all > kCampaignsListed) names->resize(kCampaignsListed);
  return base::bad_input(fmt::format("there is no campaign '{}'; there {} {}{}", campaign, all == 1 ? "is" : "are",
                                     fmt::join(*names, ", "), all > kCampaignsListed ? " and more" : ""),
                         "--campaign");
}

base::Result<calib::UnitInput> load_unit(const db::Catalog& catalog, const std::string& unit,
                                         const std::optional<std::string>& campaign,
                                         std::vector<calib::Warning>& warnings) {
  const auto row = catalog.unit(unit);
  if (!row) return base::forward_error(row);
  if (!*row) return base::bad_input(fmt::format("no unit '{}' in this data folder; 'soak unit list' shows them", unit));
  if (campaign) {
    if (auto known = check_campaign_known(catalog, *campaign); !known) return base::forward_error(known);
  }
  const auto runs = catalog.runs({.unit = unit, .campaign = campaign, .run = {}});
  if (!runs) return base::forward_error(runs);
  calib::UnitInput input;
  input.unit = unit;
  auto type = known_unit_type((*row)->type);
  if (!type) return base::forward_error(type);
  input.type = *std::move(type);
  input.epoch = (*row)->epoch;
  for (const db::RunRow& run : *runs) {
    if (!run.sealed || run.voided || run.epoch != input.epoch || run.purpose != kCalibration) continue;
    auto loaded = load_run(catalog, run);
    if (!loaded) return base::forward_error(loaded);
    input.runs.push_back(*std::move(loaded));
  }
  if (input.runs.empty()) return base::bad_input(reason_without_runs(unit, campaign, *runs));
  for (calib::Warning& warning : unit_type_warnings(input.type.name)) warnings.push_back(std::move(warning));
  calib::leave_out_copies(input.runs, warnings);
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input.runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input.references = *std::move(references);
  return input;
}

base::Result<calib::UnitModel> fit_unit(db::Catalog& catalog, const calib::UnitInput& input,
                                        const calib::CurveFitOptions& options, int jobs,
                                        const std::vector<calib::Warning>& station_warnings) {
  const auto rows = calib::make_rows(input);
  if (!rows) return base::forward_error(rows);
  auto fits = fit_sensors(*rows, options, jobs);
  if (interrupted()) {
    return base::fail(base::ErrorKind::internal, "interrupted; no model was stored",
                      fmt::format("unit {}", input.unit));
  }
  std::array<std::optional<calib::SensorFit>, calib::kSensorCount> sensors;
  for (std::size_t s = 0; s < fits.size(); ++s) {
    if (!fits[s]) continue;
    if (!*fits[s]) {
      base::Error error = fits[s]->error();
      error.where = fmt::format("unit {}, {}", input.unit, error.where);
      return tl::unexpected<base::Error>(std::move(error));
    }
    sensors[s] = **std::move(fits[s]);
  }
  calib::UnitModel model = calib::make_model(input, *rows, std::move(sensors));
  model.created_utc_s = now_utc_s();
  model.options = options;
  model.warnings.insert(model.warnings.end(), station_warnings.begin(), station_warnings.end());
  // Whether the model can be stored does not depend on its number, which is known only inside the transaction.
  if (const auto document = calib::model_document(model); !document) return base::forward_error(document);
  const auto version = catalog.add_model(input.unit, input.epoch, model.created_utc_s, [&](std::int32_t number) {
    model.version = number;
    return *calib::model_document(model);
  });
  if (!version) return base::forward_error(version);
  model.version = *version;
  return model;
}

}  // namespace soak::station
