// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/detail/held_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "anfis/linear/group_whitening.h"
#include "base/random.h"

namespace soak::anfis::fuzzy {
namespace {

constexpr std::uint64_t kSplitStream = 0xE0;
constexpr std::size_t kLeastGroups = 4;

// Units (groups or rows) 0..count-1 that are held out.
std::vector<bool> drawn_units(std::size_t count, double share, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t unit) { return base::hashed(seed, kSplitStream, unit); });
  const auto wanted = static_cast<std::size_t>(std::lround(share * static_cast<double>(count)));
  std::vector<bool> drawn(count, false);
  for (std::size_t i = 0; i < std::clamp(wanted, std::size_t{1}, count - 1); ++i) {
    drawn[order[i]] = true;
  }
  return drawn;
}

std::vector<std::size_t> group_positions(const TrainingData& data) {
  const std::set<int> ids(data.group.begin(), data.group.end());
  std::vector<std::size_t> position;
  for (const int id : data.group) {
    position.push_back(static_cast<std::size_t>(std::distance(ids.begin(), ids.find(id))));
  }
  return position;
}

std::size_t group_count(const TrainingData& data) { return std::set<int>(data.group.begin(), data.group.end()).size(); }

}  // namespace

Split split(const TrainingData& data, double share, std::uint64_t seed) {
  std::vector<bool> held_out(data.rows());
  if (const std::size_t groups = group_count(data); groups >= kLeastGroups) {
    const std::vector<bool> drawn = drawn_units(groups, share, seed);
    const std::vector<std::size_t> position = group_positions(data);
    std::transform(position.begin(), position.end(), held_out.begin(), [&](std::size_t group) { return drawn[group]; });
  } else {
    held_out = drawn_units(data.rows(), share, seed);
  }
  std::vector<bool> fit = held_out;
  fit.flip();
  return {select_rows(data, fit), select_rows(data, held_out)};
}

Eigen::VectorXd unit_errors(const TrainingData& data, const Model& model) {
  std::vector<double> r = residuals(data, model);
  Eigen::VectorXd squares = Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
  const double variance = data.group_variance > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
  GroupWhitening(data.rows(), data.weight, data.group, variance).apply(squares);
  squares = squares.cwiseAbs2().eval();
  const std::size_t groups = group_count(data);
  if (groups < 2) {
    return squares;
  }
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(groups));
  const std::vector<std::size_t> position = group_positions(data);
  for (std::size_t k = 0; k < data.rows(); ++k) {
    sums(static_cast<Eigen::Index>(position[k])) += squares(static_cast<Eigen::Index>(k));
  }
  return sums;
}

Excess excess(const Eigen::VectorXd& errors, const Eigen::VectorXd& best) {
  const Eigen::VectorXd difference = errors - best;
  const auto units = static_cast<double>(difference.size());
  if (difference.size() < 2) {
    return {difference.sum(), 0.0};
  }
  const double variance = (difference.array() - difference.mean()).square().sum() / (units - 1.0);
  return {difference.sum(), std::sqrt(units * variance)};
}

std::size_t simplest_as_good(const std::vector<Eigen::VectorXd>& candidates) {
  const auto total = [](const Eigen::VectorXd& e) { return e.allFinite() ? e.sum() : HUGE_VAL; };
  const auto best = std::ranges::min_element(candidates, {}, total);
  const auto chosen = std::ranges::find_if(candidates, [&](const Eigen::VectorXd& errors) {
    if (&errors == &*best) return true;
    const Excess over_best = excess(errors, *best);
    return over_best.sum <= over_best.standard_error;
  });
  return static_cast<std::size_t>(chosen - candidates.begin());
}

}  // namespace soak::anfis::fuzzy
