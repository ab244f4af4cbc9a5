// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/noise/wander_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/linear/dense_solve.h"
#include "base/linear/products.h"

namespace soak::calib::gap {
namespace {

constexpr std::array<double, 5> kTaus_s = {300.0, 1500.0, 7500.0, 37500.0, 187500.0};
constexpr std::size_t kOfPlacement = 0;
constexpr std::size_t kOfVisit = 1;
constexpr std::size_t kFirstTau = 2;
constexpr std::size_t kComponents = kFirstTau + kTaus_s.size();
static_assert(kComponents <= kMostStates);
/// Variances for which the estimates are best, over that of placements.
constexpr double kVisitWeight = 0.25;
constexpr double kWanderWeight = 1.0 / static_cast<double>(kTaus_s.size());
constexpr double kMeansRidge = 1e-9;       ///< means of runs and of what they repeat depend on each other
constexpr double kLeastReplicated = 10.0;  ///< placements beyond the number of the means

/// A placement that another run repeats.
struct Place {
  Stay stay;
  std::vector<Eigen::Index> rows;  ///< of its blocks
};

std::vector<Place> places_of(const Observations& observations, const Eigen::VectorXd& residual) {
  std::vector<Place> places;
  std::map<int, std::set<int>> runs_of_cell;
  for (const Stay& stay : placements_of(observations, residual)) {
    places.push_back({stay, {}});
    runs_of_cell[stay.cell].insert(stay.run);
  }
  auto place = places.begin();
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    if (!std::isfinite(residual(i))) continue;
    while (place->stay.placement != observations.rows[static_cast<std::size_t>(i)].placement) ++place;
    place->rows.push_back(i);
  }
  std::erase_if(places, [&](const Place& p) { return runs_of_cell.at(p.stay.cell).size() < 2; });
  return places;
}

/// Mean of exp(−|Δt|/τ) over the blocks of one placement, or between two by their middles.
double correlation(const Observations& observations, const Place& a, const Place& b, double tau_s) {
  if (&a != &b) return std::exp(-std::abs(a.stay.t_s.value - b.stay.t_s.value) / tau_s);
  double sum = 0.0;
  for (const Eigen::Index i : a.rows) {
    for (const Eigen::Index j : a.rows) {
      const double apart_s =
          observations.rows[static_cast<std::size_t>(i)].t_s - observations.rows[static_cast<std::size_t>(j)].t_s;
      sum += std::exp(-std::abs(apart_s) / tau_s);
    }
  }
  return sum / static_cast<double>(a.rows.size() * a.rows.size());
}

/// One run's part of the equations: its places [first, first + m) of all.
struct RunPart {
  Eigen::Index first = 0;
  Eigen::MatrixXd weight;                           ///< W, the inverse of its covariance
  std::array<Eigen::MatrixXd, kComponents> kernel;  ///< K_k
  Eigen::MatrixXd columns;                          ///< X: what is free beside the noise
  Eigen::MatrixXd weighted;                         ///< A = W X
};

/// left x, where nearly all of x is zero.
Eigen::MatrixXd times_sparse(const Eigen::MatrixXd& left, const Eigen::MatrixXd& x) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(left.rows(), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      if (x(i, j) != 0.0) result.col(j) += x(i, j) * left.col(i);
    }
  }
  return result;
}

RunPart run_part(const Observations& observations, const std::vector<Place>& places, Eigen::Index first,
                 Eigen::Index m) {
  RunPart part;
  part.first = first;
  for (Eigen::MatrixXd& kernel : part.kernel) kernel.resize(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Place& a = places[static_cast<std::size_t>(first + i)];
      const Place& b = places[static_cast<std::size_t>(first + j)];
      part.kernel[kOfPlacement](i, j) = i == j ? 1.0 : 0.0;
      part.kernel[kOfVisit](i, j) = same_visit(a.stay, b.stay) ? 1.0 : 0.0;
      for (std::size_t k = kFirstTau; k < kComponents; ++k) {
        part.kernel[k](i, j) = correlation(observations, a, b, kTaus_s[k - kFirstTau]);
      }
      for (Eigen::MatrixXd& kernel : part.kernel) kernel(j, i) = kernel(i, j);
    }
  }
  Eigen::MatrixXd covariance = part.kernel[kOfPlacement] + kVisitWeight * part.kernel[kOfVisit];
  for (std::size_t k = kFirstTau; k < kComponents; ++k) covariance += kWanderWeight * part.kernel[k];
  part.weight = base::solve_llt(covariance, Eigen::MatrixXd(Eigen::MatrixXd::Identity(m, m)));
  return part;
}

/// Columns of runs, of cells, and of the nuisances: all that is free beside the noise.
Eigen::MatrixXd free_columns(const std::vector<Place>& places, const Eigen::MatrixXd& nuisances) {
  std::map<int, Eigen::Index> runs;
  std::map<int, Eigen::Index> cells;
  for (const Place& place : places) {
    runs.try_emplace(place.stay.run, static_cast<Eigen::Index>(runs.size()));
    cells.try_emplace(place.stay.cell, static_cast<Eigen::Index>(cells.size()));
  }
  const auto n = static_cast<Eigen::Index>(places.size());
  const auto of_runs = static_cast<Eigen::Index>(runs.size());
  const Eigen::Index means = of_runs + static_cast<Eigen::Index>(cells.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n, means + nuisances.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    const Place& place = places[static_cast<std::size_t>(i)];
    columns(i, runs.at(place.stay.run)) = 1.0;
    columns(i, of_runs + cells.at(place.stay.cell)) = 1.0;
    columns.row(i).tail(nuisances.cols()) = nuisances(place.rows, Eigen::all).colwise().mean();
  }
  return columns;
}

/// Adds one run's part of A_kl = tr(P K_k P K_l), P = W − W X (XᵀWX)⁻¹ XᵀW, where no other run takes part, and to
/// `shared` its part of XᵀW K_k W X, by which runs hang together. `inverse`: (XᵀWX)⁻¹.
void add_information(const RunPart& run, const Eigen::MatrixXd& inverse, Eigen::MatrixXd& information,
                     std::array<Eigen::MatrixXd, kComponents>& shared) {
  std::array<Eigen::MatrixXd, kComponents> turned;  // K_k W
  std::array<Eigen::MatrixXd, kComponents> spread;  // W K_k A
  for (std::size_t k = 0; k < kComponents; ++k) {
    turned[k] = base::product(run.kernel[k], run.weight);
    const Eigen::MatrixXd seen_by = times_sparse(turned[k], run.columns);  // K_k A
    spread[k] = base::product(run.weight, seen_by);
    shared[k] += times_sparse(spread[k].transpose(), run.columns);
    const Eigen::MatrixXd through = base::product(seen_by, inverse);
    for (std::size_t l = 0; l <= k; ++l) {
      information(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) +=
          turned[k].cwiseProduct(turned[l].transpose()).sum() - 2.0 * through.cwiseProduct(spread[l]).sum();
    }
  }
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

struct WanderEstimate::Impl {
  const Observations& observations;
  std::vector<Place> places;
  std::vector<RunPart> runs;
  double blocks = 0.0;          ///< of a placement, in the mean
  Eigen::MatrixXd inverse;      ///< (XᵀWX)⁻¹
  Eigen::MatrixXd information;  ///< A; empty where runs repeat too little
};

WanderEstimate::WanderEstimate(WanderEstimate&&) noexcept = default;
WanderEstimate& WanderEstimate::operator=(WanderEstimate&&) noexcept = default;
WanderEstimate::~WanderEstimate() = default;

WanderEstimate::WanderEstimate(const Observations& observations, const Eigen::VectorXd& residual,
                               const Eigen::MatrixXd& nuisances)
    : impl_(std::make_unique<Impl>(Impl{observations, places_of(observations, residual), {}, 0.0, {}, {}})) {
  const std::vector<Place>& places = impl_->places;
  const auto n = static_cast<Eigen::Index>(places.size());
  const Eigen::MatrixXd columns = free_columns(places, nuisances);
  const Eigen::Index f = columns.cols();
  if (static_cast<double>(n - f) < kLeastReplicated) return;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(f, f);
  for (Eigen::Index first = 0, i = 0; i < n; ++i) {
    const Stay& stay = places[static_cast<std::size_t>(i)].stay;
    impl_->blocks += stay.value.count / static_cast<double>(n);
    if (i + 1 < n && places[static_cast<std::size_t>(i + 1)].stay.run == stay.run) continue;
    RunPart run = run_part(observations, places, first, i + 1 - first);
    run.columns = columns.middleRows(first, i + 1 - first);
    run.weighted = times_sparse(run.weight, run.columns);
    normal += times_sparse(run.weighted.transpose(), run.columns);
    impl_->runs.push_back(std::move(run));
    first = i + 1;
  }
  normal.diagonal().array() += kMeansRidge * normal.diagonal().mean();
  impl_->inverse = base::solve_llt(normal, Eigen::MatrixXd(Eigen::MatrixXd::Identity(f, f)));
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kComponents, kComponents);
  std::array<Eigen::MatrixXd, kComponents> coupled;
  coupled.fill(Eigen::MatrixXd::Zero(f, f));
  for (const RunPart& run : impl_->runs) add_information(run, impl_->inverse, information, coupled);
  for (Eigen::MatrixXd& of_component : coupled) of_component = base::product(impl_->inverse, of_component);
  for (std::size_t k = 0; k < kComponents; ++k) {
    for (std::size_t l = 0; l <= k; ++l) {
      double& entry = information(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l));
      entry += coupled[k].cwiseProduct(coupled[l].transpose()).sum();
      information(static_cast<Eigen::Index>(l), static_cast<Eigen::Index>(k)) = entry;
    }
  }
  impl_->information = std::move(information);
}

bool WanderEstimate::is_for(const Eigen::VectorXd& residual) const {
  return std::ranges::equal(places_of(impl_->observations, residual), impl_->places,
                            [](const Place& a, const Place& b) { return a.rows == b.rows; });
}

std::optional<NoiseComponents> WanderEstimate::of(const Eigen::VectorXd& residual, NoiseComponents nested) const {
  if (impl_->information.size() == 0) return std::nullopt;
  const std::vector<Place> places = places_of(impl_->observations, residual);
  Eigen::VectorXd y(static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) y(static_cast<Eigen::Index>(i)) = places[i].stay.value.value;
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(impl_->inverse.rows());
  for (const RunPart& run : impl_->runs) wanted += run.weighted.transpose() * y.segment(run.first, run.weight.rows());
  const Eigen::VectorXd coefficients = impl_->inverse * wanted;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(kComponents);  // yᵀP K_k P y
  for (const RunPart& run : impl_->runs) {
    const Eigen::VectorXd off = run.weight * y.segment(run.first, run.weight.rows()) - run.weighted * coefficients;
    for (std::size_t k = 0; k < kComponents; ++k) squares(static_cast<Eigen::Index>(k)) += off.dot(run.kernel[k] * off);
  }
  // What the blocks add to a placement's mean is known.
  squares -= impl_->information.col(kOfPlacement) * (nested.block * nested.block / impl_->blocks);
  const Eigen::VectorXd variance = least_squares_not_negative(impl_->information, squares);
  nested.placement = std::sqrt(variance(kOfPlacement));
  nested.visit = std::sqrt(variance(kOfVisit));
  nested.wander.clear();
  for (std::size_t k = kFirstTau; k < kComponents; ++k) {
    const double of_tau = variance(static_cast<Eigen::Index>(k));
    if (of_tau > 0.0) nested.wander.push_back({kTaus_s[k - kFirstTau], std::sqrt(of_tau)});
  }
  return nested;
}

}  // namespace soak::calib::gap
