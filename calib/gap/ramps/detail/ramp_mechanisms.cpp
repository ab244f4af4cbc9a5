// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/ramp_mechanisms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "calib/gap/effects/columns.h"

namespace soak::calib::gap::reduced {
namespace {

constexpr std::array kTaus_s = {30.0, 60.0, 120.0, 240.0, 480.0, 960.0};
constexpr std::array kLeads_s = {30.0, 60.0, 120.0, 240.0};
constexpr std::array kWidths_c = {2.0, 6.0, 15.0, 35.0, 70.0};
constexpr std::array kWarmUps_s = {200.0, 400.0, 800.0, 1600.0, 3200.0};
constexpr double kPerMinute = 60.0;
constexpr double kHour_s = 3600.0;

const Effect* effect_named(std::string_view name) {
  const auto found =
      std::find_if(library().begin(), library().end(), [&](const Effect& effect) { return effect.name == name; });
  return &*found;
}

const Effect* drift() {
  static const Effect effect = [] {
    Effect made;
    made.name = "aging_drift";
    made.physics = "the bias moves on with time, whatever the temperature does";
    made.experiment = "the same cycle once more: a drift goes on, what follows the temperature comes back";
    return made;
  }();
  return &effect;
}

std::string_view start_text(bool under_way) {
  return under_way ? ", under way at the start" : ", at rest at the start";
}

class Maker {
 public:
  Maker(const RampRecording& recording, const Courses& courses) : courses_(courses) {
    const auto& rows = recording.observations.rows;
    temperature_.resize(static_cast<Eigen::Index>(rows.size()));
    time_h_.resize(temperature_.size());
    for (Eigen::Index i = 0; i < temperature_.size(); ++i) {
      temperature_(i) = rows[static_cast<std::size_t>(i)].temp_c;
      time_h_(i) = rows[static_cast<std::size_t>(i)].t_s / kHour_s;
    }
    time_h_.array() -= time_h_.mean();
    const double low_c = temperature_.minCoeff();
    const double high_c = temperature_.maxCoeff();
    temperature_ = ((temperature_.array() - 0.5 * (low_c + high_c)) / (0.5 * (high_c - low_c))).matrix();
  }

  Mechanism temperature_rate() {
    Mechanism made{.effect = effect_named("temperature_rate"), .per = "/(K/min)"};
    add_both(made, "", {}, rate_kpmin());
    for (const double tau_s : kTaus_s) {
      for (const bool under_way : {false, true}) {
        // −(T_τ − T)/τ tends to dT/dt on a long ramp.
        const Eigen::VectorXd column = -kPerMinute / tau_s * as_vector(courses_.lag(tau_s, under_way));
        add_both(made, fmt::format("tau {:g} s{}", tau_s, start_text(under_way)), {tau_s}, column);
      }
    }
    return made;
  }

  Mechanism sensor_lag() {
    Mechanism made{.effect = effect_named("sensor_lag"), .size = Size::time_constant, .shared = true};
    for (const double tau_s : kTaus_s) {
      for (const bool under_way : {false, true}) {
        made.shapes.push_back({fmt::format("tau {:g} s{}", tau_s, start_text(under_way)),
                               {tau_s},
                               as_vector(courses_.lag(tau_s, under_way)),
                               true});
      }
    }
    for (const double tau_s : kLeads_s) {
      made.shapes.push_back({fmt::format("tau {:g} s", -tau_s), {-tau_s}, tau_s / kPerMinute * rate_kpmin(), true});
    }
    return made;
  }

  Mechanism thermal_hysteresis() {
    Mechanism made{.effect = effect_named("thermal_hysteresis"), .size = Size::largest};
    for (const double width_c : kWidths_c) {
      for (const double along : {1.0, 0.0, -1.0}) {
        const auto text = fmt::format("width {:g} K, before the start {}", width_c,
                                      along > 0.0   ? "as the first branch"
                                      : along < 0.0 ? "against the first branch"
                                                    : "neither way");
        add_both(made, text, {width_c}, as_vector(courses_.branch_memory(width_c, along)));
      }
    }
    return made;
  }

  Mechanism warmup_transient() {
    Mechanism made{.effect = effect_named("warmup_transient")};
    if (courses_.since_power_s().empty()) return made;
    for (const double tau_s : kWarmUps_s) {
      const Eigen::ArrayXd since_s = as_vector(courses_.since_power_s()).array();
      made.shapes.push_back({fmt::format("tau {:g} s", tau_s), {tau_s}, (-since_s / tau_s).exp().matrix()});
    }
    return made;
  }

  Mechanism aging_drift() {
    Mechanism made{.effect = drift(), .per = "/h", .nuisance = true};
    made.shapes.push_back({"", {}, time_h_});
    return made;
  }

  static Mechanism channel(std::string_view name, std::string per, const std::vector<double>& values) {
    Mechanism made{.effect = effect_named(name), .per = std::move(per)};
    if (values.empty()) return made;
    Eigen::VectorXd column = as_vector(values);
    column.array() -= column.mean();
    if (column.squaredNorm() > 0.0) made.shapes.push_back({"", {}, column});
    return made;
  }

 private:
  [[nodiscard]] Eigen::VectorXd rate_kpmin() const { return kPerMinute * as_vector(courses_.rate()); }

  /// The column, and the column with a part that is linear in temperature.
  void add_both(Mechanism& mechanism, const std::string& text, std::vector<double> values,
                const Eigen::VectorXd& column) const {
    mechanism.shapes.push_back({text, values, column});
    Eigen::MatrixXd both(column.size(), 2);
    both << column, column.cwiseProduct(temperature_);
    mechanism.shapes.push_back(
        {text.empty() ? "linear in temperature" : text + ", linear in temperature", std::move(values), both});
  }

  const Courses& courses_;
  Eigen::VectorXd temperature_;  ///< −1 to 1 over the range
  Eigen::VectorXd time_h_;
};

}  // namespace

std::vector<Mechanism> mechanisms(const RampRecording& recording, const Courses& courses) {
  Maker maker(recording, courses);
  std::vector<Mechanism> all = {maker.thermal_hysteresis(),
                                maker.temperature_rate(),
                                maker.sensor_lag(),
                                maker.warmup_transient(),
                                Maker::channel("supply_sensitivity", "/V", courses.supply_v()),
                                Maker::channel("vibration_rectification", "", courses.compressor()),
                                maker.aging_drift()};
  std::erase_if(all, [](const Mechanism& mechanism) { return mechanism.shapes.empty(); });
  return all;
}

}  // namespace soak::calib::gap::reduced
