// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/slow_noise.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/gap/effects/columns.h"
#include "calib/gap/noise/wander_estimate.h"
#include "calib/gap/search/detail/slow_noise.h"

namespace soak::calib::gap {
namespace {

constexpr double kHour_s = 3600.0;

std::optional<InstabilityAtRest> at_rest_of(const nlohmann::json& entry, double factor) {
  if (!entry.is_object()) return std::nullopt;
  return InstabilityAtRest{.value = entry.at("value").get<double>() / factor,
                           .low = entry.at("ci95").at(0).get<double>() / factor,
                           .high = entry.at("ci95").at(1).get<double>() / factor,
                           .tau_s = entry.at("tau_s").get<double>(),
                           .campaign = entry.at("campaign").get<std::string>(),
                           .run = entry.at("run").get<std::string>(),
                           .duration_s = entry.at("duration_s").get<double>()};
}

}  // namespace

double wander_variance(const Observations& observations, const std::vector<GaussMarkov>& wander) {
  double sum = 0.0;
  for (int run = 0; run < observations.run_count(); ++run) sum += variance_about_mean(observations, wander, run);
  return sum / observations.run_count();
}

std::optional<KnownNoise> wandering_noise(const CampaignModel& model, const std::vector<NamedEffect>& effects,
                                          const std::vector<Sensor>& sensors) {
  constexpr int kLeastRunsOfWander = 4;
  const RegressorInputs in = model.regressor_inputs();
  if (sensors.empty() || in.observations.run_count() < kLeastRunsOfWander) return std::nullopt;
  const Eigen::MatrixXd of_day = time_of_day(in);
  KnownNoise noise = model.residuals().noise;
  std::optional<WanderEstimate> estimate;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    const Eigen::VectorXd left = unexplained(model, effects, sensor);
    if (!estimate || !estimate->is_for(left)) estimate.emplace(in.observations, left, of_day);
    if (auto found = estimate->of(left, noise[index_of(sensor)])) noise[index_of(sensor)] = *std::move(found);
  }
  const auto wanders = [&](Sensor sensor) { return !noise[index_of(sensor)].wander.empty(); };
  if (std::none_of(sensors.begin(), sensors.end(), wanders)) return std::nullopt;
  return noise;
}

std::vector<SensorWander> slow_noise_in(const Observations& observations, const KnownNoise& noise) {
  std::vector<SensorWander> list;
  for (const Sensor sensor : kSensors) {
    const std::vector<GaussMarkov>& wander = noise[index_of(sensor)].wander;
    if (wander.empty()) continue;
    std::vector<GaussMarkov> fast;
    std::ranges::copy_if(wander, std::back_inserter(fast),
                         [](const GaussMarkov& process) { return process.tau_s < kHour_s; });
    const double variance = wander_variance(observations, wander);
    const double minutes = variance > 0.0 ? wander_variance(observations, fast) / variance : 0.0;
    list.push_back({sensor, std::sqrt(variance), minutes, 1.0 - minutes});
  }
  return list;
}

nlohmann::json slow_noise_json(const std::vector<SensorWander>& wanders) {
  nlohmann::json list = nlohmann::json::array();
  for (const SensorWander& wander : wanders) {
    const double factor = printed_per_si(wander.sensor);
    nlohmann::json at_rest;
    if (const auto& rest = wander.at_rest) {
      at_rest = {{"value", rest->value * factor},
                 {"ci95", {rest->low * factor, rest->high * factor}},
                 {"tau_s", rest->tau_s},
                 {"campaign", rest->campaign},
                 {"run", rest->run},
                 {"duration_s", rest->duration_s}};
    }
    list.push_back({{"sensor", name_of(wander.sensor)},
                    {"unit", printed_unit(wander.sensor)},
                    {"within_run", wander.within_run * factor},
                    {"share_minutes", wander.share_minutes},
                    {"share_hours", wander.share_hours},
                    {"bias_instability", std::move(at_rest)}});
  }
  return list;
}

std::vector<SensorWander> slow_noise_of(const nlohmann::json& document) {
  std::vector<SensorWander> wanders;
  const auto list = document.find("slow_noise");
  if (list == document.end()) return wanders;
  for (const nlohmann::json& entry : *list) {
    const auto sensor = sensor_named(entry.at("sensor").get<std::string>());
    if (!sensor) continue;
    const double factor = printed_per_si(*sensor);
    wanders.push_back({*sensor, entry.at("within_run").get<double>() / factor, entry.at("share_minutes").get<double>(),
                       entry.at("share_hours").get<double>(), at_rest_of(entry.at("bias_instability"), factor)});
  }
  return wanders;
}

}  // namespace soak::calib::gap
