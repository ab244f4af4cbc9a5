// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/report/remainder_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace soak::calib::gap {
namespace {

/// Rows and columns, and which of them each observation belongs to.
struct Layout {
  RemainderMap map;
  std::vector<std::size_t> row;
  std::vector<std::size_t> column;
};

Layout layout_of(const Observations& observations) {
  Layout layout;
  std::map<std::pair<int, Sweep>, std::size_t> rows;
  std::map<int, std::size_t> columns;
  for (std::size_t p = 0; p < observations.positions.size(); ++p) {
    columns[static_cast<int>(p)] = p;
    layout.map.positions.push_back(observations.positions[p].label);
  }
  for (const Observation& observation : observations.rows) {
    const auto [row, is_new] = rows.try_emplace({observation.level, observation.sweep}, layout.map.rows.size());
    if (is_new) {
      const double temp_c = observations.level_c[static_cast<std::size_t>(observation.level)];
      layout.map.rows.push_back({temp_c, observation.sweep});
    }
    const auto [column, is_unknown] = columns.try_emplace(observation.position, layout.map.positions.size());
    if (is_unknown) layout.map.positions.emplace_back();
    layout.row.push_back(row->second);
    layout.column.push_back(column->second);
  }
  return layout;
}

struct Mean {
  double count = 0.0;
  double value = 0.0;
  double squares = 0.0;  ///< of what lies off the mean

  void add(double next) {
    count += 1.0;
    const double off = next - value;
    value += off / count;
    squares += off * (next - value);
  }
};

/// Means over runs of the means of each run, cell by cell.
std::vector<std::vector<Mean>> cells_of(const Observations& observations, const Layout& layout,
                                        const Eigen::VectorXd& remainder) {
  std::map<std::array<std::size_t, 3>, Mean> of_run;  // by row, column, run
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = remainder(static_cast<Eigen::Index>(i));
    if (!std::isfinite(value)) continue;
    of_run[{layout.row[i], layout.column[i], static_cast<std::size_t>(observations.rows[i].run)}].add(value);
  }
  std::vector<std::vector<Mean>> cells(layout.map.rows.size(), std::vector<Mean>(layout.map.positions.size()));
  for (const auto& [place, mean] : of_run) cells[place[0]][place[1]].add(mean.value);
  return cells;
}

MapCells values_of(const std::vector<std::vector<Mean>>& cells) {
  MapCells values;
  for (const auto& row : cells) {
    auto& line = values.emplace_back();
    for (const Mean& cell : row) line.push_back(cell.count > 0.0 ? std::optional(cell.value) : std::nullopt);
  }
  return values;
}

/// Runs that repeat a cell say how far a mean may be off by chance.
MapCells sigma_of(const std::vector<std::vector<Mean>>& cells) {
  double squares = 0.0;
  double freedom = 0.0;
  for (const auto& row : cells) {
    for (const Mean& cell : row) {
      squares += cell.squares;
      freedom += std::max(0.0, cell.count - 1.0);
    }
  }
  MapCells sigma;
  if (freedom == 0.0) return sigma;
  for (const auto& row : cells) {
    auto& line = sigma.emplace_back();
    for (const Mean& cell : row) {
      line.push_back(cell.count > 0.0 ? std::optional(std::sqrt(squares / freedom / cell.count)) : std::nullopt);
    }
  }
  return sigma;
}

/// null of an empty one.
nlohmann::json cells_json(const MapCells& cells, double factor) {
  if (cells.empty()) return {};
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : cells) {
    nlohmann::json line = nlohmann::json::array();
    for (const auto& cell : row) line.push_back(cell ? nlohmann::json(*cell * factor) : nlohmann::json());
    rows.push_back(std::move(line));
  }
  return rows;
}

}  // namespace

RemainderMap remainder_map(const CampaignModel& plain, const std::vector<NamedEffect>& effects) {
  const Observations& observations = plain.regressor_inputs().observations;
  CampaignModel with = plain;
  bool has_effects = false;
  for (const NamedEffect& named : effects) {
    if (!named.effect->candidates) continue;  // nothing that a mean shows
    with.add_term(named.candidate, named.sensors, named.parameters[index_of(named.sensors.front())]);
    has_effects = true;
  }
  Layout layout = layout_of(observations);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    if (!plain.residuals().sensor[s] || !with.residuals().sensor[s]) continue;
    const auto after = cells_of(observations, layout, with.remainder(sensor));
    layout.map.sensor[s] = {
        .sigma = sigma_of(after),
        .before = values_of(cells_of(observations, layout, plain.remainder(sensor))),
        .after = has_effects ? values_of(after) : MapCells(),
    };
  }
  return std::move(layout.map);
}

nlohmann::json map_json(const RemainderMap& map) {
  nlohmann::json rows = nlohmann::json::array();
  for (const MapRow& row : map.rows) rows.push_back({{"temp_c", row.temp_c}, {"sweep", name_of(row.sweep)}});
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const auto& part = map.sensor[index_of(sensor)];
    if (!part) continue;
    const double factor = printed_per_si(sensor);
    sensors[std::string(name_of(sensor))] = {{"unit", printed_unit(sensor)},
                                             {"sigma", cells_json(part->sigma, factor)},
                                             {"before", cells_json(part->before, factor)},
                                             {"after", cells_json(part->after, factor)}};
  }
  return {{"plateaus", std::move(rows)}, {"positions", map.positions}, {"sensors", std::move(sensors)}};
}

}  // namespace soak::calib::gap
