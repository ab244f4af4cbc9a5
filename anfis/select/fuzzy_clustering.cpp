// SPDX-License-Identifier: Apache-2.0
#include "anfis/select/fuzzy_clustering.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "anfis/select/detail/gath_geva.h"
#include "anfis/train/detail/training_steps.h"
#include "base/random.h"

namespace soak::anfis {
namespace {

// Streams of the seed: one per start.
constexpr std::uint64_t kStartStream = 0xF0;

base::Status check_antecedents(const std::vector<int>& antecedents, std::size_t inputs) {
  const bool rising =
      std::adjacent_find(antecedents.begin(), antecedents.end(), std::greater_equal<>()) == antecedents.end();
  if (!rising ||
      (!antecedents.empty() && (antecedents.front() < 0 || static_cast<std::size_t>(antecedents.back()) >= inputs))) {
    return base::bad_input(fmt::format("antecedents must be rising numbers of inputs, 0..{}", inputs - 1),
                           "antecedents");
  }
  return {};
}

base::Status check(const TrainingData& data, const ClusteringOptions& options, std::size_t clusters) {
  if (auto status = options.validate(); !status) return status;
  if (auto status = validate(data, clusters); !status) return status;
  return check_antecedents(options.antecedents, data.inputs);
}

ClusteringOptions with_antecedents(const ClusteringOptions& options, std::size_t inputs) {
  ClusteringOptions complete = options;
  if (complete.antecedents.empty()) {
    complete.antecedents.resize(inputs);
    std::iota(complete.antecedents.begin(), complete.antecedents.end(), 0);
  }
  return complete;
}

// Clusters in rising order of their centres along the first antecedent; scales as given.
Clustering arranged(Clustering clustering, const fuzzy::Scales& scales, int first_antecedent) {
  std::vector<Eigen::Index> order(clustering.clusters.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto position = [&](Eigen::Index i) {
    return clustering.clusters[static_cast<std::size_t>(i)].centre(first_antecedent);
  };
  std::ranges::stable_sort(order, {}, position);
  Clustering result;
  result.inputs = scales.inputs;
  result.output = scales.output;
  for (const Eigen::Index i : order) result.clusters.push_back(clustering.clusters[static_cast<std::size_t>(i)]);
  result.memberships = clustering.memberships(Eigen::all, order);
  result.summary = std::move(clustering.summary);
  return result;
}

}  // namespace

base::Status ClusteringOptions::validate() const {
  return training::check_options({{
      {"clusters", static_cast<double>(clusters), clusters >= 1 && clusters <= static_cast<int>(kMostMemberships),
       "1..256"},
      {"input_variance_floor", input_variance_floor, input_variance_floor > 0.0 && input_variance_floor <= 1.0,
       "above 0, at most 1"},
      {"output_variance_floor", output_variance_floor, output_variance_floor > 0.0 && output_variance_floor <= 1.0,
       "above 0, at most 1"},
      {"iterations", static_cast<double>(iterations), iterations >= 1, "at least 1"},
      {"tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "between 0 and 1"},
      {"starts", static_cast<double>(starts), starts >= 1, "at least 1"},
  }});
}

std::string_view name(ClusteringStop stop) {
  return stop == ClusteringStop::converged ? "converged" : "iterations done";
}

std::string ClusteringSummary::one_line() const {
  return fmt::format("{} after {} iterations of start {}, {} clusters dropped, log-likelihood {:.6g} per row",
                     name(stop), log_likelihood.size(), start, dropped, log_likelihood.back());
}

base::Result<Clustering> cluster_takagi_sugeno(const TrainingData& data, const ClusteringOptions& options) {
  if (auto status = check(data, options, static_cast<std::size_t>(std::max(options.clusters, 1))); !status) {
    return base::forward_error(status);
  }
  const ClusteringOptions complete = with_antecedents(options, data.inputs);
  const fuzzy::Scales scales = fuzzy::scales_of(data);
  const fuzzy::ScaledRows rows = fuzzy::scaled_rows(data, scales);
  const fuzzy::VarianceFloors floors = fuzzy::variance_floors(rows, complete);
  Clustering best;
  for (int start = 1; start <= complete.starts; ++start) {
    base::Random random(complete.seed, kStartStream + static_cast<std::uint64_t>(start));
    Clustering next = fuzzy::alternate(
        rows, fuzzy::seeded_memberships(rows, complete.antecedents, complete.clusters, random), complete, floors);
    next.summary.start = start;
    if (start == 1 || next.summary.log_likelihood.back() > best.summary.log_likelihood.back()) best = std::move(next);
  }
  return arranged(std::move(best), scales, complete.antecedents.front());
}

base::Result<Clustering> refine_clusters(const TrainingData& data, const Clustering& initial,
                                         const ClusteringOptions& options) {
  if (auto status = check(data, options, initial.clusters.size()); !status) return base::forward_error(status);
  const ClusteringOptions complete = with_antecedents(options, data.inputs);
  const fuzzy::Scales scales{initial.inputs, initial.output};
  const fuzzy::ScaledRows rows = fuzzy::scaled_rows(data, scales);
  const Eigen::MatrixXd closeness = fuzzy::log_closeness(rows, initial.clusters, complete.antecedents);
  Clustering refined = fuzzy::alternate(rows, fuzzy::partition(closeness, rows.weight).memberships, complete,
                                        fuzzy::variance_floors(rows, complete));
  return arranged(std::move(refined), scales, complete.antecedents.front());
}

}  // namespace soak::anfis
