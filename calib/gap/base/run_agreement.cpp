// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/base/run_agreement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "calib/gap/noise/noise.h"
#include "calib/gap/observations/observations.h"
#include "calib/gap/report/cross_validation.h"

namespace soak::calib::gap {
namespace {

/// Plateaus visited twice from which their differences say how visits scatter; below it, blocks stand in: visits of
/// real units scatter more than those do.
constexpr double kEnough = 4.0;
constexpr double kVisitsToBlocks = 4.0;

/// Values by group.
using Groups = std::map<int, std::vector<double>>;

double mean_value(const std::vector<double>& values) {
  Mean mean;
  for (const double value : values) mean.add(value);
  return mean.value;
}

/// Readings of one sensor by run and cell (what replicate runs repeat), less what the runs have in common.
class CellMeans {
 public:
  /// `values`: one per observation; NaN = no reading.
  CellMeans(const Observations& observations, const Eigen::VectorXd& values);

  /// How far the curves over temperature of two runs are apart in shape: RMS over the plateaus of their difference. Of
  /// a plateau it is the median over visits and positions, each position freed of its own median before: neither an
  /// offset nor a tilt of the fixture counts, nor a visit that was labelled wrongly. Nothing where they share less than
  /// two plateaus.
  [[nodiscard]] std::optional<double> distance(int run, int other) const;

  /// How readings scatter within runs, as it would show in distance(): from what visits of one run to the same plateau
  /// differ by (effects of the past too), all runs together, and a block's repeatability in its placement. With less
  /// than four plateaus that a run visited twice, four times that repeatability at least.
  [[nodiscard]] double scatter() const;

 private:
  struct Cell {
    int level = 0;
    int position = -1;
  };

  std::vector<Cell> cells_;
  std::vector<std::vector<double>> means_;  ///< of run and cell, NaN where there is none
  int levels_ = 0;
  double block_variance_ = 0.0;
};

CellMeans::CellMeans(const Observations& observations, const Eigen::VectorXd& values)
    : levels_(observations.level_count()) {
  std::vector<std::map<int, Mean>> means(observations.runs.size());
  std::map<int, std::vector<double>> placements;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const Observation& row = observations.rows[i];
    const double value = values(static_cast<Eigen::Index>(i));
    const auto cell = static_cast<std::size_t>(row.cell);
    if (cell >= cells_.size()) cells_.resize(cell + 1);
    cells_[cell] = {row.level, row.position};
    if (!std::isfinite(value)) continue;
    means[static_cast<std::size_t>(row.run)][row.cell].add(value);
    placements[row.placement].push_back(value);
  }
  for (const auto& of_run : means) {
    std::vector<double>& row = means_.emplace_back(cells_.size(), std::numeric_limits<double>::quiet_NaN());
    for (const auto& [cell, mean] : of_run) row[static_cast<std::size_t>(cell)] = mean.value;
  }
  double squares = 0.0;
  double dof = 0.0;
  for (const auto& [id, blocks] : placements) {
    const double mean = mean_value(blocks);
    for (const double value : blocks) squares += (value - mean) * (value - mean);
    dof += static_cast<double>(blocks.size()) - 1.0;
  }
  if (dof > 0.0) block_variance_ = squares / dof;
}

std::optional<double> CellMeans::distance(int run, int other) const {
  const std::vector<double>& a = means_[static_cast<std::size_t>(run)];
  const std::vector<double>& b = means_[static_cast<std::size_t>(other)];
  Groups by_position;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const double difference = a[c] - b[c];
    if (std::isfinite(difference)) by_position[cells_[c].position].push_back(difference);
  }
  std::map<int, double> middle;
  for (const auto& [position, differences] : by_position) middle[position] = base::median(differences);
  Groups by_level;
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const double difference = a[c] - b[c];
    if (std::isfinite(difference)) by_level[cells_[c].level].push_back(difference - middle.at(cells_[c].position));
  }
  if (by_level.size() < 2) return std::nullopt;
  std::vector<double> shape;
  for (const auto& [level, differences] : by_level) shape.push_back(base::median(differences));
  const double mean = mean_value(shape);
  double squares = 0.0;
  for (const double value : shape) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(shape.size()));
}

double CellMeans::scatter() const {
  Mean squares;
  for (const std::vector<double>& run : means_) {
    // Of each plateau, what each position read visit after visit.
    std::vector<std::map<int, std::vector<double>>> levels(static_cast<std::size_t>(levels_));
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      if (!std::isfinite(run[c])) continue;
      levels[static_cast<std::size_t>(cells_[c].level)][cells_[c].position].push_back(run[c]);
    }
    for (const auto& positions : levels) {
      std::vector<double> differences;
      for (const auto& [position, visits] : positions) {
        if (visits.size() > 1) differences.push_back(visits.back() - visits.front());
      }
      if (!differences.empty()) squares.add(0.5 * std::pow(base::median(differences), 2));
    }
  }
  const double told = std::sqrt(squares.value + block_variance_);
  return squares.count < kEnough ? std::max(told, kVisitsToBlocks * std::sqrt(block_variance_)) : told;
}

constexpr double kOtherThermometer_k = 10.0;
constexpr double kApart = 5.0;  ///< times the scatter within runs
constexpr std::size_t kLeastSensors = 2;
constexpr double kOdd = 16.0;  ///< times the median mean square

using Apart = std::function<bool(int run, int other)>;

/// Runs that are not apart, directly or by way of others; the largest group first, of groups alike that of the earliest
/// run.
std::vector<std::vector<int>> groups_of(int runs, const Apart& apart) {
  std::vector<int> group(static_cast<std::size_t>(runs));
  for (int run = 0; run < runs; ++run) group[static_cast<std::size_t>(run)] = run;
  for (int run = 0; run < runs; ++run) {
    for (int other = 0; other < run; ++other) {
      const int joined = group[static_cast<std::size_t>(run)];
      const int into = group[static_cast<std::size_t>(other)];
      if (joined != into && !apart(run, other)) std::replace(group.begin(), group.end(), joined, into);
    }
  }
  std::map<int, std::vector<int>> members;
  for (int run = 0; run < runs; ++run) members[group[static_cast<std::size_t>(run)]].push_back(run);
  std::vector<std::vector<int>> groups;
  for (auto& [id, list] : members) groups.push_back(std::move(list));
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return groups;
}

std::string labels_of(const Observations& observations, const std::vector<int>& runs) {
  std::vector<std::string_view> labels;
  for (const int run : runs) labels.push_back(observations.runs[static_cast<std::size_t>(run)]);
  return fmt::format("{} {}", labels.size() == 1 ? "run" : "runs", fmt::join(labels, ", "));
}

/// Who differs from whom: those outside the group that holds more than half of the runs, or all groups.
std::string who_differs(const Observations& observations, const std::vector<std::vector<int>>& groups) {
  if (2 * groups.front().size() > observations.runs.size()) {
    std::vector<int> others;
    for (auto group = groups.begin() + 1; group != groups.end(); ++group) {
      others.insert(others.end(), group->begin(), group->end());
    }
    std::sort(others.begin(), others.end());
    return fmt::format("{} {} from the others", labels_of(observations, others),
                       others.size() == 1 ? "differs" : "differ");
  }
  std::string text;
  for (const auto& group : groups) text += (text.empty() ? "" : " and ") + labels_of(observations, group);
  return text + " differ";
}

/// Mean temperature of a run at each plateau.
std::vector<std::map<int, Mean>> temperatures(const Observations& observations) {
  std::vector<std::map<int, Mean>> means(observations.runs.size());
  for (const Observation& row : observations.rows) {
    if (std::isfinite(row.temp_c)) means[static_cast<std::size_t>(row.run)][row.level].add(row.temp_c);
  }
  return means;
}

/// RMS over the plateaus that both have; 0 where they have none.
double difference_k(const std::map<int, Mean>& a, const std::map<int, Mean>& b) {
  Mean squares;
  for (const auto& [level, mean] : a) {
    const auto other = b.find(level);
    if (other != b.end()) squares.add(std::pow(mean.value - other->second.value, 2));
  }
  return std::sqrt(squares.value);
}

/// How far runs are apart in one sensor, over their scatter within.
class SensorDistances {
 public:
  SensorDistances(const CampaignModel& model, Sensor sensor)
      : sensor_(sensor),
        means_(model.regressor_inputs().observations, model.remainder(sensor)),
        scatter_(means_.scatter()) {}

  [[nodiscard]] Sensor sensor() const { return sensor_; }
  [[nodiscard]] double between(int run, int other) const {
    return scatter_ > 0.0 ? means_.distance(run, other).value_or(0.0) / scatter_ : 0.0;
  }

 private:
  Sensor sensor_;
  CellMeans means_;
  double scatter_;
};

std::optional<std::string> other_thermometer(const Observations& observations) {
  const auto means = temperatures(observations);
  const auto groups = groups_of(observations.run_count(), [&](int run, int other) {
    return difference_k(means[static_cast<std::size_t>(run)], means[static_cast<std::size_t>(other)]) >
           kOtherThermometer_k;
  });
  if (groups.size() < 2) return std::nullopt;
  return fmt::format(
      "{} in what the thermometer reads at the same set points, by more than {:.0f} K: is it in degC, and not stuck? "
      "Void what is wrong, and import or record it again",
      who_differs(observations, groups), kOtherThermometer_k);
}

std::optional<std::string> other_unit(const CampaignModel& model) {
  const Observations& observations = model.regressor_inputs().observations;
  std::vector<SensorDistances> sensors;
  for (const Sensor sensor : kSensors) {
    if (model.residuals().sensor[index_of(sensor)]) sensors.emplace_back(model, sensor);
  }
  const std::size_t wanted = std::min(kLeastSensors, std::max<std::size_t>(1, sensors.size()));
  std::set<Sensor> differing;
  const auto groups = groups_of(observations.run_count(), [&](int run, int other) {
    std::vector<Sensor> apart;
    for (const SensorDistances& distances : sensors) {
      if (distances.between(run, other) > kApart) apart.push_back(distances.sensor());
    }
    if (apart.size() < wanted) return false;
    differing.insert(apart.begin(), apart.end());
    return true;
  });
  if (groups.size() < 2) return std::nullopt;
  std::vector<std::string_view> names;
  for (const Sensor sensor : differing) names.push_back(name_of(sensor));
  return fmt::format(
      "{} in the shape of the curves over temperature ({}), as if from two units: one run may be from another unit, or "
      "have swapped axes, wrong signs or another unit of measurement. Void what is wrong, and record it again",
      who_differs(observations, groups), fmt::join(names, ", "));
}

/// A run that is off by more than four times the RMS of the others in most sensors.
std::optional<std::string> odd_run(const CampaignModel& model) {
  const Observations& observations = model.regressor_inputs().observations;
  if (observations.run_count() < 3) return std::nullopt;
  std::vector<int> votes(observations.runs.size(), 0);
  int sensors = 0;
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    ++sensors;
    std::vector<double> squares;
    for (int run = 0; run < observations.run_count(); ++run) {
      squares.push_back(mean_square(observations, model.remainder(sensor), run).value_or(0.0));
    }
    const auto largest = std::max_element(squares.begin(), squares.end());
    if (*largest > kOdd * base::median(squares)) ++votes[static_cast<std::size_t>(largest - squares.begin())];
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  if (2 * *most <= sensors) return std::nullopt;
  return fmt::format(
      "run {} differs from the others in most sensors: is it from this unit, mounted and labelled like the others? "
      "Void it, or record it again",
      observations.runs[static_cast<std::size_t>(most - votes.begin())]);
}

}  // namespace

std::optional<std::string> same_readings(const Observations& observations) {
  std::map<std::vector<double>, int> seen;
  for (int run = 0; run < observations.run_count(); ++run) {
    std::vector<double> means;
    for (const Observation& row : observations.rows) {
      if (row.run != run) continue;
      for (const SensorStatistics& statistics : row.sensor)
        means.push_back(statistics.count > 0 ? statistics.mean : 0.0);
    }
    const auto [other, fresh] = seen.try_emplace(std::move(means), run);
    if (!fresh) {
      return fmt::format("runs {} and {} hold the same readings: void one of them",
                         observations.runs[static_cast<std::size_t>(other->second)],
                         observations.runs[static_cast<std::size_t>(run)]);
    }
  }
  return std::nullopt;
}

std::optional<std::string> disagreement(const CampaignModel& model) {
  if (auto thermometer = other_thermometer(model.regressor_inputs().observations)) return thermometer;
  if (auto unit = other_unit(model)) return unit;
  return odd_run(model);
}

}  // namespace soak::calib::gap
