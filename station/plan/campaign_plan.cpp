// SPDX-License-Identifier: Apache-2.0
#include "station/plan/campaign_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace soak::station {
namespace {

using calib::kSensors;
using calib::Sensor;

constexpr double kTemperatureStep_c = 2.0;

std::vector<double> temperatures_between(double low_c, double high_c) {
  std::vector<double> temps_c;
  for (double temp_c = low_c; temp_c < high_c; temp_c += kTemperatureStep_c) temps_c.push_back(temp_c);
  temps_c.push_back(high_c);
  return temps_c;
}

base::Result<PlanOption> option_of(const PassDesign& design, const TypePicture& picture, const calib::UnitType& type) {
  const auto campaign = designed_campaign(design, {picture.low_c, picture.high_c, type});
  if (!campaign) return base::forward_error(campaign);
  PlanOption option;
  option.design = design;
  option.hours = campaign->hours;
  option.power_ons = calib::count_power_ons(campaign->recorded);
  const auto temps_c = temperatures_between(picture.low_c, picture.high_c);
  for (const Sensor sensor : kSensors) {
    const auto& known = picture.sensors[index_of(sensor)];
    if (!known) continue;
    auto band = calib::expected_band(*known, campaign->recorded, temps_c);
    if (!band) return base::forward_error(band);
    option.bands[index_of(sensor)] = std::move(*band);
  }
  return option;
}

/// What a sensor's bands may be at their widest; absent: anything.
struct Yardstick {
  std::optional<double> shape;
  std::optional<double> curve;
};
using Yardsticks = std::array<Yardstick, calib::kSensorCount>;

Yardsticks yardsticks_of(const PlanRequest& request, const PlanOption& full) {
  Yardsticks yardsticks;
  for (const Sensor sensor : kSensors) {
    const auto& band = full.bands[index_of(sensor)];
    if (!band) continue;
    Yardstick& yardstick = yardsticks[index_of(sensor)];
    if (request.gyro || request.accel) {
      yardstick.curve = is_gyro(sensor) ? request.gyro : request.accel;
    } else {
      yardstick = {band->worst_shape(), band->worst_curve()};
    }
  }
  return yardsticks;
}

double relative_to(const Yardsticks& yardsticks, const PlanOption& option) {
  double worst = 0.0;
  for (std::size_t s = 0; s < calib::kSensorCount; ++s) {
    const auto& [shape, curve] = yardsticks[s];
    if (shape) worst = std::max(worst, option.bands[s]->worst_shape() / *shape);
    if (curve) worst = std::max(worst, option.bands[s]->worst_curve() / *curve);
  }
  return worst;
}

/// Options of which none is longer and hardly better than another, rising hours; `options` come in that order.
std::vector<PlanOption> front_of(const std::vector<PlanOption>& options) {
  constexpr double kWorthwhile = 0.95;
  std::vector<PlanOption> front;
  double best = std::numeric_limits<double>::infinity();
  for (const PlanOption& option : options) {
    if (option.relative > kWorthwhile * best) continue;
    best = option.relative;
    front.push_back(option);
  }
  return front;
}

/// The option that the rule of plan_campaign() names, of options in rising hours.
base::Result<PlanOption> choose(const std::vector<PlanOption>& options, const PlanRequest& request) {
  const auto best = std::ranges::min_element(options, {}, &PlanOption::relative);
  const auto enough = std::ranges::find_if(options, [](const PlanOption& option) { return option.relative <= 1.0; });
  if (!request.hours) {
    if (enough != options.end()) return *enough;
    if (!request.gyro && !request.accel) {
      return base::bad_input(
          fmt::format("no design is expected to be as good as the full campaign: the best one, of {:.1f} h, has a band "
                      "{:.2f} times as wide; say what you need with --accuracy, or give --hours",
                      best->hours, best->relative),
          "--type");
    }
    return base::bad_input(fmt::format("no design reaches the accuracy: the best one, of {:.1f} h, has a band {:.2f} "
                                       "times as wide; ask for that, or give --hours",
                                       best->hours, best->relative),
                           "--accuracy");
  }
  if (options.front().hours > *request.hours) {
    return base::bad_input(fmt::format("no design is that short: the shortest takes {:.1f} h", options.front().hours),
                           "--hours");
  }
  if (enough != options.end() && enough->hours <= *request.hours) return *enough;
  const auto behind = std::ranges::find_if(options, [&](const PlanOption& o) { return o.hours > *request.hours; });
  return *std::ranges::min_element(options.begin(), behind, {}, &PlanOption::relative);
}

base::Status check_known(const PlanRequest& request, const TypePicture& picture) {
  for (const bool gyro : {true, false}) {
    const bool asked = gyro ? request.gyro.has_value() : request.accel.has_value();
    const auto knows = [&](Sensor sensor) { return is_gyro(sensor) == gyro && picture.sensors[index_of(sensor)]; };
    if (asked && std::ranges::none_of(kSensors, knows)) {
      return base::bad_input(
          fmt::format("nothing is known of the {} of this type: neither stored units nor [limits] of "
                      "its file show them",
                      gyro ? "gyros" : "accelerometers"),
          "--accuracy");
    }
  }
  return {};
}

}  // namespace

base::Result<CampaignPlan> plan_campaign(const TypePicture& picture, const calib::UnitType& type,
                                         const PlanRequest& request) {
  if (const auto known = check_known(request, picture); !known) return base::forward_error(known);
  auto full = option_of(full_campaign(picture.low_c, picture.high_c), picture, type);
  if (!full) return base::forward_error(full);
  const Yardsticks yardsticks = yardsticks_of(request, *full);
  full->relative = relative_to(yardsticks, *full);
  std::vector<PlanOption> options;
  for (const PassDesign& design : designs_for(picture.low_c, picture.high_c)) {
    auto option = option_of(design, picture, type);
    if (!option) return base::forward_error(option);
    option->relative = relative_to(yardsticks, *option);
    options.push_back(std::move(*option));
  }
  std::ranges::stable_sort(options, {}, &PlanOption::hours);
  auto chosen = choose(options, request);
  if (!chosen) return base::forward_error(chosen);
  CampaignPlan plan;
  plan.full = std::move(*full);
  plan.options = front_of(options);
  const auto same = std::ranges::find(plan.options, chosen->design, &PlanOption::design);
  const auto place =
      same != plan.options.end()
          ? same
          : plan.options.insert(std::ranges::upper_bound(plan.options, chosen->hours, {}, &PlanOption::hours),
                                std::move(*chosen));
  plan.chosen = static_cast<std::size_t>(place - plan.options.begin());
  return plan;
}

}  // namespace soak::station
