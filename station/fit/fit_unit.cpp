// SPDX-License-Identifier: Apache-2.0
#include "station/fit/fit_unit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

#include "calib/forward/simulation.h"
#include "calib/model/model_document.h"
#include "db/run/run_file.h"
#include "station/config/unit_type_file.h"
#include "station/fit/fit_inputs.h"
#include "station/fit/fleet_hysteresis.h"
#include "station/fit/reference_rule.h"
#include "station/gap/gap_search.h"
#include "station/io/host.h"
#include "station/io/output.h"
#include "station/records/check_standard.h"
#include "station/runs/recording_reader.h"

namespace soak::station {
namespace {

constexpr std::string_view kForCalibration = "calibration";
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

/// The references of the campaigns of the unit's runs.
base::Status load_references(const db::Catalog& catalog, calib::UnitInput& input) {
  std::vector<std::string> campaigns;
  for (const calib::RunInput& run : input.runs) campaigns.push_back(run.campaign);
  auto references = references_of_campaigns(catalog, campaigns);
  if (!references) return base::forward_error(references);
  input.references = *std::move(references);
  return {};
}

/// Fits the sensors that have rows, each on the first free thread.
std::array<std::optional<base::Result<calib::SensorFit>>, calib::kSensorCount> fit_sensors(
    const calib::UnitRows& rows, const calib::CurveFitOptions& options, const FitWork& work) {
  std::array<std::optional<base::Result<calib::SensorFit>>, calib::kSensorCount> fits;
  std::atomic<std::size_t> next = 0;
  std::mutex telling;
  std::size_t done = 0;
  const auto tell = [&] {
    const std::lock_guard lock(telling);
    if (work.progress) work.progress(static_cast<double>(++done) / static_cast<double>(calib::kSensorCount));
  };
  if (work.progress) work.progress(0.0);
  const auto take_turns = [&] {
    for (std::size_t s = next++; s < calib::kSensorCount && !interrupted(); s = next++) {
      if (rows.bias[s]) fits[s] = calib::fit_sensor(rows, calib::kSensors[s], options);
      tell();
    }
  };
  const auto threads =
      static_cast<std::size_t>(work.jobs > 0 ? work.jobs : static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::jthread> pool;
  for (std::size_t t = 1; t < std::clamp<std::size_t>(threads, 1, calib::kSensorCount); ++t) {
    pool.emplace_back(take_turns);
  }
  take_turns();
  pool.clear();
  return fits;
}

/// Content hashes of the runs that a model was fitted to.
base::Result<std::set<std::string>> run_hashes_of(const db::ModelRow& model) {
  const auto calibration = calib::calibration_of(model.document);
  if (!calibration) return base::forward_error(calibration);
  return std::set<std::string>(calibration->run_hashes.begin(), calibration->run_hashes.end());
}

}  // namespace

// What is fitted.

bool is_for_fit(const db::RunRow& run, std::int32_t epoch) {
  return run.sealed && !run.voided && run.epoch == epoch && run.purpose == kForCalibration;
}

base::Result<calib::UnitInput> unit_of(const calib::Calibration& calibration) {
  auto type = known_unit_type(calibration.unit_type);
  if (!type) return base::forward_error(type);
  calib::UnitInput input;
  input.unit = calibration.unit;
  input.type = *std::move(type);
  input.epoch = calibration.epoch;
  return input;
}

base::Result<calib::RunInput> load_run(const db::Catalog& catalog, const db::RunRow& run, const calib::UnitType& type) {
  if (auto sound = catalog.check_run_file(run); !sound) return base::forward_error(sound);
  auto segments = catalog.segments(run.run_id, run.unit, true);
  if (!segments) return base::forward_error(segments);
  const auto own_thermometer = calib::own_thermometers(*segments);
  std::vector<calib::Move> moves;
  if (calib::is_bench_session(*segments) && !run.samples_dropped) {
    // What a unit does between its rests is in no segment.
    const auto file = catalog.open_run_file(run);
    if (!file) return base::forward_error(file);
    const auto recording = read_recording(*file, run.unit);
    if (!recording) return base::forward_error(recording);
    moves = calib::moves_between(*recording, *segments, type);
  }
  return calib::RunInput{run.run_id,           run.label,       run.campaign,
                         run.content_sha256,   run.simulated,   run.site,
                         *std::move(segments), own_thermometer, std::move(moves)};
}

base::Status check_campaign_known(const db::Catalog& catalog, const std::string& campaign) {
  auto names = catalog.campaigns();
  if (!names) return base::forward_error(names);
  if (std::ranges::find(*names, campaign) != names->end()) return {};
  if (names->empty()) {
    return base::bad_input(fmt::format("unknown campaign '{}': this data folder has no campaign yet", campaign),
                           "--campaign");
  }
  const bool more = names->size() > kCampaignsListed;
  if (more) names->resize(kCampaignsListed);
  return base::bad_input(fmt::format("unknown campaign '{}': known are {}{}", campaign, fmt::join(*names, ", "),
                                     more ? " and others" : ""),
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
    if (!is_for_fit(run, input.epoch)) continue;
    auto recorded = load_run(catalog, run, input.type);
    if (!recorded) return base::forward_error(recorded);
    input.runs.push_back(*std::move(recorded));
  }
  if (input.runs.empty()) return base::bad_input(reason_without_runs(unit, campaign, *runs));
  for (calib::Warning& warning : unit_type_warnings(input.type.name)) warnings.push_back(std::move(warning));
  calib::leave_out_copies(input.runs, warnings);
  if (auto found = load_references(catalog, input); !found) return base::forward_error(found);
  return input;
}

base::Result<std::string> why_nothing_to_fit(const db::Catalog& catalog, const std::string& unit) {
  const auto row = catalog.unit(unit);
  if (!row) return base::forward_error(row);
  const auto runs = catalog.runs({.unit = unit, .campaign = {}, .run = {}});
  if (!runs) return base::forward_error(runs);
  const std::int32_t epoch = *row ? (*row)->epoch : 0;
  const auto fits = [&](const db::RunRow& run) { return is_for_fit(run, epoch); };
  return std::ranges::any_of(*runs, fits) ? std::string() : reason_without_runs(unit, {}, *runs);
}

// Accepted terms.

base::Result<std::vector<calib::ModelTerm>> accepted_terms(const db::Catalog& catalog, const std::string& unit,
                                                           std::int32_t epoch) {
  const auto model = catalog.model(unit);
  if (!model) return base::forward_error(model);
  if (!*model || (*model)->epoch != epoch) return std::vector<calib::ModelTerm>();
  return calib::model_terms_of((*model)->document);
}

base::Status take_terms_off(const db::Catalog& catalog, const std::vector<calib::ModelTerm>& terms,
                            calib::UnitInput& input, std::vector<calib::Warning>& warnings) {
  if (terms.empty()) return {};
  auto logged = with_logs(catalog, input, false);
  if (!logged) {
    base::Error error = logged.error();
    error.message = fmt::format("the model's accepted terms are taken off the samples: {}", error.message);
    return tl::unexpected<base::Error>(std::move(error));
  }
  // Mountings scatter, and the misalignment of the next one is as uncertain as that says: a fit must see it. A bump is
  // part of the curve that is fitted.
  std::vector<calib::ModelTerm> of_the_unit = terms;
  std::erase_if(of_the_unit,
                [](const calib::ModelTerm& term) { return term.name == "fixture_tilt" || term.name == "narrow_bump"; });
  for (std::string& sentence : calib::forward::subtract_terms(of_the_unit, *logged)) {
    warnings.push_back({"term_not_evaluated", std::move(sentence)});
  }
  input.runs.clear();
  for (calib::gap::LoggedRun& run : logged->runs) input.runs.push_back(std::move(run.run));
  input.terms = terms;
  return {};
}

// The fit.

base::Result<std::vector<calib::Warning>> CheckWarnings::of_campaign(const std::string& campaign) {
  const auto known = known_.find(campaign);
  if (known != known_.end()) return known->second;
  const auto verdicts = check_standard_of(catalog_, campaign);
  if (!verdicts) return base::forward_error(verdicts);
  std::vector<calib::Warning> warnings;
  for (const CheckVerdict& verdict : *verdicts) {
    if (auto warning = warning_of(verdict)) warnings.push_back(*std::move(warning));
  }
  return known_.emplace(campaign, std::move(warnings)).first->second;
}

base::Result<std::vector<calib::Warning>> CheckWarnings::of(const calib::UnitInput& input) {
  std::set<std::string> campaigns;
  for (const calib::RunInput& run : input.runs) campaigns.insert(run.campaign);
  std::vector<calib::Warning> all;
  for (const std::string& campaign : campaigns) {
    const auto warnings = of_campaign(campaign);
    if (!warnings) return base::forward_error(warnings);
    all.insert(all.end(), warnings->begin(), warnings->end());
  }
  return all;
}

base::Result<PreparedFit> prepare_fit(const db::Catalog& catalog, calib::UnitInput input,
                                      const std::vector<calib::ModelTerm>& terms, CheckWarnings& check_warnings,
                                      std::vector<calib::Warning> warnings) {
  const auto checks = check_warnings.of(input);
  if (!checks) return base::forward_error(checks);
  warnings.insert(warnings.end(), checks->begin(), checks->end());
  const auto since = reference_warnings(catalog, input.references);
  if (!since) return base::forward_error(since);
  warnings.insert(warnings.end(), since->begin(), since->end());
  if (const auto taken = take_terms_off(catalog, terms, input, warnings); !taken) return base::forward_error(taken);
  auto rows = calib::make_rows(input);
  if (!rows) return base::forward_error(rows);
  return PreparedFit{std::move(input), *std::move(rows), std::move(warnings)};
}

base::Result<calib::UnitModel> fitted_model(const PreparedFit& prepared, const calib::CurveFitOptions& options,
                                            const FitWork& work) {
  auto fits = fit_sensors(prepared.rows, options, work);
  if (interrupted()) {
    return base::fail(base::ErrorKind::internal, "interrupted; no model was stored",
                      fmt::format("unit {}", prepared.input.unit));
  }
  std::array<std::optional<calib::SensorFit>, calib::kSensorCount> sensors;
  for (std::size_t s = 0; s < fits.size(); ++s) {
    if (!fits[s]) continue;
    if (!*fits[s]) {
      base::Error error = fits[s]->error();
      error.where = fmt::format("unit {}, {}", prepared.input.unit, error.where);
      return tl::unexpected<base::Error>(std::move(error));
    }
    sensors[s] = **std::move(fits[s]);
  }
  calib::UnitModel model = calib::make_model(prepared.rows, std::move(sensors));
  model.options = options;
  model.warnings.insert(model.warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
  // Whether the model can be written does not depend on its number, which is known only inside the transaction.
  if (const auto document = calib::model_document(model); !document) return base::forward_error(document);
  return model;
}

base::Status store_model(db::Catalog& catalog, calib::UnitModel& model, const FitInputs& inputs) {
  model.created_utc_s = inputs.seen_utc_s;
  std::optional<db::ModelOrigin> origin;
  if (!inputs.sha256.empty()) origin = db::ModelOrigin{software_version(), inputs.sha256};
  const auto version = catalog.add_model(
      model.unit, model.epoch, model.created_utc_s,
      [&](std::int32_t number) {
        model.version = number;
        return *calib::model_document(model);
      },
      origin);
  if (!version) return base::forward_error(version);
  model.version = *version;
  return {};
}

base::Result<calib::UnitModel> fit_with_terms(db::Catalog& catalog, calib::UnitInput& input,
                                              const std::vector<calib::ModelTerm>& terms,
                                              const calib::CurveFitOptions& options, const FitWork& work,
                                              CheckWarnings& check_warnings, std::vector<calib::Warning> warnings,
                                              const FitInputs& inputs) {
  auto prepared = prepare_fit(catalog, std::move(input), terms, check_warnings, std::move(warnings));
  if (!prepared) return base::forward_error(prepared);
  if (asks_fleet(prepared->rows)) {
    const auto fleet =
        hysteresis_of_fleet(catalog, prepared->rows.unit_type, prepared->rows.simulated, {prepared->rows.unit});
    if (!fleet) return base::forward_error(fleet);
    take_from_fleet(*fleet, prepared->rows);
  }
  auto model = fitted_model(*prepared, options, work);
  if (!model) return model;
  if (auto stored = store_model(catalog, *model, inputs); !stored) return base::forward_error(stored);
  input = std::move(prepared->input);
  return model;
}

base::Result<calib::UnitModel> fit_again(db::Catalog& catalog, const db::ModelRow& parent,
                                         const std::vector<calib::ModelTerm>& terms) {
  const auto options = calib::fit_options_of(parent.document);
  if (!options) return base::forward_error(options);
  auto known = run_hashes_of(parent);
  if (!known) return base::forward_error(known);
  auto inputs = fit_inputs_now(catalog, parent.unit, {}, terms, *options);
  if (!inputs) return base::forward_error(inputs);
  std::vector<calib::Warning> warnings;
  auto input = load_unit(catalog, parent.unit, {}, warnings);
  if (!input) return base::forward_error(input);
  const std::size_t all_runs = input->runs.size();
  std::erase_if(input->runs, [&](const calib::RunInput& run) { return known->count(run.content_sha256) == 0; });
  if (input->runs.empty()) {
    return base::bad_input(fmt::format("all runs of model {} of unit {} are void; 'soak fit --unit {}' fits the others",
                                       parent.version, parent.unit, parent.unit));
  }
  if (auto found = load_references(catalog, *input); !found) return base::forward_error(found);
  if (input->runs.size() < known->size()) {
    warnings.push_back(
        {"runs_left_since", fmt::format("of the {} runs of model {}, {} have since been voided and are left out",
                                        known->size(), parent.version, known->size() - input->runs.size())});
  }
  // A model of some of the runs is not the one that a fit of all would give.
  if (input->runs.size() < all_runs) inputs->sha256.clear();
  CheckWarnings check_warnings(catalog);
  return fit_with_terms(catalog, *input, terms, *options, FitWork{}, check_warnings, std::move(warnings), *inputs);
}

}  // namespace soak::station
