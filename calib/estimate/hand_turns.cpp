// SPDX-License-Identifier: Apache-2.0
#include "calib/estimate/hand_turns.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/linear/dense_solve.h"
#include "base/units.h"

namespace soak::calib {
namespace {

constexpr double kSameAttitude_rad = 5.0 * base::kRadPerDeg;
constexpr double kLargestMiss = 0.2;                        ///< of a stated angle, by the gyros' readings
constexpr double kLeastTurn_rad = 60.0 * base::kRadPerDeg;  ///< about the vertical, that is worth a stated angle
constexpr double kLeastTilt_rad = 15.0 * base::kRadPerDeg;  ///< below it a movement says next to nothing
constexpr double kLargestSigma_rad = 15.0 * base::kRadPerDeg;
constexpr double kLargestGainError = 0.2;
constexpr double kStartSigma_rad = 0.5 * base::kRadPerDeg;
constexpr double kLeastSigma_rad = 1e-9;
constexpr double kWeakestTurn = 0.5;  ///< rad per unit of gain error, over all movements: less is not seen
constexpr double kTurnShare = 0.1;    ///< share in a direction that is not seen from which an entry counts as open
constexpr double kLeastRedundancy = 1.0;
constexpr std::size_t kTurnRestsForLine = 8;  ///< from which the bias is a line in time
constexpr std::size_t kRestsForGravity = 6;
constexpr int kSteps = 30;
constexpr double kSettled =
    1e-3;  ///< change of a standard deviation, relative, and of an unknown in its standard errors
constexpr Eigen::Index kGains = 9;
constexpr Eigen::Index kUnknowns = 12;  ///< gains row by row, then errors of the bias in its standard errors

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

Eigen::Vector3d turn_vector_of(const Vector3& v) { return {v[0], v[1], v[2]}; }

// The gyros at rest.

/// What the gyros read at rest: a line in time, and a response to where up is (g-sensitivity and what of the Earth's
/// rotation goes with it), which acts while the unit is moved too.
struct RestBias {
  Eigen::MatrixX3d line;                             ///< at each rest
  Eigen::Matrix3d per_up = Eigen::Matrix3d::Zero();  ///< row: gyro
  Eigen::Vector3d standard_error = Eigen::Vector3d::Zero();
};

RestBias fit_bias(std::span<const RestAttitude> rests) {
  const auto n = static_cast<Eigen::Index>(rests.size());
  const double start_s = rests.front().t_start_s;
  const double length_s = std::max(1.0, rests.back().t_end_s - start_s);
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, 5);
  Eigen::MatrixX3d readings(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RestAttitude& rest = rests[static_cast<std::size_t>(i)];
    design(i, 0) = 1.0;
    if (rests.size() >= kRestsForGravity) design.row(i).segment<3>(1) = turn_vector_of(rest.up).transpose();
    if (rests.size() >= kTurnRestsForLine)
      design(i, 4) = (0.5 * (rest.t_start_s + rest.t_end_s) - start_s) / length_s - 0.5;
    readings.row(i) = turn_vector_of(rest.rate_rps).transpose();
  }
  RestBias bias;
  bias.line.resize(n, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd y = readings.col(axis);
    const auto solution = base::solve_orthogonal_with_factor(design, y, 1e-6);
    bias.per_up.row(axis) = solution.x.segment<3>(1).transpose();
    bias.line.col(axis) = solution.x[0] + solution.x[4] * design.col(4).array();
    const double freedoms = std::max(1.0, static_cast<double>(n - solution.rank));
    const double scatter = (y - design * solution.x).squaredNorm() / freedoms;
    bias.standard_error[axis] = std::sqrt(scatter / static_cast<double>(n));
  }
  return bias;
}

// The rotation of one movement.

enum Kind : int { kTilt, kTurn, kKinds };

/// A movement between two rests.
struct Path {
  const Move* move = nullptr;
  Eigen::Vector3d up_before;
  Eigen::Vector3d up_after;
  Eigen::Vector3d bias;
  Eigen::Matrix3d per_up;
  std::array<Eigen::Vector3d, 2> across;  ///< unit vectors across up_after
  bool tilt = false;
  double turn_rad = 0.0;  ///< stated, with its sign; 0 = none
};

/// Rotation that takes vectors from the body axes before into those after, and the angle about the vertical, unwound.
struct Rotation {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  double about_up_rad = 0.0;
};

/// Over one interval the rate goes linearly from `a` to `b`: rotation vector ½(a + b) dt + (a × b) dt²/12 (Magnus).
Rotation integrate(const Path& path, const Eigen::Matrix3d& inverse_gain, const Eigen::Vector3d& bias) {
  Rotation rotation;
  const Move& move = *path.move;
  Eigen::Vector3d up = path.up_before;
  Eigen::Vector3d a = inverse_gain * (turn_vector_of(move.rate_rps[0]) - bias - path.per_up * up);
  for (std::size_t i = 1; i < move.t_s.size(); ++i) {
    const double dt_s = move.t_s[i] - move.t_s[i - 1];
    const Eigen::Vector3d b = inverse_gain * (turn_vector_of(move.rate_rps[i]) - bias - path.per_up * up);
    const Eigen::Vector3d vector = 0.5 * dt_s * (a + b) + dt_s * dt_s / 12.0 * a.cross(b);
    rotation.about_up_rad += vector.dot(up);
    const double angle = vector.norm();
    if (angle > 0.0) {
      const Eigen::Matrix3d back = Eigen::AngleAxisd(-angle, vector / angle).toRotationMatrix();
      rotation.matrix = back * rotation.matrix;
      up = back * up;
    }
    a = b;
  }
  return rotation;
}

/// Rotation vector of a rotation matrix.
Eigen::Vector3d log_of(const Eigen::Matrix3d& matrix) {
  const Eigen::AngleAxisd turn(matrix);
  return turn.angle() * turn.axis();
}

/// Error of the integrated rotation about the vertical against the stated angle; right for many windings too.
double turn_error(const Path& path, const Rotation& rotation) {
  const Eigen::Vector3d up = (path.up_before + path.up_after).normalized();
  const Eigen::Matrix3d stated = Eigen::AngleAxisd(path.turn_rad, up).toRotationMatrix();
  const double fraction = log_of(stated.transpose() * rotation.matrix.transpose()).dot(up);
  const double coarse = rotation.about_up_rad - path.turn_rad;
  constexpr double kWhole = 2.0 * std::numbers::pi;
  return fraction + kWhole * std::round((coarse - fraction) / kWhole);
}

// The fit.

/// TurnRows of the problem: residuals and which kind of movement they are of.
struct TurnRows {
  Eigen::VectorXd residual;
  std::vector<Kind> kind;
};

class TurnProblem {
 public:
  TurnProblem(std::vector<Path> paths, const Eigen::Vector3d& bias_error)
      : paths_(std::move(paths)), bias_error_(bias_error) {}

  [[nodiscard]] TurnRows rows(const Unknowns& x) const {
    Eigen::Matrix3d gain = Eigen::Matrix3d::Identity();
    for (Eigen::Index k = 0; k < kGains; ++k) gain(k / 3, k % 3) += x[k];
    const Eigen::Matrix3d inverse = base::inverse(gain);
    const Eigen::Vector3d off = bias_error_.cwiseProduct(x.tail<3>());
    std::vector<double> values;
    TurnRows rows;
    for (const Path& path : paths_) {
      const Rotation rotation = integrate(path, inverse, path.bias + off);
      if (path.tilt) {
        const Eigen::Vector3d up = rotation.matrix * path.up_before;
        for (const Eigen::Vector3d& across : path.across) {
          values.push_back(across.dot(up));
          rows.kind.push_back(kTilt);
        }
      }
      if (path.turn_rad != 0.0) {
        values.push_back(turn_error(path, rotation));
        rows.kind.push_back(kTurn);
      }
    }
    rows.residual = Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    return rows;
  }

  /// Derivatives of the rows by differences.
  [[nodiscard]] Eigen::MatrixXd jacobian(const Unknowns& x) const {
    Eigen::MatrixXd j;
    for (Eigen::Index k = 0; k < kUnknowns; ++k) {
      const double step = k < kGains ? 1e-5 : 0.1;
      Unknowns above = x;
      Unknowns below = x;
      above[k] += step;
      below[k] -= step;
      const Eigen::VectorXd column = (rows(above).residual - rows(below).residual) / (2.0 * step);
      if (j.size() == 0) j.resize(column.size(), kUnknowns);
      j.col(k) = column;
    }
    return j;
  }

  [[nodiscard]] std::size_t count(Kind kind) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        paths_, [&](const Path& path) { return kind == kTilt ? path.tilt : path.turn_rad != 0.0; }));
  }
  [[nodiscard]] bool empty() const { return count(kTilt) + count(kTurn) == 0; }
  void leave_out(Kind kind) {
    for (Path& path : paths_) {
      if (kind == kTilt) path.tilt = false;
      if (kind == kTurn) path.turn_rad = 0.0;
    }
  }

 private:
  std::vector<Path> paths_;
  Eigen::Vector3d bias_error_;
};

/// Which gains the rows do not show.
std::array<bool, kGains> open_gains(const Eigen::MatrixXd& jacobian) {
  const base::Svd svd = base::full_v_svd(jacobian.leftCols(kGains));
  std::array<bool, kGains> open{};
  for (Eigen::Index d = 0; d < kGains; ++d) {
    if (d < svd.singular.size() && svd.singular[d] >= kWeakestTurn) continue;
    for (Eigen::Index k = 0; k < kGains; ++k) {
      open[static_cast<std::size_t>(k)] = open[static_cast<std::size_t>(k)] || std::abs(svd.v(k, d)) > kTurnShare;
    }
  }
  return open;
}

/// The fit with the variances of its kinds of movement.
struct Fit {
  Unknowns x = Unknowns::Zero();
  std::array<double, kKinds> sigma = {kStartSigma_rad, kStartSigma_rad};
  std::array<double, kKinds> redundancy{};
  std::vector<Eigen::Index> free;
  Eigen::MatrixXd covariance;                         ///< of the free unknowns
  std::array<Eigen::MatrixXd, kKinds> covariance_of;  ///< the part of it that comes from each kind
};

/// One step of Gauss and Newton, then the variances by the residuals that it leaves. Returns the largest change of an
/// unknown in its standard errors.
double step(const TurnProblem& problem, Fit& fit) {
  const TurnRows rows = problem.rows(fit.x);
  const Eigen::MatrixXd j = problem.jacobian(fit.x)(Eigen::all, fit.free);
  const auto unknowns = static_cast<Eigen::Index>(fit.free.size());
  std::array<Eigen::MatrixXd, kKinds> normal = {Eigen::MatrixXd::Zero(unknowns, unknowns),
                                                Eigen::MatrixXd::Zero(unknowns, unknowns)};
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (Eigen::Index r = 0; r < j.rows(); ++r) {
    const Kind kind = rows.kind[static_cast<std::size_t>(r)];
    const double weight = std::pow(fit.sigma[kind], -2);
    normal[kind] += weight * j.row(r).transpose() * j.row(r);
    right -= weight * rows.residual[r] * j.row(r).transpose();
  }
  Eigen::MatrixXd all = normal[kTilt] + normal[kTurn];
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    if (fit.free[static_cast<std::size_t>(k)] < kGains) continue;
    all(k, k) += 1.0;  // the bias is known to its standard error
    right[k] -= fit.x[fit.free[static_cast<std::size_t>(k)]];
  }
  fit.covariance = base::solve_ldlt(all, Eigen::MatrixXd(Eigen::MatrixXd::Identity(unknowns, unknowns)));
  const Eigen::VectorXd change = fit.covariance * right;
  fit.x(fit.free) += change;
  const Eigen::VectorXd left = rows.residual + j * change;
  for (const Kind kind : {kTilt, kTurn}) {
    double squares = 0.0;
    double count = 0.0;
    for (Eigen::Index r = 0; r < left.size(); ++r) {
      if (rows.kind[static_cast<std::size_t>(r)] != kind) continue;
      squares += left[r] * left[r];
      count += 1.0;
    }
    fit.redundancy[kind] = count - (fit.covariance * normal[kind]).trace();
    fit.covariance_of[kind] = fit.covariance * normal[kind] * fit.covariance;
    if (count > 0.0)
      fit.sigma[kind] = std::max(kLeastSigma_rad, std::sqrt(squares / std::max(0.1, fit.redundancy[kind])));
  }
  return change.cwiseQuotient(fit.covariance.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff();
}

Fit solve(const TurnProblem& problem) {
  Fit fit;
  const auto open = open_gains(problem.jacobian(fit.x));
  for (Eigen::Index k = 0; k < kUnknowns; ++k) {
    if (k >= kGains || !open[static_cast<std::size_t>(k)]) fit.free.push_back(k);
  }
  for (int i = 0; i < kSteps; ++i) {
    const auto before = fit.sigma;
    const double change = step(problem, fit);
    const bool settled = std::abs(fit.sigma[kTilt] / before[kTilt] - 1.0) < kSettled &&
                         std::abs(fit.sigma[kTurn] / before[kTurn] - 1.0) < kSettled;
    if (settled && change < kSettled) break;
  }
  return fit;
}

// What goes into it.

std::vector<Path> paths_of(std::span<const RestAttitude> rests, std::span<const Move> moves, const RestBias& bias,
                           bool with_tilts, GyroGains& gains) {
  std::vector<Path> paths;
  for (const Move& move : moves) {
    const auto before = std::ranges::find(rests, move.from_s, &RestAttitude::t_end_s);
    const auto after = std::ranges::find(rests, move.to_s, &RestAttitude::t_start_s);
    if (before == rests.end() || after == rests.end()) continue;  // the data gate rejected a rest
    if (move.flaw != MoveFlaw::none) {
      ++(move.flaw == MoveFlaw::saturated ? gains.saturated : gains.with_gaps);
      continue;
    }
    Path path;
    path.move = &move;
    path.up_before = turn_vector_of(before->up);
    path.up_after = turn_vector_of(after->up);
    path.bias = 0.5 * (bias.line.row(before - rests.begin()) + bias.line.row(after - rests.begin())).transpose();
    path.per_up = bias.per_up;
    path.across[0] = path.up_after.unitOrthogonal();
    path.across[1] = path.up_after.cross(path.across[0]);
    const double apart = std::atan2(path.up_before.cross(path.up_after).norm(), path.up_before.dot(path.up_after));
    const double read_rad = integrate(path, Eigen::Matrix3d::Identity(), path.bias).about_up_rad;
    const double turned = std::abs(read_rad);
    if (apart < kSameAttitude_rad && turned > kLeastTurn_rad) {
      const bool known = move.turn_rad && std::abs(turned - *move.turn_rad) <= kLargestMiss * *move.turn_rad;
      if (known) path.turn_rad = std::copysign(*move.turn_rad, read_rad);
      if (!known) ++gains.open_turns;
    }
    path.tilt = with_tilts && apart > kLeastTilt_rad;
    if (path.tilt || path.turn_rad != 0.0) paths.push_back(path);
  }
  return paths;
}

base::Status check_gains(const Fit& fit, const TurnProblem& problem) {
  constexpr std::array<const char*, 3> kNames = {"gyro_x", "gyro_y", "gyro_z"};
  for (const Kind kind : {kTilt, kTurn}) {
    if (problem.count(kind) == 0 || fit.sigma[kind] <= kLargestSigma_rad) continue;
    return base::bad_input(
        fmt::format("what the gyros read while the unit was moved misses the attitudes by {:.0f}° (root mean square): "
                    "check the signs, the order and the unit of the gyros' columns against those of the accelerometers",
                    fit.sigma[kind] * base::kDegPerRad));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const double error = fit.x[static_cast<Eigen::Index>(4 * i)];
    if (std::abs(error) <= kLargestGainError) continue;
    return base::bad_input(fmt::format("{} reads {:.3g} times the movements between the rests: check the sign and the "
                                       "unit of its column, and the stated angles ('turn_deg')",
                                       kNames[i], 1.0 + error),
                           kNames[i]);
  }
  return {};
}

/// Satterthwaite: ν = v²/Σ v_k²/ν_k over the parts whose variance was estimated.
Estimate estimate_of(const Fit& fit, Eigen::Index at) {
  const double variance = fit.covariance(at, at);
  double denominator = 0.0;
  for (const Kind kind : {kTilt, kTurn}) {
    if (fit.redundancy[kind] > 0.0) denominator += std::pow(fit.covariance_of[kind](at, at), 2) / fit.redundancy[kind];
  }
  return {fit.x[fit.free[static_cast<std::size_t>(at)]], std::sqrt(variance),
          denominator > 0.0 ? variance * variance / denominator : 0.0};
}

}  // namespace

base::Result<GyroGains> estimate_gains(std::span<const RestAttitude> rests, std::span<const Move> moves,
                                       bool with_tilts) {
  GyroGains gains;
  if (rests.size() < 2) return gains;
  const RestBias bias = fit_bias(rests);
  TurnProblem problem(paths_of(rests, moves, bias, with_tilts, gains), bias.standard_error);
  Fit fit;
  // A kind that nothing says the quality of is left out, and the rest fitted again.
  for (int pass = 0; pass < kKinds && !problem.empty(); ++pass) {
    fit = solve(problem);
    bool left_out = false;
    for (const Kind kind : {kTurn, kTilt}) {
      if (left_out || problem.count(kind) == 0 || fit.redundancy[kind] >= kLeastRedundancy) continue;
      problem.leave_out(kind);
      left_out = true;
    }
    if (!left_out) break;
  }
  if (problem.empty()) return gains;
  if (const auto sound = check_gains(fit, problem); !sound) return base::forward_error(sound);
  gains.tilts = problem.count(kTilt);
  gains.turns = problem.count(kTurn);
  if (gains.tilts > 0) gains.tilt_sigma_rad = fit.sigma[kTilt];
  if (gains.turns > 0) gains.turn_sigma_rad = fit.sigma[kTurn];
  for (std::size_t at = 0; at < fit.free.size(); ++at) {
    const auto k = static_cast<std::size_t>(fit.free[at]);
    if (k < static_cast<std::size_t>(kGains))
      gains.gain_error[k / 3][k % 3] = estimate_of(fit, static_cast<Eigen::Index>(at));
  }
  return gains;
}

}  // namespace soak::calib
