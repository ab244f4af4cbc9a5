// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "anfis/model/model.h"
#include "anfis/premises/premise_bounds.h"

namespace soak::anfis::training {

/// Where the parameters of one membership may go in PremiseCoordinates.
struct Cell {
  Interval walls;             ///< of its position
  double unit = 1.0;          ///< of the coordinate of a position: half the range of the input
  double gap = 0.0;           ///< least width of an edge
  double least_length = 0.0;  ///< of a width or flank
  double longest = 0.0;       ///< of a width or flank
  Interval slopes{1.0, 1.0};  ///< of a bell
  bool low_is_end = true;     ///< the wall is the end of the input's range, not one towards a neighbour
  bool high_is_end = true;
};

/// Coordinates z in a box, from which the premises of a model follow and are admissible for every z in the box
/// (premises/premise_bounds.h): what an optimiser with bounds may move freely. Per membership:
///   bell                ln width, share of the admissible slopes, position (in half ranges of the input)
///   gaussian            ln width, position
///   two_sided_gaussian  ln left width, left end of the top, ln right width, share of the rest of the cell in the top
///   triangle            ln left flank, position, ln right flank
///   trapezoid           ln left flank, left end of the top, share of the rest of the cell in the top, ln right flank
/// Positions stay inside the membership's cell. Cells of memberships that must stay in order meet half way between
/// their neighbours' centres, the least separation apart; the others' cells are the whole range. When a position has
/// arrived at the wall of its cell, new coordinates around the present model let it go on.
class PremiseCoordinates {
 public:
  /// Around the premises of an admissible model.
  PremiseCoordinates(const Model& model, const PremiseBounds& bounds);

  [[nodiscard]] const std::vector<double>& lowest() const { return lowest_; }
  [[nodiscard]] const std::vector<double>& highest() const { return highest_; }

  /// Coordinates of the model's premises, moved into the box.
  [[nodiscard]] std::vector<double> of(const Model& model) const;

  /// Stores the premises at z in the model.
  void set(std::span<const double> z, Model& model) const;

  /// dE/dz at z from dE/d theta (order of read_premises()) at the premises that set() gives.
  void chain(std::span<const double> z, std::span<const double> by_theta, std::span<double> by_z) const;

  /// Whether some position at z touches a wall towards a neighbour.
  [[nodiscard]] bool touches_neighbour(std::span<const double> z) const;

 private:
  std::vector<Shape> shapes_;  ///< per membership
  std::vector<Cell> cells_;    ///< per membership
  std::vector<double> lowest_;
  std::vector<double> highest_;
};

}  // namespace soak::anfis::training
