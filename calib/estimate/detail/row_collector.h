// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "calib/estimate/six_position.h"
#include "calib/estimate/unit_rows.h"

namespace soak::calib {

/// Takes the rows of one run after another into the six sensors' tables.
class RowCollector {
 public:
  /// `names`: of the runs, for messages. `rows` outlives the collector.
  RowCollector(UnitRows& rows, std::vector<std::string> names, bool by_plateau)
      : rows_(rows), names_(std::move(names)), by_plateau_(by_plateau) {}

  /// A row for each plateau visit that six-position estimation gives (or estimation in attitudes that nobody knows);
  /// for each block of 30 s where runs have no plateaus. `index`: of the run among the names. Refuses what
  /// estimate_attitudes() and add_gains() refuse, with the run's name.
  [[nodiscard]] base::Status add(const GatedRun& run, int index, const UnitType& type);
  /// After the last run: constants averaged over them, what their estimates warn of (the same words of several runs
  /// once), and tables without the runs that gave no row.
  void finish();

 private:
  base::Status add_plateaus(const GatedRun& run, int index, const UnitType& type);
  void add_blocks(const GatedRun& run, int index, const UnitType& type);
  void add_gravity(const Gravity& gravity);
  [[nodiscard]] const std::string& name(int index) const { return names_[static_cast<std::size_t>(index)]; }
  CurveData& table(std::optional<CurveData>& data);
  int branch_of(std::optional<CurveData>& data, const std::string& branch);
  void number_branches(std::vector<CurveRow>& rows, int index, std::optional<CurveData>& target);
  [[nodiscard]] std::optional<Warning> without_other_parts(const Warning& warning, std::size_t part) const;
  void note_warnings();
  void state_warnings();
  void warn_of_even_order(Sensor sensor) const;

  UnitRows& rows_;
  std::vector<std::string> names_;
  bool by_plateau_;
  double gravity_count_ = 0.0;
  std::map<std::pair<std::string, std::string>, std::size_t> seen_in_;  ///< runs by code and text of their warnings
  std::vector<std::pair<Warning, std::string>> first_seen_;             ///< in order, with the run's name
  std::vector<SixPositionEstimate> estimates_;                          ///< of the runs
  std::vector<std::string> estimated_;                                  ///< names of these
};

}  // namespace soak::calib
