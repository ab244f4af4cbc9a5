// SPDX-License-Identifier: Apache-2.0
#include "anfis/premises/premise_coordinates.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "anfis/premises/premise_bounds.h"

namespace soak::anfis::training {
namespace {

using Numbers = std::array<double, 4>;

/// Largest slope of a bell of that width whose edges are no sharper than the gap; see PremiseBounds.
double steepest(double width, const Cell& cell) {
  return std::clamp(width / cell.gap, cell.slopes.low, cell.slopes.high);
}

/// What one coordinate of a shape is.
enum class Kind { log_length, share, position };

std::array<Kind, 4> kinds(Shape shape) {
  using enum Kind;
  switch (shape) {
    case Shape::bell:
      return {log_length, share, position, share};
    case Shape::gaussian:
      return {log_length, position, share, share};
    case Shape::two_sided_gaussian:
    case Shape::triangle:  // whose fourth does not count
      return {log_length, position, log_length, share};
    case Shape::trapezoid:
      return {log_length, position, share, log_length};
  }
  return {};
}

Interval limits(Kind kind, const Cell& cell) {
  switch (kind) {
    case Kind::log_length:
      return {std::log(cell.least_length), std::log(cell.longest)};
    case Kind::share:
      return {0.0, 1.0};
    case Kind::position:
      return {cell.walls.low / cell.unit, cell.walls.high / cell.unit};
  }
  return {0.0, 0.0};
}

double share_of(double part, double whole) { return whole > 0.0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; }

Numbers coordinates_of(const Membership& m, const Cell& cell) {
  const auto& p = m.parameters;
  switch (m.shape) {
    case Shape::bell:
      return {std::log(p[0]), share_of(p[1] - cell.slopes.low, steepest(p[0], cell) - cell.slopes.low),
              p[2] / cell.unit, 0.0};
    case Shape::gaussian:
      return {std::log(p[0]), p[1] / cell.unit, 0.0, 0.0};
    case Shape::two_sided_gaussian:
      return {std::log(p[0]), p[1] / cell.unit, std::log(p[2]), share_of(p[3] - p[1], cell.walls.high - p[1])};
    case Shape::triangle:
      return {std::log(p[1] - p[0]), p[1] / cell.unit, std::log(p[2] - p[1]), 0.0};
    case Shape::trapezoid:
      return {std::log(p[1] - p[0]), p[1] / cell.unit, share_of(p[2] - p[1], cell.walls.high - p[1]),
              std::log(p[3] - p[2])};
  }
  return {};
}

Numbers parameters_at(Shape shape, const Cell& cell, const Numbers& z) {
  const double position = z[shape == Shape::bell ? 2 : 1] * cell.unit;
  switch (shape) {
    case Shape::bell: {
      const double width = std::exp(z[0]);
      return {width, cell.slopes.low + z[1] * (steepest(width, cell) - cell.slopes.low), position, 0.0};
    }
    case Shape::gaussian:
      return {std::exp(z[0]), position, 0.0, 0.0};
    case Shape::two_sided_gaussian:
      return {std::exp(z[0]), position, std::exp(z[2]), position + z[3] * (cell.walls.high - position)};
    case Shape::triangle:
      return {position - std::exp(z[0]), position, position + std::exp(z[2]), 0.0};
    case Shape::trapezoid: {
      const double top_right = position + z[2] * (cell.walls.high - position);
      return {position - std::exp(z[0]), position, top_right, top_right + std::exp(z[3])};
    }
  }
  return {};
}

/// dE/dz of one membership from its dE/d parameters g.
Numbers chained(Shape shape, const Cell& cell, const Numbers& z, const Numbers& g) {
  const double position = z[shape == Shape::bell ? 2 : 1] * cell.unit;
  switch (shape) {
    case Shape::bell: {
      const double width = std::exp(z[0]);
      const double most = steepest(width, cell);
      const double most_by_log_width = most > cell.slopes.low && most < cell.slopes.high ? most : 0.0;
      return {g[0] * width + g[1] * z[1] * most_by_log_width, g[1] * (most - cell.slopes.low), g[2] * cell.unit, 0.0};
    }
    case Shape::gaussian:
      return {g[0] * std::exp(z[0]), g[1] * cell.unit, 0.0, 0.0};
    case Shape::two_sided_gaussian:
      return {g[0] * std::exp(z[0]), (g[1] + g[3] * (1.0 - z[3])) * cell.unit, g[2] * std::exp(z[2]),
              g[3] * (cell.walls.high - position)};
    case Shape::triangle:
      return {-g[0] * std::exp(z[0]), (g[0] + g[1] + g[2]) * cell.unit, g[2] * std::exp(z[2]), 0.0};
    case Shape::trapezoid: {
      const double by_top_right = g[2] + g[3];
      return {-g[0] * std::exp(z[0]), (g[0] + g[1] + by_top_right * (1.0 - z[2])) * cell.unit,
              by_top_right * (cell.walls.high - position), g[3] * std::exp(z[3])};
    }
  }
  return {};
}

double half_way(const Membership& a, const Membership& b) { return 0.5 * centre(a) + 0.5 * centre(b); }

Cell cell_of(const PremiseBounds& bounds, std::size_t input, std::span<const Membership> memberships, std::size_t k) {
  const InputGaps& gaps = bounds.gaps(input);
  Cell cell;
  cell.walls = {gaps.lowest(), gaps.highest()};
  cell.unit = 0.5 * (gaps.highest() - gaps.lowest());
  const double room = 0.5 * bounds.separation(input);
  if (bounds.ordered(input) && k > 0) {
    cell.low_is_end = false;
    cell.walls.low = half_way(memberships[k - 1], memberships[k]) + room;
  }
  if (bounds.ordered(input) && k + 1 < memberships.size()) {
    cell.high_is_end = false;
    cell.walls.high = half_way(memberships[k], memberships[k + 1]) - room;
  }
  cell.walls.high = std::max(cell.walls.low, cell.walls.high);
  cell.slopes = bounds.slopes();
  cell.longest = gaps.longest();
  cell.gap = std::min(gaps.near(cell.walls), gaps.longest());
  const bool is_bell = memberships[k].shape == Shape::bell;
  cell.least_length = std::min(is_bell ? cell.slopes.low * cell.gap : cell.gap, gaps.longest());
  return cell;
}

Numbers numbers(std::span<const double> values) {
  Numbers n{};
  std::ranges::copy(values, n.begin());
  return n;
}

}  // namespace

PremiseCoordinates::PremiseCoordinates(const Model& model, const PremiseBounds& bounds) {
  for (std::size_t j = 0; j < model.inputs.size(); ++j) {
    const std::vector<Membership>& memberships = model.inputs[j].memberships;
    for (std::size_t k = 0; k < memberships.size(); ++k) {
      shapes_.push_back(memberships[k].shape);
      cells_.push_back(cell_of(bounds, j, memberships, k));
      const auto kind = kinds(shapes_.back());
      for (std::size_t q = 0; q < parameter_count(shapes_.back()); ++q) {
        const Interval range = limits(kind[q], cells_.back());
        lowest_.push_back(range.low);
        highest_.push_back(std::max(range.low, range.high));
      }
    }
  }
}

std::vector<double> PremiseCoordinates::of(const Model& model) const {
  std::vector<double> z(lowest_.size());
  std::size_t index = 0;
  for_each_membership(model, [&](const Membership& membership, std::size_t first) {
    const Numbers own = coordinates_of(membership, cells_[index++]);
    for (std::size_t q = 0; q < parameter_count(membership.shape); ++q) {
      z[first + q] = std::clamp(own[q], lowest_[first + q], highest_[first + q]);
    }
  });
  return z;
}

void PremiseCoordinates::set(std::span<const double> z, Model& model) const {
  std::size_t index = 0;
  for_each_membership(model, [&](Membership& membership, std::size_t first) {
    const std::size_t count = parameter_count(membership.shape);
    membership.parameters = parameters_at(membership.shape, cells_[index++], numbers(z.subspan(first, count)));
  });
}

void PremiseCoordinates::chain(std::span<const double> z, std::span<const double> by_theta,
                               std::span<double> by_z) const {
  std::size_t first = 0;
  for (std::size_t index = 0; index < shapes_.size(); ++index) {
    const std::size_t count = parameter_count(shapes_[index]);
    const Numbers own = chained(shapes_[index], cells_[index], numbers(z.subspan(first, count)),
                                numbers(by_theta.subspan(first, count)));
    for (std::size_t q = 0; q < count; ++q) by_z[first + q] = own[q];
    first += count;
  }
}

bool PremiseCoordinates::touches_neighbour(std::span<const double> z) const {
  constexpr double kTouch = 1e-9;
  std::size_t first = 0;
  for (std::size_t index = 0; index < shapes_.size(); ++index) {
    const auto kind = kinds(shapes_[index]);
    const Cell& cell = cells_[index];
    for (std::size_t q = 0; q < parameter_count(shapes_[index]); ++q, ++first) {
      if (kind[q] != Kind::position || cell.walls.high <= cell.walls.low) continue;
      if (!cell.low_is_end && z[first] <= cell.walls.low / cell.unit + kTouch) return true;
      if (!cell.high_is_end && z[first] >= cell.walls.high / cell.unit - kTouch) return true;
    }
  }
  return false;
}

}  // namespace soak::anfis::training
