// SPDX-License-Identifier: Apache-2.0
#include "calib/curve/baselines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "anfis/linear/least_squares.h"
#include "base/linear/dense_solve.h"

namespace soak::calib {
namespace {

constexpr double kClusterApart_c = 0.5;
constexpr std::size_t kMostKnots = 40;
constexpr int kHermitePieces = 64;
/// Least share of the rows in a direction's information and curvature from which they determine it: less is rounding.
constexpr double kDetermined = 1e-12;
/// The same for a direction that the least smoothness may be chosen for: rows that know next to nothing of it would
/// else win the curve over to their noise there.
constexpr double kWellDetermined = 1e-4;

struct TempRange {
  double low;
  double high;
};

TempRange range_of(const std::vector<double>& x) {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  return {*low, *high};
}

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

anfis::GroupWhitening whitening_of(const anfis::TrainingData& data) {
  return {data.rows(), data.weight, data.group, data.group_variance};
}

/// Piece of a cubic with given values and slopes at its two ends, as powers of the distance from the left end.
std::array<double, 4> hermite_piece(double width, double y0, double y1, double slope0, double slope1) {
  const double chord = (y1 - y0) / width;
  return {y0, slope0, (3.0 * chord - 2.0 * slope0 - slope1) / width, (slope0 + slope1 - 2.0 * chord) / (width * width)};
}

Eigen::VectorXd powers(double u, int degree) {
  Eigen::VectorXd p(degree + 1);
  p[0] = 1.0;
  for (int k = 1; k <= degree; ++k) p[k] = p[k - 1] * u;
  return p;
}

SplineCurve polynomial_pieces(const Eigen::VectorXd& c, double centre, double half_range, TempRange range, int pieces) {
  const auto value = [&](double t) {
    const double u = (t - centre) / half_range;
    double y = 0.0;
    for (Eigen::Index k = c.size(); k-- > 0;) y = y * u + c[k];
    return y;
  };
  const auto slope = [&](double t) {
    const double u = (t - centre) / half_range;
    double y = 0.0;
    for (Eigen::Index k = c.size(); k-- > 1;) y = y * u + static_cast<double>(k) * c[k];
    return y / half_range;
  };
  SplineCurve spline;
  const double width = (range.high - range.low) / pieces;
  for (int i = 0; i < pieces; ++i) {
    const double left = range.low + i * width;
    const double right = i + 1 == pieces ? range.high : left + width;
    spline.knots_c.push_back(left);
    spline.coefficients.push_back(hermite_piece(right - left, value(left), value(right), slope(left), slope(right)));
  }
  spline.knots_c.push_back(range.high);
  return spline;
}

/// Natural cubic spline as a linear function of its values at the knots (Green & Silverman 1994, §2.1).
struct NaturalSpline {
  std::vector<double> knots;
  Eigen::MatrixXd second;     ///< second derivatives at the knots from the values there (0 at both ends)
  Eigen::MatrixXd curvature;  ///< ∫ f″² = ||curvature g||²

  explicit NaturalSpline(std::vector<double> at) : knots(std::move(at)) {
    const auto k = static_cast<Eigen::Index>(knots.size());
    Eigen::MatrixXd q = Eigen::MatrixXd::Zero(k, k - 2);
    Eigen::MatrixXd r = Eigen::MatrixXd::Zero(k - 2, k - 2);
    const auto h = [&](Eigen::Index i) {
      return knots[static_cast<std::size_t>(i) + 1] - knots[static_cast<std::size_t>(i)];
    };
    for (Eigen::Index j = 1; j + 1 < k; ++j) {
      q(j - 1, j - 1) = 1.0 / h(j - 1);
      q(j, j - 1) = -1.0 / h(j - 1) - 1.0 / h(j);
      q(j + 1, j - 1) = 1.0 / h(j);
      r(j - 1, j - 1) = (h(j - 1) + h(j)) / 3.0;
      if (j + 2 < k) r(j - 1, j) = r(j, j - 1) = h(j) / 6.0;
    }
    // R γ = Qᵀg and ∫ f″² = γᵀRγ, R = LLᵀ.
    curvature = base::solve_lower(base::cholesky(r), Eigen::MatrixXd(q.transpose()));
    second = Eigen::MatrixXd::Zero(k, k);
    second.middleRows(1, k - 2) = base::solve_ldlt(r, Eigen::MatrixXd(q.transpose()));
  }

  [[nodiscard]] std::size_t piece_of(double t) const {
    const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
    return static_cast<std::size_t>(above - knots.begin()) - 1;
  }

  /// Row that gives the value at t from the values at the knots; linear outside them.
  [[nodiscard]] Eigen::VectorXd row(double t) const {
    const std::size_t i = piece_of(t);
    const double h = knots[i + 1] - knots[i];
    const auto left = static_cast<Eigen::Index>(i);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()));
    if (t < knots.front() || t > knots.back()) {
      const double end = t < knots.front() ? knots.front() : knots.back();
      weights = row(end);
      Eigen::VectorXd slope = Eigen::VectorXd::Zero(weights.size());
      slope[left] = -1.0 / h;
      slope[left + 1] = 1.0 / h;
      const double at_left = t < knots.front() ? -h / 3.0 : h / 6.0;
      const double at_right = t < knots.front() ? -h / 6.0 : h / 3.0;
      slope += at_left * second.row(left).transpose() + at_right * second.row(left + 1).transpose();
      return weights + (t - end) * slope;
    }
    const double a = (knots[i + 1] - t) / h;
    const double b = (t - knots[i]) / h;
    weights[left] = a;
    weights[left + 1] = b;
    weights += (a * a * a - a) * h * h / 6.0 * second.row(left).transpose();
    weights += (b * b * b - b) * h * h / 6.0 * second.row(left + 1).transpose();
    return weights;
  }

  /// The pieces of the spline with values g at the knots.
  [[nodiscard]] SplineCurve pieces(const Eigen::VectorXd& g) const {
    const Eigen::VectorXd m = second * g;
    SplineCurve spline;
    spline.knots_c = knots;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double h = knots[i + 1] - knots[i];
      spline.coefficients.push_back(
          {g[k], (g[k + 1] - g[k]) / h - h * (2.0 * m[k] + m[k + 1]) / 6.0, 0.5 * m[k], (m[k + 1] - m[k]) / (6.0 * h)});
    }
    return spline;
  }
};

/// Penalised least squares diagonalised once (Demmler-Reinsch), so that each smoothness costs a pass over the knots.
///
/// Columns v diagonalise what the rows A know and the curvature L of the spline together, with ||Av||² + β||Lv||² = 1,
/// by way of the QR decomposition of both, one above the other (Van Loan's generalised singular values): a direction
/// that no row determines, as the level of temperatures that only runs with a free offset have visited, is as well
/// conditioned as any other, and the curve is smoothest there. β makes both as large; a smoothness λ stands for βλ.
struct Smoother {
  Eigen::MatrixXd vectors;
  Eigen::ArrayXd information;  ///< ||Av||², 0 where no row determines v
  Eigen::ArrayXd roughness;    ///< β||Lv||²
  Eigen::ArrayXd projection;   ///< vᵀAᵀy
  double total = 0.0;          ///< yᵀy
  double rows = 0.0;
  double free_level = 0.0;  ///< parameters outside the columns: 1 if free group offsets leave the level to choice

  /// weight: that of all rows.
  Smoother(const Eigen::MatrixXd& a, const Eigen::VectorXd& y, const NaturalSpline& spline, double weight)
      : total(y.squaredNorm()), rows(static_cast<double>(y.size())) {
    const Eigen::Index k = a.cols();
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(a.rows() + k, k);
    both.topRows(a.rows()) = a;
    both.middleRows(a.rows(), k - 2) = std::sqrt(weight) / spline.curvature.norm() * spline.curvature;
    // Level and slope cost no curvature. Where no row determines them, they are 0 in the mean over the knots.
    const Eigen::VectorXd level = Eigen::VectorXd::Constant(k, 1.0 / std::sqrt(static_cast<double>(k)));
    const Eigen::VectorXd temps = as_vector(spline.knots);
    const Eigen::VectorXd slope = (temps.array() - temps.mean()).matrix().normalized();
    const auto unknown = [&](const Eigen::VectorXd& v) { return (a * v).squaredNorm() <= kDetermined * weight; };
    if (unknown(level)) {
      free_level = 1.0;
      both.row(both.rows() - 2) = std::sqrt(weight) * level.transpose();
    }
    if (unknown(slope)) both.row(both.rows() - 1) = std::sqrt(weight) * slope.transpose();
    const Eigen::MatrixXd upper = base::upper_of_qr(both);
    const Eigen::MatrixXd known = base::solve_lower(upper.transpose(), Eigen::MatrixXd(a.transpose()));
    const base::SymmetricEigen eigen = base::symmetric_eigen(Eigen::MatrixXd(known * known.transpose()));
    information = (eigen.values.array() > kDetermined).select(eigen.values.array().min(1.0), 0.0);
    roughness = 1.0 - information;
    projection = (information > 0.0).select((eigen.vectors.transpose() * (known * y)).array(), 0.0);
    vectors = base::solve_upper(upper, eigen.vectors);
  }

  [[nodiscard]] Eigen::ArrayXd inverse(double lambda) const { return (information + lambda * roughness).inverse(); }
  /// Effective number of parameters: trace of the smoother.
  [[nodiscard]] double parameters(double lambda) const { return free_level + (information * inverse(lambda)).sum(); }
  [[nodiscard]] double rss(double lambda) const {
    const Eigen::ArrayXd d = inverse(lambda);
    return std::max(0.0, total - (projection.square() * d * (2.0 - information * d)).sum());
  }
  [[nodiscard]] double gcv(double lambda) const {
    const double left = rows - parameters(lambda);
    return left <= 0.5 ? std::numeric_limits<double>::infinity() : rows * rss(lambda) / (left * left);
  }
};

double best_smoothness(const Smoother& smoother) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < smoother.roughness.size(); ++i) {
    if (smoother.information[i] < kWellDetermined) continue;
    largest = std::max(largest, smoother.roughness[i] / smoother.information[i]);
  }
  if (largest <= 0.0) return 1.0;  // a straight line, whatever the smoothness
  double best = 0.0;
  double best_gcv = std::numeric_limits<double>::infinity();
  for (double exponent = -4.0; exponent <= 12.0; exponent += 0.125) {
    const double lambda = std::pow(10.0, exponent) / largest;
    const double score = smoother.gcv(lambda);
    if (score < best_gcv) {
      best_gcv = score;
      best = lambda;
    }
  }
  return best;
}

}  // namespace

std::vector<double> temperature_clusters(std::vector<double> temps_c, double apart_c, std::size_t most) {
  std::sort(temps_c.begin(), temps_c.end());
  std::vector<double> middles;
  for (std::size_t first = 0; first < temps_c.size();) {
    std::size_t last = first;
    double sum = 0.0;
    for (; last < temps_c.size() && temps_c[last] - temps_c[first] < apart_c; ++last) sum += temps_c[last];
    middles.push_back(sum / static_cast<double>(last - first));
    first = last;
  }
  if (middles.size() <= most) return middles;
  std::vector<double> chosen;
  for (std::size_t i = 0; i < most; ++i) {
    const double at = static_cast<double>(i) * static_cast<double>(middles.size() - 1) / static_cast<double>(most - 1);
    chosen.push_back(middles[static_cast<std::size_t>(std::lround(at))]);
  }
  return chosen;
}

base::Result<FittedCurve> fit_polynomial(const anfis::TrainingData& data, int degree) {
  const std::size_t clusters = temperature_clusters(data.x, kClusterApart_c, data.rows()).size();
  if (clusters < static_cast<std::size_t>(degree) + 1) {
    return base::bad_input(fmt::format("a polynomial of degree {} needs {} distinct temperatures; there are {}", degree,
                                       degree + 1, clusters));
  }
  const TempRange range = range_of(data.x);
  const double centre = 0.5 * (range.low + range.high);
  const double half_range = 0.5 * (range.high - range.low);
  Eigen::MatrixXd a(static_cast<Eigen::Index>(data.rows()), degree + 1);
  for (std::size_t i = 0; i < data.rows(); ++i) {
    a.row(static_cast<Eigen::Index>(i)) = powers((data.x[i] - centre) / half_range, degree).transpose();
  }
  Eigen::MatrixXd y = as_vector(data.y);
  const anfis::GroupWhitening whitening = whitening_of(data);
  whitening.apply(a);
  whitening.apply(y);
  const anfis::LeastSquaresFit fit = anfis::solve_least_squares(a, y.col(0));

  FittedCurve result;
  result.curve = polynomial_pieces(fit.coefficients, centre, half_range, range, degree <= 3 ? 1 : kHermitePieces);
  result.parameters = static_cast<double>(fit.rank);
  result.whitened_rss = fit.residual_sum_of_squares;
  result.variance = [factor = fit.covariance_factor, centre, half_range, degree](double t) {
    return (factor.transpose() * powers((t - centre) / half_range, degree)).squaredNorm();
  };
  return result;
}

base::Result<FittedCurve> fit_smoothing_spline(const anfis::TrainingData& data) {
  std::vector<double> knots = temperature_clusters(data.x, kClusterApart_c, kMostKnots);
  if (knots.size() < 3) {
    return base::bad_input(
        fmt::format("a smoothing spline needs three distinct temperatures; there are {}", knots.size()));
  }
  // The domain of the curve is the range of the rows, not that of the clusters' middles.
  const TempRange range = range_of(data.x);
  knots.front() = range.low;
  knots.back() = range.high;
  const NaturalSpline spline(std::move(knots));
  const auto k = static_cast<Eigen::Index>(spline.knots.size());
  Eigen::MatrixXd a(static_cast<Eigen::Index>(data.rows()), k);
  for (std::size_t i = 0; i < data.rows(); ++i) {
    a.row(static_cast<Eigen::Index>(i)) = spline.row(data.x[i]).transpose();
  }
  Eigen::MatrixXd y = as_vector(data.y);
  const anfis::GroupWhitening whitening = whitening_of(data);
  whitening.apply(a);
  whitening.apply(y);

  const Smoother smoother(a, y.col(0), spline, whitening.total_weight());
  const double lambda = best_smoothness(smoother);
  const Eigen::ArrayXd inverse = smoother.inverse(lambda);
  const Eigen::VectorXd g = smoother.vectors * (inverse * smoother.projection).matrix();
  FittedCurve result;
  result.curve = spline.pieces(g);
  result.parameters = smoother.parameters(lambda);
  result.whitened_rss = (y.col(0) - a * g).squaredNorm();
  const Eigen::MatrixXd factor = smoother.vectors * inverse.sqrt().matrix().asDiagonal();
  result.variance = [spline, factor](double t) { return (factor.transpose() * spline.row(t)).squaredNorm(); };
  return result;
}

}  // namespace soak::calib
