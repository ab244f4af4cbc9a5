// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/axis_tests.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "calib/gap/base/base_curve.h"
#include "calib/gap/effects/columns.h"

namespace soak::calib::gap {
namespace {

constexpr int kKnots = 6;  ///< of what is smooth in the time within a run

/// Indicator columns of all groups but the first; a group number below 0 belongs to none.
Eigen::MatrixXd indicators(const std::vector<int>& group) {
  std::map<int, Eigen::Index> column;
  for (const int g : group) {
    if (g >= 0) column.try_emplace(g, 0);
  }
  Eigen::Index next = -1;
  for (auto& [g, index] : column) index = next++;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(group.size()), std::max<Eigen::Index>(0, next));
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] < 0) continue;
    const Eigen::Index index = column.at(group[i]);
    if (index >= 0) columns(static_cast<Eigen::Index>(i), index) = 1.0;
  }
  return columns;
}

template <class Group>
Eigen::MatrixXd by(const Observations& observations, Group group) {
  std::vector<int> groups;
  for (const Observation& row : observations.rows) groups.push_back(group(row));
  return indicators(groups);
}

double direction(const Observation& row) { return row.sweep == Sweep::down ? -1.0 : 1.0; }

/// Half the difference between heating and cooling in each group that knows both: no group's mean, which the base has.
template <class Group>
Eigen::MatrixXd directions_by(const Observations& observations, Group group) {
  std::map<int, std::array<bool, 2>> seen;
  for (const Observation& row : observations.rows) seen[group(row)].at(row.sweep == Sweep::down ? 1 : 0) = true;
  std::map<int, Eigen::Index> column;
  for (const auto& [g, ways] : seen) {
    if (ways[0] && ways[1]) column.try_emplace(g, static_cast<Eigen::Index>(column.size()));
  }
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations.rows.size()),
                                                  static_cast<Eigen::Index>(column.size()));
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    const auto found = column.find(group(row));
    if (found != column.end()) columns(i, found->second) = direction(row);
  }
  return columns;
}

/// A smooth function of the time since each run's first row, the same in all runs.
Eigen::MatrixXd of_time_in_run(const Observations& observations) {
  std::map<int, double> start_s;
  for (const Observation& row : observations.rows) start_s.try_emplace(row.run, row.t_s);
  double longest_s = 1.0;
  for (const Observation& row : observations.rows) longest_s = std::max(longest_s, row.t_s - start_s.at(row.run));
  std::vector<double> knots;
  for (int k = 0; k < kKnots; ++k) knots.push_back(longest_s * k / (kKnots - 1));
  const LevelSpline spline(knots);
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(observations.rows.size()), kKnots - 1);
  for (Eigen::Index i = 0; i < columns.rows(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(i)];
    columns.row(i) = spline.weights(row.t_s - start_s.at(row.run)).tail(kKnots - 1);
  }
  return columns;
}

/// Tests the axes that a campaign can show.
class AxisTests {
 public:
  AxisTests(const CampaignModel& model, double typical, double price)
      : model_(model), typical_(typical), price_(price) {
    const RegressorInputs in = model.regressor_inputs();
    const Observations& o = in.observations;
    if (!in.history.blurred()) {
      add(Kind::direction_of_sweep, "temperature and direction of the sweep",
          directions_by(o, [](const Observation& row) { return row.level; }), true);
    }
    if (!in.history.coarse()) {
      add(Kind::settling, "time since the plateau was reached and direction of the sweep",
          directions_by(o, [](const Observation& row) { return row.order; }), true);
      add(Kind::creep_after_turn, "time since the fixture turned",
          by(o, [](const Observation& row) { return static_cast<int>(row.t_in_placement_s / 60.0); }));
      add(Kind::position_order, "order of the positions in a visit",
          by(o, [](const Observation& row) { return row.order; }));
    }
    if (o.has_positions()) add_positions(o);
    if (in.history.coarse()) return;
    add_times(in);
    if (!in.history.chamber_c().empty()) {
      Eigen::VectorXd across = as_vector(in.history.chamber_c());
      for (Eigen::Index i = 0; i < across.size(); ++i) across(i) -= o.rows[static_cast<std::size_t>(i)].temp_c;
      add(Kind::air_gradient, "chamber air less unit", across, true);
    }
  }

  [[nodiscard]] std::vector<AxisTest> take() { return std::move(tests_); }

 private:
  using Kind = StructureKind;

  void add(Kind kind, std::string name, const Eigen::MatrixXd& columns, bool of_history = false) {
    if (columns.cols() == 0) return;
    const Candidate candidate = for_all("", {}, columns);
    AxisTest test{kind, std::move(name), test_candidate(model_.residuals(), candidate), {}, of_history};
    test.standing = standing(test.test, candidate, typical_, price_);
    tests_.push_back(std::move(test));
  }

  void add_positions(const Observations& o) {
    const Eigen::MatrixXd position = by(o, [](const Observation& row) { return row.position; });
    add(Kind::position, "position", position);
    add(Kind::position_before, "position before", by(o, [](const Observation& row) { return row.previous; }));
    Eigen::VectorXd since_min(position.rows());
    for (Eigen::Index i = 0; i < since_min.size(); ++i) {
      since_min(i) = o.rows[static_cast<std::size_t>(i)].t_in_placement_s / 60.0;
    }
    add(Kind::creep_after_turn, "position and time since the fixture turned", since_min.asDiagonal() * position);
    add(Kind::position_and_temperature, "position and temperature", reduced_temperature(o).asDiagonal() * position);
  }

  void add_times(const RegressorInputs& in) {
    add(Kind::drift_in_run, "time within the run", of_time_in_run(in.observations), true);
    add(Kind::daily_wave, "time of day", time_of_day(in));
    if (!in.history.since_power_s().empty()) {
      std::vector<int> octave;
      for (const double t_s : in.history.since_power_s()) {
        octave.push_back(static_cast<int>(std::floor(std::log2(std::max(60.0, t_s)))));
      }
      add(Kind::after_power_on, "time since power-on", indicators(octave));
    }
  }

  const CampaignModel& model_;
  double typical_;
  double price_;
  std::vector<AxisTest> tests_;
};

}  // namespace

std::vector<AxisTest> test_axes(const CampaignModel& model, double typical, double price) {
  return AxisTests(model, typical, price).take();
}

}  // namespace soak::calib::gap
