// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/detail/two_axis_fixture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/devices/detail/controller.h"
#include "hal/devices/detail/fixture_status.h"

namespace soak::hal {
namespace {

constexpr double kTurn_deg = 360.0;

/// What the controller reads at one moment.
struct AxesReading {
  bool moving = false;
  AxisAngles angles;
  double rate_dps = 0.0;  ///< of the axis that spins
};

class TwoAxisFixture final : public Fixture {
 public:
  explicit TwoAxisFixture(const RegisterMap& map)
      : controller_(map), status_(map), axes_(*map.axes), labels_(map.positions) {}

  base::Status connect() override { return controller_.connect(); }
  std::vector<std::string> positions() const override { return labels_; }
  std::string description() const override { return controller_.description(); }

  base::Status move_to(std::string_view label) override {
    const auto index = index_of(label);
    if (!index) {
      return base::bad_input(fmt::format("the fixture has no position '{}', only {}", label, fmt::join(labels_, ", ")),
                             description());
    }
    const auto now = read_axes();
    if (!now) return base::forward_error(now);
    if (auto within = check_cables(now->angles); !within) return within;
    if (spinning(*now)) {
      if (auto halted = halt(); !halted) return halted;
      return controller_.fail("the fixture still turns at a rate: it is being halted");
    }
    const AxisAngles& target = axes_.angles_deg[*index];
    return controller_.write("outer_request", target.outer_deg)
        .and_then([&] { return controller_.write("inner_request", target.inner_deg); })
        .and_then([&] { return run_if_there("go"); });
  }

  base::Result<FixtureReading> read() override {
    const auto now = read_axes();
    if (!now) return base::forward_error(now);
    FixtureReading reading;
    reading.angles = angles_text(*now);
    reading.moving = now->moving || spinning(*now);
    if (axes_.spins && !now->moving) reading.rate_dps = spin_sign_ * now->rate_dps;
    if (reading.moving) return reading;
    if (auto within = check_cables(now->angles); !within) return base::forward_error(within);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      if (stands_at(FixtureAxis::outer, now->angles, i) && stands_at(FixtureAxis::inner, now->angles, i)) {
        reading.position = labels_[i];
      }
    }
    return reading;
  }

  base::Status can_spin(std::string_view label, double rate_dps) const override {
    if (!axes_.spins) return Fixture::can_spin(label, rate_dps);
    const auto index = index_of(label);
    if (!index || axes_.spin_sign[*index] == 0) {
      return base::bad_input(fmt::format("the fixture cannot turn about the vertical in {}", label), description());
    }
    const auto limits = controller_.range("rate_request");
    const double axis_dps = axes_.spin_sign[*index] * rate_dps;
    if (axis_dps >= *limits.min && axis_dps <= *limits.max) return {};
    return base::bad_input(
        fmt::format("the fixture does not turn at {:g} °/s in {}: its map allows its axis {:g} to {:g} °/s", rate_dps,
                    label, *limits.min, *limits.max),
        description());
  }

  base::Status spin(std::string_view label, double rate_dps) override {
    if (auto able = can_spin(label, rate_dps); !able) return able;
    const std::size_t index = *index_of(label);
    const auto now = read_axes();
    if (!now) return base::forward_error(now);
    const FixtureAxis still = *axes_.spins == FixtureAxis::outer ? FixtureAxis::inner : FixtureAxis::outer;
    if (!stands_at(still, now->angles, index)) {
      return controller_.fail(
          fmt::format("the fixture cannot turn as in {}: it stands at {}", label, angles_text(*now)));
    }
    spin_sign_ = axes_.spin_sign[index];
    return controller_.write("rate_request", spin_sign_ * rate_dps).and_then([&] { return run_if_there("spin"); });
  }

  base::Status halt() override {
    if (!axes_.spins) return {};
    const auto rates = controller_.read_all({"rate_request", "rate"});
    if (!rates) return base::forward_error(rates);
    const auto rests = [&](const char* name) { return std::abs(rates->at(name)) <= axes_.rate_tolerance_dps; };
    if (rests("rate_request") && rests("rate")) return {};
    return controller_.write("rate_request", 0.0).and_then([&] { return run_if_there("spin"); });
  }

 private:
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view label) const {
    const auto found = std::find(labels_.begin(), labels_.end(), label);
    if (found == labels_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - labels_.begin());
  }

  base::Status run_if_there(const std::string& action) {
    return controller_.has_action(action) ? controller_.run(action) : base::Status{};
  }

  base::Result<AxesReading> read_axes() {
    std::vector<std::string> names = {"status", "outer_position", "inner_position"};
    if (axes_.spins) names.emplace_back("rate");
    const auto values = controller_.read_all(names);
    if (!values) return base::forward_error(values);
    for (const std::string& name : names) {
      if (!std::isfinite(values->at(name))) {
        return controller_.fail(fmt::format("{} ({}) is no number", name, controller_.place(name)));
      }
    }
    const auto moving = status_.moving(controller_, values->at("status"));
    if (!moving) return base::forward_error(moving);
    AxesReading reading{*moving, {values->at("outer_position"), values->at("inner_position")}, 0.0};
    if (axes_.spins) reading.rate_dps = values->at("rate");
    return reading;
  }

  [[nodiscard]] bool spinning(const AxesReading& now) const {
    return std::abs(now.rate_dps) > axes_.rate_tolerance_dps;
  }

  /// The axis that spins has no end: its angle counts within the turn.
  [[nodiscard]] bool stands_at(FixtureAxis axis, const AxisAngles& angles, std::size_t position) const {
    const AxisAngles& wanted = axes_.angles_deg[position];
    const double off_deg =
        axis == FixtureAxis::outer ? angles.outer_deg - wanted.outer_deg : angles.inner_deg - wanted.inner_deg;
    return std::abs(axes_.spins == axis ? std::remainder(off_deg, kTurn_deg) : off_deg) <= axes_.tolerance_deg;
  }

  /// An axis that stands where no request may send it has been wound up by somebody, or has lost its reference: the
  /// way back to the requested angle may be the wrong way round.
  [[nodiscard]] base::Status check_cables(const AxisAngles& angles) const {
    const auto check = [&](FixtureAxis axis, const std::string& name, double angle_deg) -> base::Status {
      const auto limits = controller_.range(name + "_request");
      const double slack_deg = axes_.tolerance_deg;
      if (axes_.spins == axis || (angle_deg >= *limits.min - slack_deg && angle_deg <= *limits.max + slack_deg)) {
        return {};
      }
      return controller_.fail(
          fmt::format("the {} axis stands at {:.2f}°, beyond the {:g} to {:g}° that its cables bear: "
                      "bring it back by hand",
                      name, angle_deg, *limits.min, *limits.max));
    };
    return check(FixtureAxis::outer, "outer", angles.outer_deg).and_then([&] {
      return check(FixtureAxis::inner, "inner", angles.inner_deg);
    });
  }

  [[nodiscard]] std::string angles_text(const AxesReading& now) const {
    std::string text = fmt::format("outer {:.2f}°, inner {:.2f}°", now.angles.outer_deg, now.angles.inner_deg);
    if (axes_.spins) text += fmt::format(", {:.2f} °/s", now.rate_dps);
    return text;
  }

  Controller controller_;
  FixtureStatus status_;
  FixtureAxes axes_;
  std::vector<std::string> labels_;
  int spin_sign_ = 1;  ///< of the position that was last asked to spin
};

}  // namespace

std::unique_ptr<Fixture> make_two_axis_fixture(const RegisterMap& map) { return std::make_unique<TwoAxisFixture>(map); }

}  // namespace soak::hal
