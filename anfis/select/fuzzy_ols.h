// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"
#include "anfis/select/fuzzy_clustering.h"
#include "base/result.h"

namespace soak::anfis {

/// How fuzzy_ols() builds a model.
struct FuzzyOlsOptions {
  std::vector<int> clusters = {2, 4, 6, 8, 12, 16, 20};  ///< numbers of rules to try, rising, each 1..256
  ClusteringOptions clustering;  ///< of every try; its clusters and antecedents are not used, its seed is that of all
  double held_out_share = 0.25;  ///< share of groups or rows that judges what is left out; (0, 0.5]
  double consequent_threshold = 0.02;  ///< most that the terms dropped from a rule may together explain of it; [0, 1)

  /// Whether every option is in its range; the message names option, value and range.
  [[nodiscard]] base::Status validate() const;
};

/// A model on the way, fitted to the rows that are not held out.
struct FuzzyOlsStage {
  int rules = 0;
  std::vector<int> antecedents;  ///< inputs that premises ask about, rising
  int consequents = 0;           ///< free consequent parameters
  double fit_rmse = 0.0;         ///< of the rows fitted, units of y
  double held_out_rmse = 0.0;    ///< of those held out
};

/// One number of clusters that was tried: with all antecedents, then without those that are not needed.
struct FuzzyOlsCandidate {
  int clusters = 0;
  std::vector<FuzzyOlsStage> elimination;  ///< from all antecedents down to one
  std::vector<int> ranking;                ///< inputs in the order in which they were left out; the most needed last
  std::vector<double> log_separability;    ///< of the antecedents of each stage, from the clusters of that stage
  std::size_t chosen = 0;                  ///< stage with the fewest antecedents that is as good as the best
};

/// What orthogonal least squares says about the consequent of one rule.
struct ConsequentRanking {
  double offset = 0.0;         ///< error reduction ratio of the offset, which always stays
  std::vector<int> order;      ///< inputs by falling error reduction, each after those before it
  std::vector<double> ratios;  ///< error reduction ratios in that order
  std::size_t kept = 0;        ///< the first so many stay
};

/// How a model came about. Held-out errors chose the structure: they are no longer an unbiased judgement of it.
struct FuzzyOlsReport {
  std::vector<FuzzyOlsCandidate> candidates;   ///< in the order of options.clusters
  std::size_t chosen = 0;                      ///< the candidate with the fewest clusters that is as good as the best
  double threshold = 0.0;                      ///< consequent threshold that was used
  FuzzyOlsStage full;                          ///< the chosen candidate before compaction
  FuzzyOlsStage compact_antecedents;           ///< after that of the antecedents
  FuzzyOlsStage compact;                       ///< after that of the consequents
  std::vector<ConsequentRanking> consequents;  ///< of each rule of the model, from all rows
  ClusteringSummary clustering;                ///< of the last clustering, on all rows
  double train_rmse = 0.0;                     ///< of the model on all rows (shape_rmse), units of y

  [[nodiscard]] std::string one_line() const;
};

/// A model and how it came about.
struct FuzzyOls {
  Model model;
  FuzzyOlsReport report;
};

/// A compact Takagi-Sugeno model of order 1 from data [AH05 §5.4]: scatter rules from clusters instead of a grid, whose
/// rules are a power of the number of inputs. It is a warm start for train_hybrid() and train_variable_projection().
///
/// 1. Some rows are held out (whole groups where there are at least four). For each number of clusters:
///    cluster_takagi_sugeno(); then the antecedent whose absence leaves most of Fisher's interclass separability [eq.
///    5.37-5.38, see detail/compaction.h] is left out, the clusters are refined without it, and so on down to one.
///    Of these models the one with the fewest antecedents is taken whose held-out error is as good as the best, that
///    is, worse by at most one standard error of the paired difference.
/// 2. Of the numbers of clusters the least that is as good as the best, by the same rule. Numbers with more consequents
///    than 3/4 of the distinct rows fitted are left out.
/// 3. In every rule orthogonal least squares ranks the terms of the consequent [eq. 5.35-5.36, see
///    detail/compaction.h], and the last ones are dropped that together explain less than the threshold of what
///    the offset leaves. The threshold is lowered to 1/4, to 1/16 and to 0 where the held-out error asks for it, by the
///    same rule.
/// 4. The clusters are refined and the terms ranked on all rows with this structure.
///
/// A cluster's Gaussian becomes one Gaussian membership per antecedent. Inputs that are no antecedents have no
/// memberships, and every rule has kAny there. Takagi-Sugeno inference has no weight per rule, alpha_i / prod_j sqrt(2
/// pi sigma_ij^2), as the mixture of clusters has; without it the clusters' own local models would be mixed wrongly,
/// and so the consequents of all rules are solved for jointly by least squares over the firing strengths [eq. 5.12] at
/// every stage. Consequents are whitened for weights and groups as in train_hybrid().
///
/// Limits: the elimination follows where clusters lie, and does not take an antecedent back. A weak bend can be lost to
/// an input that only accompanies a strong one (1 of 12 seeded problems of ten inputs; the others came within 8 % of
/// their noise after hybrid learning). The stage errors in the report show it: compare numbers of clusters, or judge
/// inputs by subject knowledge.
///
/// The same arguments give the same bits. Refuses (bad_input) options out of range, data that validate() refuses, and
/// data with too few distinct rows for the least number of clusters or with numbers too large or small for least
/// squares.
[[nodiscard]] base::Result<FuzzyOls> fuzzy_ols(const TrainingData& data, const FuzzyOlsOptions& options = {});

}  // namespace soak::anfis
