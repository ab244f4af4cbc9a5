// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/detail/jumps_beside_wander.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <vector>

#include "base/instruction_set.h"
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

using States = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStates, 1>;
using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostStates, kMostStates>;

/// Paths are computed so many at a time, several in one register; those beyond the last one are computed in vain.
constexpr std::size_t kBlock = 8;
constexpr std::size_t kRoom = 2 * kMostPaths;
static_assert(kRoom % kBlock == 0);

/// A number of each path.
using OfPaths = std::array<double, kRoom>;

/// Of each path what a reading lies off its states' sum and its level; the states move by their gain times that.
SOAK_CLONES void correct(std::array<OfPaths, kMostStates>& means, const States& gain, double value, double step,
                         const OfPaths& high, std::size_t count, OfPaths& off) {
  const auto states = static_cast<std::size_t>(gain.size());
  const double* const gains = gain.data();
  for (std::size_t first = 0; first < count; first += kBlock) {
    std::array<double, kBlock> left{};
    for (std::size_t c = 0; c < kBlock; ++c) left[c] = value - step * high[first + c];
    for (std::size_t k = 0; k < states; ++k) {
      for (std::size_t c = 0; c < kBlock; ++c) left[c] -= means[k][first + c];
    }
    for (std::size_t k = 0; k < states; ++k) {
      for (std::size_t c = 0; c < kBlock; ++c) means[k][first + c] += gains[k] * left[c];
    }
    for (std::size_t c = 0; c < kBlock; ++c) off[first + c] = left[c];
  }
}

/// Paths of jumps through one run, each with the means of the filter's states: visit, the run's offset, and one for
/// each process. Their covariance is the same for all paths.
class Paths {
 public:
  explicit Paths(std::size_t states) : states_(states) { begin(); }

  /// A new run, at either level.
  void begin() {
    count_ = 2;
    for (std::size_t k = 0; k < states_; ++k) means_[k][0] = means_[k][1] = 0.0;
    log_weight_[0] = log_weight_[1] = std::log(0.5);
    high_[0] = 0.0;
    high_[1] = 1.0;
  }

  /// Each path goes on at its level and, with the chance `other`, at the other one.
  void fade_and_branch(const States& fade, double other) {
    for (std::size_t k = 0; k < states_; ++k) {
      for (std::size_t path = 0; path < count_; ++path) means_[k][path] *= fade(static_cast<Eigen::Index>(k));
    }
    if (other <= 0.0) return;
    const double jumps = std::log(other);
    const double stays = std::log(1.0 - other);
    for (std::size_t k = 0; k < states_; ++k) std::copy_n(means_[k].begin(), count_, means_[k].begin() + count_);
    for (std::size_t path = 0; path < count_; ++path) {
      log_weight_[count_ + path] = log_weight_[path] + jumps;
      log_weight_[path] += stays;
      high_[count_ + path] = 1.0 - high_[path];
    }
    count_ *= 2;
  }

  /// Takes in a reading of that variance, with the filter's gain; returns ln of its density given those before.
  double take(double value, double step, const States& gain, double variance) {
    correct(means_, gain, value, step, high_, count_, off_);
    const auto count = static_cast<Eigen::Index>(count_);
    auto log_weight = Eigen::Map<Eigen::ArrayXd>(log_weight_.data(), count);
    log_weight -= 0.5 * Eigen::Map<const Eigen::ArrayXd>(off_.data(), count).square() / variance;
    const double most = log_weight.maxCoeff();
    const double log_density = most + std::log((log_weight - most).exp().sum());
    log_weight -= log_density;
    if (count_ > kMostPaths) keep_likeliest();
    return log_density - 0.5 * std::log(variance);
  }

 private:
  /// In the order in which they are; of equal ones at the limit the first.
  void keep_likeliest() {
    OfPaths sorted = log_weight_;
    const auto limit = sorted.begin() + (kMostPaths - 1);
    std::nth_element(sorted.begin(), limit, sorted.begin() + count_, std::greater<>());
    const auto above = [&](double weight) { return weight > *limit; };
    std::ptrdiff_t at_limit = static_cast<std::ptrdiff_t>(kMostPaths) - std::count_if(sorted.begin(), limit, above);
    std::size_t kept = 0;
    for (std::size_t path = 0; path < count_ && kept < kMostPaths; ++path) {
      if (log_weight_[path] < *limit || (log_weight_[path] == *limit && at_limit-- <= 0)) continue;
      for (std::size_t k = 0; k < states_; ++k) means_[k][kept] = means_[k][path];
      log_weight_[kept] = log_weight_[path];
      high_[kept] = high_[path];
      ++kept;
    }
    count_ = kept;
  }

  std::size_t states_;
  std::size_t count_ = 0;  ///< of paths: the first entries of what follows
  std::array<OfPaths, kMostStates> means_{};
  OfPaths log_weight_{};
  OfPaths high_{};  ///< 1 at the upper level, else 0
  OfPaths off_{};
};

/// ln of the density of placements' means under that noise and two levels beside it (none: variance 0), but for
/// −½ ln 2π each.
double log_likelihood(const PlacementMeans& means, const NoiseComponents& noise, const LevelPair& levels) {
  const double white = noise.placement * noise.placement + noise.block * noise.block / means.blocks;
  const Eigen::Index n = kFirstProcess + static_cast<Eigen::Index>(noise.wander.size());
  States variance(n);
  variance(kVisitState) = noise.visit * noise.visit;
  variance(kOffsetState) = kFreeOffset * white;
  for (Eigen::Index k = kFirstProcess; k < n; ++k) {
    variance(k) = std::pow(noise.wander[static_cast<std::size_t>(k - kFirstProcess)].sigma, 2);
  }
  Paths paths(static_cast<std::size_t>(n));
  States fade(n);
  Covariance covariance;
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
    const States with_reading = covariance.rowwise().sum();  // a reading is the sum of all states
    const double of_reading = with_reading.sum() + white;
    const States gain = with_reading / of_reading;
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
