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

constexpr std::size_t kMostPaths = 48;
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
  explicit Paths(Eigen::Index states) : means_(states, 2 * kMostPaths) { begin(); }

  /// A new run, at either level.
  void begin() {
    means_.leftCols(2).setZero();
    log_weight_.assign(2, std::log(0.5));
    high_ = {0, 1};
  }

  /// Each path goes on at its level and, with the chance `other`, at the other one.
  void fade_and_branch(const Eigen::VectorXd& fade, double other) {
    const std::size_t count = log_weight_.size();
    for (std::size_t k = 0; k < count; ++k) {
      means_.col(static_cast<Eigen::Index>(k)).array() *= fade.array();
      if (other <= 0.0) continue;
      means_.col(static_cast<Eigen::Index>(count + k)) = means_.col(static_cast<Eigen::Index>(k));
      log_weight_.push_back(log_weight_[k] + std::log(other));
      high_.push_back(static_cast<char>(1 - high_[k]));
      log_weight_[k] += std::log(1.0 - other);
    }
  }

  /// Takes in a reading of that variance, with the filter's gain; returns ln of its density given those before.
  double take(double value, double step, const Eigen::VectorXd& gain, double variance) {
    for (std::size_t k = 0; k < log_weight_.size(); ++k) {
      auto mean = means_.col(static_cast<Eigen::Index>(k));
      const double off = value - mean.sum() - (high_[k] != 0 ? step : 0.0);
      log_weight_[k] -= 0.5 * (off * off / variance + std::log(variance));
      mean += off * gain;
    }
    const double most = *std::ranges::max_element(log_weight_);
    double sum = 0.0;
    for (const double weight : log_weight_) sum += std::exp(weight - most);
    const double log_density = most + std::log(sum);
    for (double& weight : log_weight_) weight -= log_density;
    if (log_weight_.size() > kMostPaths) keep_likeliest();
    return log_density;
  }

 private:
  void keep_likeliest() {
    std::vector<std::size_t> order(log_weight_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::nth_element(order, order.begin() + kMostPaths, std::greater<>(),
                             [&](std::size_t k) { return log_weight_[k]; });
    order.resize(kMostPaths);
    std::ranges::sort(order);  // so that no column is overwritten before it is moved
    for (std::size_t k = 0; k < kMostPaths; ++k) {
      means_.col(static_cast<Eigen::Index>(k)) = means_.col(static_cast<Eigen::Index>(order[k]));
      log_weight_[k] = log_weight_[order[k]];
      high_[k] = high_[order[k]];
    }
    log_weight_.resize(kMostPaths);
    high_.resize(kMostPaths);
  }

  Eigen::MatrixXd means_;
  std::vector<double> log_weight_;
  std::vector<char> high_;
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
