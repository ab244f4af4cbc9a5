// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/jumps_beside_wander.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include "calib/gap/noise/noise.h"
#include "calib/gap/search/detail/telegraph.h"

namespace soak::calib::gap {
namespace {

constexpr Eigen::Index kMostPaths = 48;
/// Where the search for two levels begins: mean times between jumps, and shares of the wander's variance.
constexpr std::array<double, 3> kFirstStays_s = {2000.0, 8000.0, 32000.0};
constexpr std::array<double, 2> kFirstShares = {0.4, 0.7};
constexpr double kHopeless = -8.0;   ///< of the logarithm of a ratio, from where a search does not lead above 1
constexpr double kFreeOffset = 1e4;  ///< variance of a run's offset, over that of a placement
constexpr Eigen::Index kVisitState = 0;
constexpr Eigen::Index kOffsetState = 1;
constexpr Eigen::Index kFirstProcess = 2;

/// Two levels ± sqrt(variance) about their middle; between them a mean time.
struct LevelPair {
  double variance = 0.0;
  double stay_s = 1.0;

  /// Chance of the other level after so long: ½ (1 − exp(−2 t/stay)).
  [[nodiscard]] double other_after(double time_s) const {
    return variance > 0.0 ? 0.5 - 0.5 * std::exp(-2.0 * std::max(0.0, time_s) / stay_s) : 0.0;
  }
};

/// What the levels leave of a wander. Their covariance is that of a Gauss-Markov process of half the mean stay, so that
/// the processes nearest to that give first.
std::vector<GaussMarkov> beside(std::vector<GaussMarkov> wander, const LevelPair& levels) {
  std::vector<GaussMarkov*> nearest;
  for (GaussMarkov& process : wander) nearest.push_back(&process);
  const auto distance = [&](const GaussMarkov* process) {
    return std::abs(std::log(2.0 * process->tau_s / levels.stay_s));
  };
  std::ranges::sort(nearest, {}, distance);
  double wanted = levels.variance;
  for (GaussMarkov* process : nearest) {
    const double given = std::min(wanted, process->sigma * process->sigma);
    process->sigma = std::sqrt(process->sigma * process->sigma - given);
    wanted -= given;
  }
  return wander;
}

/// Paths of jumps through one run, each with the means of the filter's states: visit, the run's offset, and one for
/// each process. Their covariance is the same for all paths.
class Paths {
 public:
  explicit Paths(Eigen::Index states)
      : means_(2 * kMostPaths, states), log_weight_(2 * kMostPaths), high_(2 * kMostPaths) {
    begin();
  }

  /// A new run, at either level.
  void begin() {
    count_ = 2;
    means_.topRows(2).setZero();
    log_weight_.head(2) = std::log(0.5);
    high_.head(2) << 0.0, 1.0;
  }

  /// Each path goes on at its level and, with the chance `other`, at the other one.
  void fade_and_branch(const Eigen::VectorXd& fade, double other) {
    for (Eigen::Index state = 0; state < fade.size(); ++state) means_.col(state).head(count_) *= fade(state);
    if (other <= 0.0) return;
    means_.middleRows(count_, count_) = means_.topRows(count_);
    log_weight_.segment(count_, count_) = log_weight_.head(count_) + std::log(other);
    log_weight_.head(count_) += std::log(1.0 - other);
    high_.segment(count_, count_) = 1.0 - high_.head(count_);
    count_ *= 2;
  }

  /// Takes in a reading of that variance, with the filter's gain; returns ln of its density given those before.
  double take(double value, double step, const Eigen::VectorXd& gain, double variance) {
    const Eigen::ArrayXd off = value - means_.topRows(count_).rowwise().sum() - step * high_.head(count_);
    auto log_weight = log_weight_.head(count_);
    log_weight -= 0.5 * off.square() / variance;
    for (Eigen::Index state = 0; state < gain.size(); ++state) means_.col(state).head(count_) += gain(state) * off;
    const double most = log_weight.maxCoeff();
    const double log_density = most + std::log((log_weight - most).exp().sum());
    log_weight -= log_density;
    if (count_ > kMostPaths) keep_likeliest();
    return log_density - 0.5 * std::log(variance);
  }

 private:
  void keep_likeliest() {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(count_));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::nth_element(order, order.begin() + kMostPaths, std::greater<>(),
                             [&](Eigen::Index k) { return log_weight_(k); });
    order.resize(kMostPaths);
    std::ranges::sort(order);  // so that no path is overwritten before it is moved
    for (Eigen::Index k = 0; k < kMostPaths; ++k) {
      const Eigen::Index from = order[static_cast<std::size_t>(k)];
      means_.row(k) = means_.row(from);
      log_weight_(k) = log_weight_(from);
      high_(k) = high_(from);
    }
    count_ = kMostPaths;
  }

  Eigen::Index count_ = 0;  ///< of paths: the first rows of what follows
  Eigen::ArrayXXd means_;   ///< a column for each state, so that all paths are computed at once
  Eigen::ArrayXd log_weight_;
  Eigen::ArrayXd high_;  ///< 1 at the upper level, else 0
};

/// ln of the density of placements' means under that noise and two levels beside it (none: variance 0), but for
/// −½ ln 2π each.
double log_likelihood(const PlacementMeans& means, const NoiseComponents& noise, const LevelPair& levels) {
  const double white = noise.placement * noise.placement + noise.block * noise.block / means.blocks;
  const Eigen::Index n = kFirstProcess + static_cast<Eigen::Index>(noise.wander.size());
  Eigen::VectorXd variance(n);
  variance(kVisitState) = noise.visit * noise.visit;
  variance(kOffsetState) = kFreeOffset * white;
  for (Eigen::Index k = kFirstProcess; k < n; ++k) {
    variance(k) = std::pow(noise.wander[static_cast<std::size_t>(k - kFirstProcess)].sigma, 2);
  }
  Paths paths(n);
  Eigen::VectorXd fade(n);
  Eigen::MatrixXd covariance;
  double sum = 0.0;
  for (std::size_t i = 0; i < means.readings.size(); ++i) {
    const Reading& reading = means.readings[i];
    if (i == 0 || reading.run != means.readings[i - 1].run) {
      paths.begin();
      covariance = variance.asDiagonal();
    } else {
      const Reading& before = means.readings[i - 1];
      const double apart_s = means.observations.rows[i].t_s - means.observations.rows[i - 1].t_s;
      fade(kVisitState) = means.observations.rows[i].visit == means.observations.rows[i - 1].visit ? 1.0 : 0.0;
      fade(kOffsetState) = 1.0;
      for (Eigen::Index k = kFirstProcess; k < n; ++k) {
        fade(k) = std::exp(-apart_s / noise.wander[static_cast<std::size_t>(k - kFirstProcess)].tau_s);
      }
      covariance = fade.asDiagonal() * covariance * fade.asDiagonal();
      covariance.diagonal().array() += variance.array() * (1.0 - fade.array().square());
      paths.fade_and_branch(
          fade, levels.other_after(0.5 * (reading.end_s + reading.begin_s - before.end_s - before.begin_s)));
    }
    const Eigen::VectorXd with_reading = covariance.rowwise().sum();  // a reading is the sum of all states
    const double of_reading = with_reading.sum() + white;
    const Eigen::VectorXd gain = with_reading / of_reading;
    covariance -= gain * with_reading.transpose();
    sum += paths.take(reading.value, 2.0 * std::sqrt(levels.variance), gain, of_reading);
  }
  return sum;
}

/// The same with levels that are Gaussian: a process of their covariance in their place, or nothing, as the estimate of
/// the wander may be too large.
double log_likelihood_of_twin(const PlacementMeans& means, const NoiseComponents& noise, const LevelPair& levels) {
  NoiseComponents with_twin = noise;
  with_twin.wander.push_back({0.5 * levels.stay_s, std::sqrt(levels.variance)});
  return std::max(log_likelihood(means, with_twin, {}), log_likelihood(means, noise, {}));
}

using LogLikelihood = double (*)(const PlacementMeans&, const NoiseComponents&, const LevelPair&);

/// The largest likelihood over the variance of the levels and the time between jumps, beside what they leave of the
/// wander: from the best of a few, uphill by smaller and smaller steps.
class Largest {
 public:
  Largest(const PlacementMeans& means, const NoiseComponents& noise, LogLikelihood likelihood)
      : means_(means), noise_(noise), likelihood_(likelihood) {
    for (const GaussMarkov& process : noise.wander) wander_ += process.sigma * process.sigma;
  }

  /// Gives up where the best of the first few lies so far below `other` that the search will not reach it.
  double search(double other) {
    for (const double stay_s : kFirstStays_s) {
      for (const double share : kFirstShares) try_levels({share * wander_, stay_s});
    }
    for (double factor = 2.0; factor > 1.1 && best_ > other + kHopeless; factor = std::sqrt(factor)) {
      const LevelPair from = levels_;
      for (const double scale : {1.0 / factor, factor}) {
        try_levels({from.variance, from.stay_s * scale});
        try_levels({from.variance * std::sqrt(scale), from.stay_s});
      }
    }
    return best_;
  }

 private:
  void try_levels(const LevelPair& levels) {
    NoiseComponents rest = noise_;
    rest.wander = beside(noise_.wander, levels);
    const double value = likelihood_(means_, rest, levels);
    if (value <= best_) return;
    best_ = value;
    levels_ = levels;
  }

  const PlacementMeans& means_;
  const NoiseComponents& noise_;
  LogLikelihood likelihood_;
  double wander_ = 0.0;  ///< variance
  LevelPair levels_;
  double best_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

double chance_of_jumps_beside_wander(const CampaignModel& model, Sensor sensor) {
  const std::size_t s = index_of(sensor);
  if (!model.residuals().sensor[s] || model.residuals().noise[s].wander.empty()) return 1.0;
  const PlacementMeans means = placement_means(model.regressor_inputs().observations, model.remainder(sensor), sensor);
  const NoiseComponents& noise = model.residuals().noise[s];
  const double of_wander = log_likelihood(means, noise, {});
  const double of_twin = std::max(of_wander, Largest(means, noise, log_likelihood_of_twin).search(of_wander));
  const double of_levels = Largest(means, noise, log_likelihood).search(of_twin);
  return std::min(1.0, std::exp(of_twin - of_levels));
}

}  // namespace soak::calib::gap
