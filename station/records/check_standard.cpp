// SPDX-License-Identifier: Apache-2.0
#include "station/records/check_standard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace soak::station {
namespace {

using calib::ControlVerdict;
using calib::Estimate;
using calib::kSensorCount;
using calib::Sensor;
using nlohmann::json;

/// A unit as check standard: its last record, and from when on its runs count.
struct Declared {
  std::string unit;
  double from_utc_s = -std::numeric_limits<double>::infinity();
  std::optional<db::EndRecord> ended;

  [[nodiscard]] bool holds(double utc_s) const { return utc_s > from_utc_s && (!ended || utc_s <= ended->utc_s); }
};

/// The records come in the order in which they were made; a unit's next one begins a new chart.
std::vector<Declared> declared_of(const std::vector<db::CheckStandardRow>& records) {
  std::vector<Declared> all;
  for (const db::CheckStandardRow& record : records) {
    auto known = std::ranges::find(all, record.unit, &Declared::unit);
    if (known == all.end()) {
      all.push_back({record.unit, -std::numeric_limits<double>::infinity(), record.ended});
      continue;
    }
    if (known->ended) known->from_utc_s = known->ended->utc_s;
    known->ended = record.ended;
  }
  return all;
}

base::Result<CheckRun> load(const db::Catalog& catalog, const db::RunRow& row, const calib::UnitType& type) {
  constexpr bool with_blocks = false;
  auto segments = catalog.segments(row.run_id, row.unit, with_blocks);
  if (!segments) return base::forward_error(segments);
  calib::RunInput run;
  run.label = row.label;
  run.site = row.site;
  run.segments = *std::move(segments);
  return CheckRun{row.label, calib::reference_plateau(run, type)};
}

/// Mean of the runs' values; standard error from their scatter, of one value its own.
std::optional<Estimate> mean_of(const std::vector<Estimate>& values) {
  if (values.empty()) return std::nullopt;
  if (values.size() == 1) return values.front();
  const auto n = static_cast<double>(values.size());
  double mean = 0.0;
  for (const Estimate& value : values) mean += value.value / n;
  double squares = 0.0;
  for (const Estimate& value : values) squares += (value.value - mean) * (value.value - mean);
  return Estimate{mean, std::sqrt(squares / (n - 1.0) / n)};
}

/// Mean temperature of a sensor over the runs that were near the reference plateau.
std::optional<double> mean_temp_c(const CheckCampaign& campaign, std::size_t s) {
  double sum = 0.0;
  int runs = 0;
  for (const CheckRun& run : campaign.runs) {
    if (!run.reference.sensor[s]) continue;
    sum += run.reference.sensor[s]->temp_c;
    ++runs;
  }
  return runs > 0 ? std::optional(sum / runs) : std::nullopt;
}

std::optional<CheckSensor> sensor_of(const CheckCampaign& campaign, std::size_t s, double temp_c) {
  std::vector<Estimate> biases;
  std::vector<Estimate> drifts;
  for (const CheckRun& run : campaign.runs) {
    const auto& reference = run.reference.sensor[s];
    if (!reference) continue;
    if (const auto bias = calib::carried_to(*reference, temp_c)) biases.push_back(*bias);
    if (reference->drift) drifts.push_back(*reference->drift);
  }
  const auto bias = mean_of(biases);
  if (!bias) return std::nullopt;
  return CheckSensor{*bias, mean_of(drifts), {}};
}

/// Takes the biases of one sensor out of the runs and judges them.
void chart_sensor(CheckChart& chart, std::size_t s) {
  std::vector<CheckSensor*> points;
  std::vector<double> values;
  for (CheckCampaign& campaign : chart.campaigns) {
    if (!chart.temp_c[s]) chart.temp_c[s] = mean_temp_c(campaign, s);
    if (!chart.temp_c[s]) continue;
    campaign.sensor[s] = sensor_of(campaign, s, *chart.temp_c[s]);
    if (!campaign.sensor[s]) continue;
    points.push_back(&*campaign.sensor[s]);
    values.push_back(points.back()->bias.value);
  }
  const auto judged = calib::control_chart(values);
  for (std::size_t i = 0; i < points.size(); ++i) points[i]->point = judged[i];
}

ControlVerdict verdict_of(const CheckCampaign& campaign) {
  const auto any = [&](ControlVerdict verdict) {
    return std::ranges::any_of(campaign.sensor,
                               [verdict](const auto& sensor) { return sensor && sensor->point.verdict == verdict; });
  };
  if (any(ControlVerdict::out_of_control)) return ControlVerdict::out_of_control;
  return any(ControlVerdict::in_control) ? ControlVerdict::in_control : ControlVerdict::not_established;
}

bool counts(const db::RunRow& run, std::int32_t epoch, const Declared& declared) {
  return run.sealed && !run.voided && run.epoch == epoch && run.purpose == "calibration" &&
         declared.holds(run.created_utc_s);
}

/// The campaigns of the runs that count, in the order of their first runs.
base::Result<std::vector<CheckCampaign>> load_campaigns(const db::Catalog& catalog, const Declared& declared,
                                                        const db::UnitRow& unit) {
  auto rows = catalog.runs({.unit = declared.unit, .campaign = {}, .run = {}});
  if (!rows) return base::forward_error(rows);
  std::erase_if(*rows, [&](const db::RunRow& run) { return !counts(run, unit.epoch, declared); });
  std::ranges::stable_sort(*rows, {}, &db::RunRow::created_utc_s);
  calib::UnitType type;
  type.name = unit.type;
  std::vector<CheckCampaign> campaigns;
  for (const db::RunRow& row : *rows) {
    auto run = load(catalog, row, type);
    if (!run) return base::forward_error(run);
    auto campaign = std::ranges::find(campaigns, row.campaign, &CheckCampaign::name);
    if (campaign == campaigns.end()) {
      campaigns.emplace_back();
      campaign = campaigns.end() - 1;
      campaign->name = row.campaign;
      campaign->created_utc_s = row.created_utc_s;
    }
    campaign->simulated = campaign->simulated || row.simulated;
    campaign->runs.push_back(*std::move(run));
  }
  return campaigns;
}

base::Result<CheckChart> chart_of(const db::Catalog& catalog, const Declared& declared) {
  const auto unit = catalog.unit(declared.unit);
  if (!unit) return base::forward_error(unit);
  auto campaigns = load_campaigns(catalog, declared, **unit);
  if (!campaigns) return base::forward_error(campaigns);
  CheckChart chart{declared.unit, (*unit)->epoch, declared.ended, {}, *std::move(campaigns)};
  for (std::size_t s = 0; s < kSensorCount; ++s) chart_sensor(chart, s);
  for (CheckCampaign& campaign : chart.campaigns) campaign.verdict = verdict_of(campaign);
  return chart;
}

std::string finding(Sensor sensor, const calib::ControlPoint& point) {
  const double factor = calib::printed_per_si(sensor);
  const auto unit = calib::printed_unit(sensor);
  if (!point.beyond_limits()) {
    const calib::ControlShift& shift = *point.shift;
    return fmt::format(
        "{} reads {:.5g} {} on average over the last {} campaigns, outside {:.5g} to {:.5g} of {} campaigns before",
        calib::name_of(sensor), shift.mean * factor, unit, calib::kShiftValues, shift.limits.lower * factor,
        shift.limits.upper * factor, shift.limits.values);
  }
  return fmt::format("{} reads {:.5g} {}, outside {:.5g} to {:.5g} of {} campaigns before", calib::name_of(sensor),
                     point.value * factor, unit, point.limits->lower * factor, point.limits->upper * factor,
                     point.limits->values);
}

CheckVerdict verdict_on(const CheckChart& chart, const CheckCampaign& campaign) {
  CheckVerdict verdict{chart.unit, campaign.name, campaign.verdict, {}};
  for (const Sensor sensor : calib::kSensors) {
    const auto& charted = campaign.sensor[calib::index_of(sensor)];
    if (!charted || charted->point.verdict != ControlVerdict::out_of_control) continue;
    verdict.findings.push_back(finding(sensor, charted->point));
  }
  return verdict;
}

base::Result<std::vector<Declared>> wanted(const db::Catalog& catalog, const std::optional<std::string>& unit) {
  const auto records = catalog.check_standards();
  if (!records) return base::forward_error(records);
  auto declared = declared_of(*records);
  if (unit) {
    std::erase_if(declared, [&](const Declared& one) { return one.unit != *unit; });
    if (declared.empty()) {
      return base::bad_input(fmt::format("unit '{}' is not a check standard: 'soak check declare' makes it one", *unit),
                             "--unit");
    }
    return declared;
  }
  std::erase_if(declared, [](const Declared& one) { return one.ended.has_value(); });
  if (!declared.empty()) return declared;
  return base::bad_input("this station has no check standard: 'soak check declare' makes a unit one",
                         catalog.data_folder().string());
}

/// NAME and NAME_se in printed units; null where there is none.
void put_estimate(json& document, const std::string& name, const std::optional<Estimate>& estimate, double factor) {
  document[name] = estimate ? json(estimate->value * factor) : json();
  document[name + "_se"] = estimate ? json(estimate->standard_error * factor) : json();
}

json control_limits_json(const calib::ControlLimits& limits, double factor) {
  return {{"campaigns", limits.values},     {"centre", limits.centre * factor},
          {"lower", limits.lower * factor}, {"upper", limits.upper * factor},
          {"sigma", limits.sigma * factor}, {"moving_range_upper", limits.moving_range_upper * factor}};
}

json control_shift_json(const std::optional<calib::ControlShift>& shift, double factor) {
  if (!shift) return {};
  return {{"mean", shift->mean * factor},
          {"lower", shift->limits.lower * factor},
          {"upper", shift->limits.upper * factor},
          {"campaigns", shift->limits.values}};
}

json check_point_json(const CheckSensor& sensor, double factor) {
  const calib::ControlPoint& point = sensor.point;
  json document = {{"verdict", calib::name_of(point.verdict)},
                   {"beyond_limits", point.beyond_limits()},
                   {"shifted", point.shifted()},
                   {"last_eight", control_shift_json(point.shift, factor)},
                   {"limits", point.limits ? control_limits_json(*point.limits, factor) : json()},
                   {"moving_range", point.moving_range ? json(*point.moving_range * factor) : json()}};
  put_estimate(document, "bias", sensor.bias, factor);
  put_estimate(document, "drift", sensor.drift, factor);
  return document;
}

json check_run_json(const CheckRun& run) {
  json sensors = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& reference = run.reference.sensor[calib::index_of(sensor)];
    if (!reference) continue;
    const double factor = calib::printed_per_si(sensor);
    json& document = sensors[std::string(calib::name_of(sensor))] = {{"temp_c", reference->temp_c}};
    put_estimate(document, "bias", reference->bias, factor);
    put_estimate(document, "first", reference->first, factor);
    put_estimate(document, "last", reference->last, factor);
    put_estimate(document, "drift", reference->drift, factor);
  }
  return {{"run", run.label},
          {"at_both_ends", run.reference.at_both_ends},
          {"visits", run.reference.visits},
          {"sensors", std::move(sensors)}};
}

json check_campaign_json(const CheckCampaign& campaign) {
  json sensors = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& charted = campaign.sensor[calib::index_of(sensor)];
    if (charted) {
      sensors[std::string(calib::name_of(sensor))] = check_point_json(*charted, calib::printed_per_si(sensor));
    }
  }
  json runs = json::array();
  for (const CheckRun& run : campaign.runs) runs.push_back(check_run_json(run));
  return {{"campaign", campaign.name},       {"created_utc_s", campaign.created_utc_s},
          {"simulated", campaign.simulated}, {"verdict", calib::name_of(campaign.verdict)},
          {"sensors", std::move(sensors)},   {"runs", std::move(runs)}};
}

json check_chart_json(const CheckChart& chart) {
  json temps = json::object();
  for (const Sensor sensor : calib::kSensors) {
    const auto& temp_c = chart.temp_c[calib::index_of(sensor)];
    if (temp_c) temps[std::string(calib::name_of(sensor))] = *temp_c;
  }
  json campaigns = json::array();
  for (const CheckCampaign& campaign : chart.campaigns) campaigns.push_back(check_campaign_json(campaign));
  return {{"unit", chart.unit},
          {"epoch", chart.epoch},
          {"ended", chart.ended.has_value()},
          {"temp_c", std::move(temps)},
          {"campaigns", std::move(campaigns)}};
}

}  // namespace

base::Result<std::vector<CheckChart>> check_charts(const db::Catalog& catalog, const std::optional<std::string>& unit) {
  const auto declared = wanted(catalog, unit);
  if (!declared) return base::forward_error(declared);
  std::vector<CheckChart> charts;
  for (const Declared& one : *declared) {
    auto chart = chart_of(catalog, one);
    if (!chart) return base::forward_error(chart);
    charts.push_back(*std::move(chart));
  }
  return charts;
}

base::Result<std::vector<CheckChart>> check_charts_of(const db::Catalog& catalog,
                                                      const std::set<std::string>& campaigns) {
  const auto records = catalog.check_standards();
  if (!records) return base::forward_error(records);
  std::vector<CheckChart> charts;
  for (const Declared& declared : declared_of(*records)) {
    const auto runs = catalog.runs({.unit = declared.unit, .campaign = {}, .run = {}});
    if (!runs) return base::forward_error(runs);
    if (std::ranges::none_of(*runs, [&](const db::RunRow& run) { return campaigns.contains(run.campaign); })) continue;
    auto chart = chart_of(catalog, declared);
    if (!chart) return base::forward_error(chart);
    const auto is_one = [&](const CheckCampaign& campaign) { return campaigns.contains(campaign.name); };
    if (std::ranges::any_of(chart->campaigns, is_one)) charts.push_back(*std::move(chart));
  }
  return charts;
}

base::Result<std::vector<CheckVerdict>> check_standard_of(const db::Catalog& catalog, std::string_view campaign) {
  const std::string name(campaign);
  const auto charts = check_charts_of(catalog, {name});
  if (!charts) return base::forward_error(charts);
  std::vector<CheckVerdict> verdicts;
  for (const CheckChart& chart : *charts) {
    verdicts.push_back(verdict_on(chart, *std::ranges::find(chart.campaigns, name, &CheckCampaign::name)));
  }
  return verdicts;
}

base::Result<std::optional<std::string>> missing_check_standard(const db::Catalog& catalog,
                                                                const std::vector<std::string>& units) {
  const auto records = catalog.check_standards();
  if (!records) return base::forward_error(records);
  std::vector<std::string> standards;
  for (const db::CheckStandardRow& record : *records) {
    if (record.ended) continue;
    if (std::ranges::find(units, record.unit) != units.end()) return std::nullopt;
    standards.push_back(record.unit);
  }
  if (standards.empty()) return std::nullopt;
  return fmt::format(
      "no check standard is among the units: this campaign cannot show whether the station has changed; check "
      "standards of the station: {}",
      fmt::join(standards, ", "));
}

std::optional<calib::Warning> warning_of(const CheckVerdict& verdict) {
  if (verdict.verdict != ControlVerdict::out_of_control) return std::nullopt;
  return calib::Warning{
      "check_standard_out_of_control",
      fmt::format("check standard {} of campaign '{}' is out of control at {:g} °C: {}; do not trust the results of "
                  "this campaign until the cause is known ('soak check chart' shows all campaigns)",
                  verdict.unit, verdict.campaign, calib::kReferencePlateau_c, fmt::join(verdict.findings, "; "))};
}

json check_document(const std::vector<CheckChart>& charts) {
  json units = json::array();
  for (const CheckChart& chart : charts) units.push_back(check_chart_json(chart));
  return {{"reference_c", calib::kReferencePlateau_c}, {"units", std::move(units)}};
}

}  // namespace soak::station
