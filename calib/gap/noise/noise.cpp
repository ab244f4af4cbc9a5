// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/noise/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/instruction_set.h"

namespace soak::calib::gap {
namespace {

constexpr double kEnoughReplicates = 10.0;  ///< degrees of freedom from which replicates say how visits scatter

/// Sum of squares about group means, pooled.
struct Pool {
  double squares = 0.0;
  double dof = 0.0;

  [[nodiscard]] double variance() const { return dof > 0.0 ? squares / dof : 0.0; }
};

/// A deviation of a part from its whole (a block from its placement...), and which of them are replicates.
struct Deviation {
  std::pair<int, int> replicate;
  double value;
};

/// `freedom`: share of the deviations within one whole that are free, as they sum to zero there. Without replicates the
/// deviations count as they are.
Pool pool(const std::vector<Deviation>& deviations, double freedom, bool replicated) {
  std::unordered_map<std::int64_t, Mean> means;
  const auto key = [](const Deviation& d) { return (std::int64_t{d.replicate.first} << 32) + d.replicate.second; };
  for (const Deviation& d : deviations) means[key(d)].add(d.value);
  Pool result;
  for (const Deviation& d : deviations) {
    const Mean about = replicated ? means.at(key(d)) : Mean{};
    if (replicated && about.count < 2.0) continue;
    result.squares += (d.value - about.value) * (d.value - about.value);
    result.dof += replicated ? (about.count - 1.0) / about.count * freedom : freedom;
  }
  return result;
}

double mean_count(const std::vector<Stay>& stays) {
  double sum = 0.0;
  for (const Stay& stay : stays) sum += stay.value.count;
  return stays.empty() ? 1.0 : std::max(1.0, sum / static_cast<double>(stays.size()));
}

/// Four numbers in one register, or in two where the processor has no wider ones.
using Four [[gnu::vector_size(4 * sizeof(double))]] = double;

/// One row of four columns that are filtered together.
struct FourColumns {
  Four of;
};

/// Columns that are filtered at a time, in fours: what a row says waits for the one before, so that many take hardly
/// longer than few.
constexpr std::size_t kMany = 16;
constexpr std::size_t kSome = 8;
constexpr std::size_t kFew = 4;

template <std::size_t Width>
using RowOfColumns = std::array<FourColumns, Width / 4>;

/// One row of `Width` columns: their states fade, each reading is less what they say, and corrects them.
template <std::size_t Width>
SOAK_INLINE void filter_row(std::size_t states, const double* fade, const double* gain, double scale,
                            std::array<RowOfColumns<Width>, kMostStates>& state, RowOfColumns<Width>& row) {
  RowOfColumns<Width> said{};
  for (std::size_t k = 0; k < states; ++k) {
#pragma GCC unroll 4
    for (std::size_t c = 0; c < said.size(); ++c) {
      state[k][c].of *= fade[k];
      said[c].of += state[k][c].of;
    }
  }
#pragma GCC unroll 4
  for (std::size_t c = 0; c < said.size(); ++c) row[c].of -= said[c].of;
  for (std::size_t k = 0; k < states; ++k) {
#pragma GCC unroll 4
    for (std::size_t c = 0; c < said.size(); ++c) state[k][c].of += gain[k] * row[c].of;
  }
  for (FourColumns& four : row) four.of *= scale;
}

}  // namespace

bool same_visit(const Stay& a, const Stay& b) { return a.run == b.run && a.visit == b.visit; }

std::vector<Stay> placements_of(const Observations& observations, const Eigen::VectorXd& values) {
  std::vector<Stay> placements;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = values(static_cast<Eigen::Index>(i));
    if (!std::isfinite(value)) continue;
    const Observation& row = observations.rows[i];
    if (placements.empty() || placements.back().placement != row.placement) {
      placements.push_back({row.run, row.visit, row.placement, row.cell, {}, {}});
    }
    placements.back().t_s.add(row.t_s);
    placements.back().value.add(value);
  }
  return placements;
}

std::vector<Stay> visits_of(const std::vector<Stay>& placements) {
  std::vector<Stay> visits;
  for (const Stay& placement : placements) {
    if (visits.empty() || !same_visit(visits.back(), placement)) {
      visits.push_back(placement);
      visits.back().t_s = visits.back().value = {};
    }
    Stay& visit = visits.back();
    visit.cell = std::min(visit.cell, placement.cell);
    visit.t_s.add(placement.t_s.value);
    visit.value.add(placement.value.value);
  }
  return visits;
}

NoiseComponents noise_components(const Observations& observations, const Eigen::VectorXd& residual) {
  const std::vector<Stay> placement_means = placements_of(observations, residual);
  const std::vector<Stay> visit_means = visits_of(placement_means);
  std::vector<Stay> run_means;
  for (const Stay& visit : visit_means) {
    if (run_means.empty() || run_means.back().run != visit.run) run_means.push_back({.run = visit.run});
    run_means.back().value.add(visit.value.value);
  }
  const double blocks = mean_count(placement_means);
  const double placements = mean_count(visit_means);
  const double visits = mean_count(run_means);

  // What each part differs from its whole by; rows, placements, visits and runs follow each other in one order.
  std::vector<Deviation> within_placement;
  auto placement_mean = placement_means.begin();
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const double value = residual(static_cast<Eigen::Index>(i));
    if (!std::isfinite(value)) continue;
    const Observation& row = observations.rows[i];
    while (placement_mean->placement != row.placement) ++placement_mean;
    within_placement.push_back({{row.cell, row.block}, value - placement_mean->value.value});
  }
  std::vector<Deviation> within_visit;
  auto visit_mean = visit_means.begin();
  for (const Stay& stay : placement_means) {
    while (!same_visit(*visit_mean, stay)) ++visit_mean;
    within_visit.push_back({{stay.cell, 0}, stay.value.value - visit_mean->value.value});
  }
  std::vector<Deviation> within_run;
  auto run_mean = run_means.begin();
  for (const Stay& stay : visit_means) {
    while (run_mean->run != stay.run) ++run_mean;
    within_run.push_back({{stay.cell, 0}, stay.value.value - run_mean->value.value});
  }

  const auto pools = [&](bool replicated) {
    return std::array{pool(within_placement, (blocks - 1.0) / blocks, replicated),
                      pool(within_visit, (placements - 1.0) / placements, replicated),
                      pool(within_run, (visits - 1.0) / visits, replicated)};
  };
  auto [block, placement, visit] = pools(true);
  NoiseComponents noise;
  noise.replicated = visit.dof >= kEnoughReplicates;
  if (!noise.replicated) std::tie(block, placement, visit) = std::tuple_cat(pools(false));
  noise.block_dof = block.dof;
  noise.placement_dof = placement.dof;
  noise.visit_dof = visit.dof;
  const double of_block = block.variance();
  const double of_placement = std::max(0.0, placement.variance() - of_block / blocks);
  const double of_visit = std::max(0.0, visit.variance() - (of_placement + of_block / blocks) / placements);
  noise.block = std::sqrt(of_block);
  noise.placement = std::sqrt(of_placement);
  noise.visit = std::sqrt(of_visit);
  return noise;
}

double variance_about_mean(const Observations& observations, const std::vector<GaussMarkov>& wander, int run) {
  double sum = 0.0;
  for (const GaussMarkov& process : wander) {
    double earlier = 0.0;  // of all rows so far, the sum of their correlations with this one
    double pairs = 0.0;
    double rows = 0.0;
    const Observation* before = nullptr;
    for (const Observation& row : observations.rows) {
      if (row.run != run) continue;
      if (before != nullptr)
        earlier = (earlier + 1.0) * std::exp(-std::max(0.0, row.t_s - before->t_s) / process.tau_s);
      pairs += 2.0 * earlier + 1.0;
      rows += 1.0;
      before = &row;
    }
    if (rows > 0.0) sum += process.sigma * process.sigma * (1.0 - pairs / (rows * rows));
  }
  return sum;
}

Whitening::Whitening(const Observations& observations, Sensor sensor, const NoiseComponents& noise,
                     const std::vector<bool>& keep) {
  const std::size_t s = index_of(sensor);
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const SensorStatistics& statistics = observations.rows[i].sensor[s];
    if (keep[i] && statistics.count > 0 && std::isfinite(statistics.mean))
      rows_.push_back(static_cast<Eigen::Index>(i));
  }
  filter_runs(observations, noise);
}

/// States: the placement's, the visit's, and one for each Gauss-Markov process; their covariance goes from row to row.
void Whitening::filter_runs(const Observations& observations, const NoiseComponents& noise) {
  const auto n = static_cast<Eigen::Index>(noise.wander.size()) + 2;
  States variance(n);
  variance(0) = noise.placement * noise.placement;
  variance(1) = noise.visit * noise.visit;
  for (Eigen::Index k = 2; k < n; ++k) variance(k) = std::pow(noise.wander[static_cast<std::size_t>(k) - 2].sigma, 2);
  // Without any noise the filter would divide by 0.
  const double own = std::max(noise.block * noise.block, 1e-12 * variance.sum() + 1e-300);
  Covariance covariance = Covariance::Zero(n, n);
  steps_.reserve(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Observation& row = observations.rows[static_cast<std::size_t>(rows_[i])];
    const Observation* before = i > 0 ? &observations.rows[static_cast<std::size_t>(rows_[i - 1])] : nullptr;
    Step step;
    step.fade = States::Zero(n);
    if (before != nullptr && before->run == row.run) {
      step.fade(0) = before->placement == row.placement ? 1.0 : 0.0;
      step.fade(1) = before->visit == row.visit ? 1.0 : 0.0;
      for (Eigen::Index k = 2; k < n; ++k) {
        step.fade(k) =
            std::exp(-std::max(0.0, row.t_s - before->t_s) / noise.wander[static_cast<std::size_t>(k) - 2].tau_s);
      }
    }
    covariance = step.fade.asDiagonal() * covariance * step.fade.asDiagonal();
    covariance.diagonal().array() += variance.array() * (1.0 - step.fade.array().square());
    const States with_row = covariance.rowwise().sum();  // the row reads the sum of all states
    const double beyond = with_row.sum() + own;
    step.gain = with_row / beyond;
    covariance -= step.gain * with_row.transpose();
    step.scale = 1.0 / std::sqrt(beyond);
    steps_.push_back(std::move(step));
  }
}

template <std::size_t Width>
SOAK_INLINE void Whitening::filter_columns(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index column,
                                           Eigen::Index first_row, Eigen::MatrixXd& result) const {
  const auto count = std::min(Width, static_cast<std::size_t>(columns.cols() - column));
  const auto rows = static_cast<std::size_t>(result.rows());
  const auto stride = static_cast<std::size_t>(columns.outerStride());
  std::array<RowOfColumns<Width>, kMostStates> state{};
  RowOfColumns<Width> row{};
  std::array<double, Width> reading{};
  const double* from = columns.data() + column * columns.outerStride();
  double* to = result.data() + column * result.rows();
  for (std::size_t i = 0; i < rows; ++i) {
    const auto at = static_cast<std::size_t>(first_row) + i;
    const Step& step = steps_[at];
    for (std::size_t c = 0; c < count; ++c) reading[c] = from[c * stride + static_cast<std::size_t>(rows_[at])];
    std::memcpy(row.data(), reading.data(), sizeof reading);
    filter_row<Width>(static_cast<std::size_t>(step.fade.size()), step.fade.data(), step.gain.data(), step.scale, state,
                      row);
    std::memcpy(reading.data(), row.data(), sizeof reading);
    for (std::size_t c = 0; c < count; ++c) to[c * rows + i] = reading[c];
  }
}

SOAK_CLONES void Whitening::filter(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index first_row,
                                   Eigen::MatrixXd& result) const {
  for (Eigen::Index column = 0; column < columns.cols(); column += static_cast<Eigen::Index>(kMany)) {
    const auto left = static_cast<std::size_t>(columns.cols() - column);
    if (left > kSome) {
      filter_columns<kMany>(columns, column, first_row, result);
    } else if (left > kFew) {
      filter_columns<kSome>(columns, column, first_row, result);
    } else {
      filter_columns<kFew>(columns, column, first_row, result);
    }
  }
}

double Whitening::log_determinant() const {
  double sum = 0.0;
  for (const Step& step : steps_) sum -= 2.0 * std::log(step.scale);
  return sum;
}

Eigen::MatrixXd Whitening::apply(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  return apply_in_run(columns, 0, static_cast<Eigen::Index>(rows_.size()));
}

Eigen::MatrixXd Whitening::apply_in_run(const Eigen::Ref<const Eigen::MatrixXd>& columns, Eigen::Index first,
                                        Eigen::Index count) const {
  Eigen::MatrixXd result(count, columns.cols());
  filter(columns, first, result);
  return result;
}

}  // namespace soak::calib::gap
