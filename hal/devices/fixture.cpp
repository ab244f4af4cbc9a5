// SPDX-License-Identifier: Apache-2.0
#include "hal/devices/fixture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "hal/devices/detail/controller.h"

namespace soak::hal {
namespace {

/// What the quantity `status` of a fixture's map means.
class FixtureStatus {
 public:
  explicit FixtureStatus(const DeviceMap& map) {
    const auto& codes = map.quantities.at("status").codes;
    moving_ = codes.at("moving");
    standing_ = codes.at("standing");
    fault_ = codes.at("fault");
  }

  /// Whether it moves; a fault and a code that the map does not know are errors (device) of `controller`.
  [[nodiscard]] base::Result<bool> moving(const Controller& controller, double status) const {
    const auto code = static_cast<int>(status);
    if (code == fault_) return controller.fail("the fixture reports a fault");
    if (code == moving_ || code == standing_) return code == moving_;
    return controller.fail(fmt::format("status ({}) is {}: the map knows standing = {}, moving = {}, fault = {}",
                                       controller.place("status"), code, standing_, moving_, fault_));
  }

 private:
  int moving_ = 0;
  int standing_ = 0;
  int fault_ = 0;
};

std::optional<std::size_t> index_of_label(const std::vector<std::string>& labels, std::string_view label) {
  const auto found = std::find(labels.begin(), labels.end(), label);
  if (found == labels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - labels.begin());
}

base::Status no_position(std::string_view label, const std::vector<std::string>& labels, const Controller& controller) {
  return base::bad_input(fmt::format("the fixture has no position '{}', only {}", label, fmt::join(labels, ", ")),
                         controller.description());
}

// --- fixtures that are told the number of a position

class PositionFixture final : public Fixture {
 public:
  explicit PositionFixture(const DeviceMap& map) : controller_(map), status_(map), labels_(map.positions) {}

  base::Status connect() override { return controller_.connect(); }
  std::vector<std::string> positions() const override { return labels_; }

  base::Status move_to(std::string_view label) override {
    const auto index = index_of_label(labels_, label);
    if (!index) return no_position(label, labels_, controller_);
    return controller_.write("request", static_cast<double>(*index + 1));
  }

  base::Result<FixtureReading> read() override {
    const auto values = controller_.read_all({"status", "position"});
    if (!values) return base::forward_error(values);
    const auto moving = status_.moving(controller_, values->at("status"));
    if (!moving) return base::forward_error(moving);
    if (!*moving) return standing_at(static_cast<int>(values->at("position")));
    FixtureReading reading;
    reading.moving = true;
    return reading;
  }

  std::string description() const override { return controller_.description(); }

 private:
  /// Position code 0 is between the positions.
  base::Result<FixtureReading> standing_at(int code) const {
    if (code == 0) return FixtureReading{};
    if (code < 0 || static_cast<std::size_t>(code) > labels_.size()) {
      return controller_.fail(fmt::format("position ({}) is {}: the map names {} positions, and 0 means between them",
                                          controller_.place("position"), code, labels_.size()));
    }
    FixtureReading reading;
    reading.position = labels_[static_cast<std::size_t>(code) - 1];
    return reading;
  }

  Controller controller_;
  FixtureStatus status_;
  std::vector<std::string> labels_;
};

// --- fixtures that are told the angles of two axes

constexpr double kTurn_deg = 360.0;

/// What the controller reads at one moment.
struct AxesReading {
  bool moving = false;
  AxisAngles angles;
  double rate_dps = 0.0;  ///< of the axis that spins
};

class TwoAxisFixture final : public Fixture {
 public:
  explicit TwoAxisFixture(const DeviceMap& map)
      : controller_(map), status_(map), axes_(*map.axes), labels_(map.positions) {}

  base::Status connect() override { return controller_.connect(); }
  std::vector<std::string> positions() const override { return labels_; }
  std::string description() const override { return controller_.description(); }

  base::Status move_to(std::string_view label) override {
    const auto index = index_of_label(labels_, label);
    if (!index) return no_position(label, labels_, controller_);
    const auto now = read_axes();
    if (!now) return base::forward_error(now);
    if (auto within = check_cables(now->angles); !within) return within;
    if (spinning(*now)) {
      if (auto halted = halt(); !halted) return halted;
      return controller_.fail("the fixture is still rotating: it is being stopped");
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
    const auto index = index_of_label(labels_, label);
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
    const std::size_t index = *index_of_label(labels_, label);
    const auto now = read_axes();
    if (!now) return base::forward_error(now);
    const FixtureAxis still = *axes_.spins == FixtureAxis::outer ? FixtureAxis::inner : FixtureAxis::outer;
    if (!stands_at(still, now->angles, index)) {
      return controller_.fail(fmt::format("the fixture cannot rotate as in {}: it is at {}", label, angles_text(*now)));
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
        return controller_.fail(fmt::format("{} ({}) is not a number", name, controller_.place(name)));
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
      return controller_.fail(fmt::format(
          "the {} axis is at {:.2f}°, outside the {:g} to {:g}° that its cables allow: turn it back by hand", name,
          angle_deg, *limits.min, *limits.max));
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

base::Status Fixture::can_spin(std::string_view /*label*/, double /*rate_dps*/) const {
  return base::bad_input("the fixture cannot turn at a rate", description());
}

base::Result<std::unique_ptr<Fixture>> make_fixture(const DeviceMap& map) {
  if (auto able = require_device(map, "fixture"); !able) return base::forward_error(able);
  if (map.axes) return std::make_unique<TwoAxisFixture>(map);
  return std::make_unique<PositionFixture>(map);
}

}  // namespace soak::hal
