// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/detail/joint_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/units.h"

namespace soak::calib::six_position {
namespace {

constexpr double kLeastShare = 0.02;  ///< of the readings' information that the other unknowns must leave

using Face = std::array<long, 3>;

/// What the rows of one accelerometer say of the two tilts alone.
struct LevelNormal {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
};

/// Eliminates all shared unknowns but the tilts, which are the last.
LevelNormal eliminate_shared(const SharedNormal& normal) {
  const Eigen::Index k = normal.matrix.rows() - kLevelCount;
  const Eigen::MatrixXd cross = normal.matrix.topRightCorner(k, kLevelCount);
  const Eigen::MatrixXd own = normal.matrix.topLeftCorner(k, k);
  const Eigen::VectorXd right = normal.right.head(k);
  // Unknowns that the segments do not show take nothing away.
  constexpr double kDependent = 1e-9;
  return {normal.matrix.bottomRightCorner<kLevelCount, kLevelCount>() -
              cross.transpose() * base::solve_orthogonal(own, cross, kDependent),
          normal.right.tail<kLevelCount>() - cross.transpose() * base::solve_orthogonal(own, right, kDependent)};
}

/// One accelerometer on its way into the sum.
struct LevelPart {
  Problem problem;
  double drift_variance = 0.0;
  double inflation = 0.0;  ///< of its standard errors
};

LevelNormal level_normal(const LevelPart& part, const Problem& problem) {
  return eliminate_shared(shared_normal(problem, part.drift_variance));
}

std::vector<LevelPart> parts_of(std::span<const Problem> accelerometers, bool with_contrast) {
  std::vector<LevelPart> parts;
  for (const Problem& accelerometer : accelerometers) {
    if (accelerometer.rows.empty()) continue;
    LevelPart part{accelerometer};
    part.problem.with_even = part.problem.with_level = true;
    part.problem.with_contrast = with_contrast && accelerometer.with_contrast;
    const Solution solution = solve(part.problem);
    part.drift_variance = solution.drift_variance;
    part.inflation = inflation_of(part.problem, solution);
    parts.push_back(std::move(part));
  }
  return parts;
}

/// What the readings would say of the tilts if nothing else were unknown.
double information_without_others(const std::vector<LevelPart>& parts) {
  double information = 0.0;
  for (const LevelPart& part : parts) {
    const std::size_t axis = axis_of(part.problem.sensor);
    for (const Row& row : part.problem.rows) {
      information += row.weight * (row.north[axis] * row.north[axis] + row.east[axis] * row.east[axis]);
    }
  }
  return information / kLevelCount;
}

/// Residuals of all accelerometers together: what one of them does not explain is mostly its faces, and no reason to
/// trust it less than the others.
double pooled_variance(const std::vector<LevelPart>& parts) {
  double sum = 0.0;
  for (const LevelPart& part : parts) sum += part.inflation * part.inflation;
  return sum / static_cast<double>(parts.size());
}

Face face_of(const Row& row) {
  return {std::lround(100.0 * row.up[0]), std::lround(100.0 * row.up[1]), std::lround(100.0 * row.up[2])};
}

/// A face that is tilted by 1 rad changes the readings of each accelerometer that lies in it by g, in the unknowns' own
/// unit by 1. Root of the sum of squares over faces and accelerometers.
Eigen::Vector2d response_to_faces(const std::vector<LevelPart>& parts, const Eigen::Matrix2d& inverse) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (const LevelPart& part : parts) {
    const std::size_t axis = axis_of(part.problem.sensor);
    std::set<Face> faces;
    for (const Row& row : part.problem.rows) {
      if (std::abs(row.up[axis]) < kOnAxis) faces.insert(face_of(row));
    }
    for (const Face& face : faces) {
      Problem tilted = part.problem;
      for (Row& row : tilted.rows) row.value = face_of(row) == face ? 1.0 : 0.0;
      squares += (inverse * level_normal(part, tilted).right).cwiseAbs2();
    }
  }
  return squares.cwiseSqrt();
}

std::string hidden_direction(const Eigen::Vector2d& direction) {
  double heading_deg = std::atan2(direction[1], direction[0]) * base::kDegPerRad;
  if (heading_deg < -0.5) heading_deg += 180.0;
  return fmt::format(
      "the headings of these positions do not separate a tilt towards {:.0f}° from misalignment and even-order terms; "
      "positions at other headings would",
      std::abs(std::round(heading_deg)));
}

/// The fit over these parts; absent where a direction stays open, which `open` receives.
std::optional<LevelFit> fit_parts(const std::vector<LevelPart>& parts, Eigen::Vector2d& open) {
  LevelNormal sum;
  for (const LevelPart& part : parts) {
    const LevelNormal normal = level_normal(part, part.problem);
    sum.matrix += normal.matrix;
    sum.right += normal.right;
  }
  const base::SymmetricEigen2 eigen = base::symmetric_eigen(sum.matrix);
  open = eigen.vectors.col(0);
  if (!(eigen.values[0] > kLeastShare * information_without_others(parts))) return std::nullopt;
  const Eigen::Matrix2d inverse = base::inverse(sum.matrix);
  const double g = parts.front().problem.gravity_mps2;
  LevelFit fit;
  fit.tilt = inverse * sum.right / g;
  fit.covariance = pooled_variance(parts) / (g * g) * inverse;
  fit.per_face_tilt = response_to_faces(parts, inverse);
  return fit;
}

}  // namespace

LevelAnswer fit_level(std::span<const Problem> accelerometers) {
  Eigen::Vector2d open;
  for (const bool with_contrast : {true, false}) {
    const auto parts = parts_of(accelerometers, with_contrast);
    if (parts.empty()) return {std::nullopt, "there are no readings of accelerometers at plateaus"};
    if (auto fit = fit_parts(parts, open)) return {std::move(fit), {}};
  }
  return {std::nullopt, hidden_direction(open)};
}

}  // namespace soak::calib::six_position
