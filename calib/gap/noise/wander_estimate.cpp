// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/noise/wander_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

#include "base/linear/dense_solve.h"

namespace soak::calib::gap {
namespace {

constexpr std::array<double, 5> kTaus_s = {300.0, 1500.0, 7500.0, 37500.0, 187500.0};
constexpr std::size_t kOfPlacement = 0;
constexpr std::size_t kOfVisit = 1;
constexpr std::size_t kFirstTau = 2;
constexpr std::size_t kComponents = kFirstTau + kTaus_s.size();
/// Variances for which the estimates are best, over that of placements.
constexpr double kVisitWeight = 0.25;
constexpr double kWanderWeight = 1.0 / static_cast<double>(kTaus_s.size());
constexpr double kRidge = 1e-9;            ///< means of runs and of what they repeat depend on each other
constexpr double kLeastReplicated = 10.0;  ///< placements beyond the number of the means

/// Placements that another run repeats.
std::vector<Stay> repeated(std::vector<Stay> placements) {
  std::map<int, int> count;
  for (const Stay& placement : placements) ++count[placement.cell];
  std::erase_if(placements, [&](const Stay& placement) { return count.at(placement.cell) < 2; });
  return placements;
}

double kernel(std::size_t component, const Stay& a, const Stay& b) {
  if (component == kOfPlacement) return &a == &b ? 1.0 : 0.0;
  if (component == kOfVisit) return same_visit(a, b) ? 1.0 : 0.0;
  return std::exp(-std::abs(a.t_s.value - b.t_s.value) / kTaus_s[component - kFirstTau]);
}

/// One column for each run and each cell.
Eigen::MatrixXd means_of(const std::vector<Stay>& places, const std::vector<Eigen::Index>& run_first) {
  std::map<int, Eigen::Index> cells;
  for (const Stay& place : places) cells.try_emplace(place.cell, static_cast<Eigen::Index>(cells.size()));
  const auto n = static_cast<Eigen::Index>(places.size());
  const auto runs = static_cast<Eigen::Index>(run_first.size()) - 1;
  Eigen::MatrixXd means = Eigen::MatrixXd::Zero(n, runs + static_cast<Eigen::Index>(cells.size()));
  for (Eigen::Index r = 0; r < runs; ++r) {
    for (Eigen::Index i = run_first[static_cast<std::size_t>(r)]; i < run_first[static_cast<std::size_t>(r) + 1]; ++i) {
      means(i, r) = 1.0;
      means(i, runs + cells.at(places[static_cast<std::size_t>(i)].cell)) = 1.0;
    }
  }
  return means;
}

/// The x ≥ 0 of least ½ xᵀAx − bᵀx: the best of all choices of components that are not zero.
Eigen::VectorXd least_squares_not_negative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd best = Eigen::VectorXd::Zero(b.size());
  double least = 0.0;
  for (std::uint32_t choice = 1; choice < (1U << b.size()); ++choice) {
    std::vector<Eigen::Index> chosen;
    for (Eigen::Index k = 0; k < b.size(); ++k) {
      if ((choice >> k & 1U) != 0) chosen.push_back(k);
    }
    const Eigen::VectorXd x = base::solve_ldlt(Eigen::MatrixXd(a(chosen, chosen)), Eigen::VectorXd(b(chosen)));
    if (!x.allFinite() || x.minCoeff() < 0.0) continue;
    const double value = -0.5 * x.dot(b(chosen));
    if (value >= least) continue;
    least = value;
    best.setZero();
    best(chosen) = x;
  }
  return best;
}

}  // namespace

WanderEstimate::WanderEstimate(const Observations& observations, const Eigen::VectorXd& residual) {
  const std::vector<Stay> placements = placements_of(observations, residual);
  double blocks = 0.0;
  for (const Stay& placement : placements) blocks += placement.value.count;
  blocks_ = placements.empty() ? 1.0 : std::max(1.0, blocks / static_cast<double>(placements.size()));
  places_ = repeated(placements);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (i == 0 || places_[i].run != places_[i - 1].run) run_first_.push_back(static_cast<Eigen::Index>(i));
  }
  run_first_.push_back(static_cast<Eigen::Index>(places_.size()));
  const Eigen::MatrixXd means = means_of(places_, run_first_);
  const auto n = static_cast<Eigen::Index>(places_.size());
  if (static_cast<double>(n - means.cols()) < kLeastReplicated) return;

  // V = Σ w_k K_k, block by block; P = V⁻¹ − V⁻¹X (XᵀV⁻¹X)⁻¹ XᵀV⁻¹ takes the means off.
  weight_ = Eigen::MatrixXd::Zero(n, n);
  kernels_.assign(kComponents, {});
  for (std::size_t r = 0; r + 1 < run_first_.size(); ++r) {
    const Eigen::Index first = run_first_[r];
    const Eigen::Index m = run_first_[r + 1] - first;
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(m, m);
    for (std::size_t k = 0; k < kComponents; ++k) {
      Eigen::MatrixXd block(m, m);
      for (Eigen::Index i = 0; i < m; ++i) {
        for (Eigen::Index j = 0; j < m; ++j) {
          block(i, j) =
              kernel(k, places_[static_cast<std::size_t>(first + i)], places_[static_cast<std::size_t>(first + j)]);
        }
      }
      covariance += (k == kOfPlacement ? 1.0 : k == kOfVisit ? kVisitWeight : kWanderWeight) * block;
      kernels_[k].conservativeResize(first + m, std::max(m, kernels_[k].cols()));
      kernels_[k].block(first, 0, m, m) = block;
    }
    weight_.block(first, first, m, m) = base::solve_llt(covariance, Eigen::MatrixXd(Eigen::MatrixXd::Identity(m, m)));
  }
  const Eigen::MatrixXd weighted = weight_ * means;
  Eigen::MatrixXd normal = means.transpose() * weighted;
  normal.diagonal().array() += kRidge * normal.diagonal().mean();
  weight_ -= weighted * base::solve_llt(normal, Eigen::MatrixXd(weighted.transpose()));

  // tr(P K_k P K_l)
  std::vector<Eigen::MatrixXd> products(kComponents, Eigen::MatrixXd(n, n));
  for (std::size_t k = 0; k < kComponents; ++k) {
    for (std::size_t r = 0; r + 1 < run_first_.size(); ++r) {
      const Eigen::Index first = run_first_[r];
      const Eigen::Index m = run_first_[r + 1] - first;
      products[k].middleCols(first, m).noalias() = weight_.middleCols(first, m) * kernels_[k].block(first, 0, m, m);
    }
  }
  information_.resize(kComponents, kComponents);
  for (std::size_t k = 0; k < kComponents; ++k) {
    for (std::size_t l = 0; l <= k; ++l) {
      const double trace = products[k].cwiseProduct(products[l].transpose()).sum();
      information_(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) = trace;
      information_(static_cast<Eigen::Index>(l), static_cast<Eigen::Index>(k)) = trace;
    }
  }
}

bool WanderEstimate::is_for(const Observations& observations, const Eigen::VectorXd& residual) const {
  const std::vector<Stay> places = repeated(placements_of(observations, residual));
  return std::ranges::equal(places, places_, [](const Stay& a, const Stay& b) {
    return a.placement == b.placement && a.t_s.value == b.t_s.value;
  });
}

NoiseComponents WanderEstimate::estimate(const Observations& observations, const Eigen::VectorXd& residual,
                                         NoiseComponents nested) const {
  if (information_.size() == 0) return nested;
  const std::vector<Stay> places = repeated(placements_of(observations, residual));
  Eigen::VectorXd y(static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) y(static_cast<Eigen::Index>(i)) = places[i].value.value;
  const Eigen::VectorXd off = weight_ * y;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(kComponents);
  for (std::size_t r = 0; r + 1 < run_first_.size(); ++r) {
    const Eigen::Index first = run_first_[r];
    const Eigen::Index m = run_first_[r + 1] - first;
    for (std::size_t k = 0; k < kComponents; ++k) {
      squares(static_cast<Eigen::Index>(k)) +=
          off.segment(first, m).dot(kernels_[k].block(first, 0, m, m) * off.segment(first, m));
    }
  }
  const Eigen::VectorXd variance = least_squares_not_negative(information_, squares);
  const double of_blocks = nested.block * nested.block / blocks_;
  nested.placement = std::sqrt(std::max(0.0, variance(kOfPlacement) - of_blocks));
  nested.visit = std::sqrt(variance(kOfVisit));
  nested.wander.clear();
  for (std::size_t k = kFirstTau; k < kComponents; ++k) {
    const double of_tau = variance(static_cast<Eigen::Index>(k));
    if (of_tau > 0.0) nested.wander.push_back({kTaus_s[k - kFirstTau], std::sqrt(of_tau)});
  }
  return nested;
}

}  // namespace soak::calib::gap
