// SPDX-License-Identifier: Apache-2.0
#include "nav/learned/anfis_pipeline.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

using Eigen::Vector3d;

/// Length of artificial outages, and the forgetting of the consequents as a window [AH05 §7.1.1].
constexpr double kWindow_s = 30.0;
/// Before the first artificial outage the filter finds its biases.
constexpr double kSettling_s = 30.0;
/// As often as fixes usually come.
constexpr double kUpdateEvery_s = 1.0;

/// What is expected of the filter's error from the inputs.
using Expectation = std::function<ExpectedError(const ErrorInputs&)>;

/// Lets a model follow the artificial outages of the drive so far.
base::Result<Expectation> followed(const FilterSetup& setup, const ErrorModel& model) {
  // Rows are fixes: their mean distance says how many of them make the window.
  const auto& fixes = setup.drive.gnss;
  const double rows_per_s = static_cast<double>(fixes.size()) / std::max(1.0, fixes.back().t_s - fixes.front().t_s);
  auto following = FollowingErrorModel::of(model, std::max(2.0, kWindow_s * rows_per_s));
  if (!following) return base::forward_error(following);
  for (const ErrorWindow& window : error_windows(setup, successive_begins(setup, kWindow_s, kSettling_s), kWindow_s)) {
    following->follow(window);
  }
  return Expectation(
      [following = *std::move(following)](const ErrorInputs& inputs) { return following.expected(inputs); });
}

/// The model must outlive what is returned.
base::Result<Expectation> expectation(const FilterSetup& setup, const ErrorModel& model, Learning learning) {
  if (learning == Learning::on_line) return followed(setup, model);
  return Expectation([&model](const ErrorInputs& inputs) { return expected_error(model, inputs); });
}

/// A filter without fixes on its way through the outage, and what it is expected to be wrong by.
class Alone {
 public:
  Alone(const FilterSetup& setup, const Expectation& expected)
      : setup_(setup), expected_(expected), run_(setup.drive, setup.start, setup.options) {}

  ExpectedError advance_to(double t_s) {
    run_.advance_to(t_s);
    return expected_(error_inputs(setup_.drive, run_.filter(), t_s, t_s - setup_.drive.gnss.back().t_s));
  }
  [[nodiscard]] Geodetic antenna() const { return run_.filter().antenna(); }
  [[nodiscard]] Vector3d velocity_mps() const { return run_.filter().antenna_velocity_mps(); }

 private:
  const FilterSetup& setup_;
  const Expectation& expected_;
  FilterRun run_;
};

std::vector<Solution> corrected_positions(const FilterSetup& setup, const Expectation& expected,
                                          std::span<const double> t_s) {
  Alone alone(setup, expected);
  std::vector<Solution> solutions;
  for (const double wanted_s : t_s) {
    const ErrorOutputs error = alone.advance_to(wanted_s).error;
    solutions.push_back({moved(alone.antenna(), -error.head<3>()), alone.velocity_mps()});
  }
  return solutions;
}

/// Where the filter without fixes is, less its expected error, as a fix.
GnssFix simulated_fix(const Alone& alone, const ExpectedError& expected, double t_s) {
  return {t_s, moved(alone.antenna(), -expected.error.head<3>()), expected.sigma.head<3>(),
          alone.velocity_mps() - expected.error.tail<3>(), expected.sigma.tail<3>()};
}

/// What the fixes changed, as far as the expected errors are believed: a fix of the height tilts the filter too, and
/// what that does to east and north nobody has judged.
Solution as_believed(const Alone& alone, const NavigationFilter& helped, const ExpectedError& expected) {
  ErrorOutputs change;
  change << offset_m(alone.antenna(), helped.antenna()), helped.antenna_velocity_mps() - alone.velocity_mps();
  for (Eigen::Index k = 0; k < change.size(); ++k) {
    if (expected.sigma(k) == kUnknownError) change(k) = 0.0;
  }
  return {moved(alone.antenna(), change.head<3>()), alone.velocity_mps() + change.tail<3>()};
}

std::vector<Solution> updated_solutions(const FilterSetup& setup, const Expectation& expected,
                                        std::span<const double> t_s) {
  Alone alone(setup, expected);
  FilterRun helped(setup.drive, setup.start, setup.options);
  double next_s = setup.drive.gnss.back().t_s + kUpdateEvery_s;
  std::vector<Solution> solutions;
  for (const double wanted_s : t_s) {
    for (; next_s <= wanted_s; next_s += kUpdateEvery_s) {
      helped.advance_to(next_s);
      helped.filter().update_computed(simulated_fix(alone, alone.advance_to(next_s), next_s));
    }
    helped.advance_to(wanted_s);
    const ExpectedError expected_now = alone.advance_to(wanted_s);
    solutions.push_back(as_believed(alone, helped.filter(), expected_now));
  }
  return solutions;
}

using Solver = std::vector<Solution> (*)(const FilterSetup&, const Expectation&, std::span<const double>);

Pipeline anfis_pipeline(std::string name, std::string description, FilterPipeline filter, ErrorModel model,
                        Learning learning, Solver solver) {
  return {std::move(name), std::move(description),
          [filter = std::move(filter), model = std::move(model), learning, solver](
              const Drive& seen, std::span<const double> t_s) -> base::Result<std::vector<Solution>> {
            const auto setup = set_up(filter, seen);
            if (!setup) return base::forward_error(setup);
            const auto expected = expectation(*setup, model, learning);
            if (!expected) return base::forward_error(expected);
            return solver(*setup, *expected, t_s);
          }};
}

}  // namespace

Pipeline anfis_position(FilterPipeline filter, ErrorModel model, Learning learning) {
  return anfis_pipeline("anfis_position",
                        "the filter's positions, corrected by the error that an ANFIS expects [AH05 §7.1]; beyond 30 s "
                        "it expects what it does at 30 s",
                        std::move(filter), std::move(model), learning, corrected_positions);
}

Pipeline anfis_updates(FilterPipeline filter, ErrorModel model, Learning learning) {
  return anfis_pipeline("anfis_updates",
                        "the filter with simulated fixes: the idea of [AH05 §7.2] with the errors of §7.1; beyond "
                        "30 s it expects what it does at 30 s",
                        std::move(filter), std::move(model), learning, updated_solutions);
}

}  // namespace soak::nav
