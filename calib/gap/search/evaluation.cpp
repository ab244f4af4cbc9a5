// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/evaluation.h"

#include <algorithm>

namespace soak::calib::gap {
namespace {

constexpr double kSensorGate = 0.01;  ///< chance from which a sensor by itself counts as hit, beside a named effect

struct Set {
  double p = 1.0;
  TermTest test;
};

/// The set of sensors with the least chance, among all, the gyros, the accelerometers and each alone.
Set best_set(const CandidateTest& test, double typical) {
  std::vector<std::vector<const TermTest*>> sets(3);
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!test.sensor[s] || test.sensor[s]->dof <= 0.0) continue;
    const TermTest* own = &*test.sensor[s];
    sets[0].push_back(own);
    sets[s < 3 ? 1 : 2].push_back(own);
    sets.push_back({own});
  }
  std::sort(sets.begin(), sets.end());
  sets.erase(std::unique(sets.begin(), sets.end()), sets.end());
  std::erase_if(sets, [](const auto& set) { return set.empty(); });
  Set best;
  for (const auto& set : sets) {
    TermTest together = pooled(set);
    const double p = std::min(1.0, p_value(together, typical) * static_cast<double>(sets.size()));
    if (p < best.p || best.test.dof == 0.0) best = {p, std::move(together)};
  }
  return best;
}

double worth(const TermTest& test, double typical) { return test.gain / moderated_heterogeneity(test, typical); }

void of_shared(const CandidateTest& test, const Candidate& candidate, double typical, double price, Standing& result) {
  result.p = p_value(*test.shared, typical);
  result.supporting_folds = test.shared->supporting_folds();
  result.judged_folds = test.shared->judged_folds();
  result.gain_beside_best_fold = test.shared->gain_beside_best_fold();
  result.gain = worth(*test.shared, typical);
  result.merit = result.gain - price * (test.shared->dof + static_cast<double>(candidate.shape_values.size()));
  for (const Sensor sensor : kSensors) {
    if (test.sensor[index_of(sensor)] && test.sensor[index_of(sensor)]->dof > 0.0) result.sensors.push_back(sensor);
  }
}

void of_sensors(const CandidateTest& test, const Candidate& candidate, double typical, double price, Standing& result) {
  const Set best = best_set(test, typical);
  result.p = best.p;
  result.supporting_folds = best.test.supporting_folds();
  result.judged_folds = best.test.judged_folds();
  result.gain_beside_best_fold = best.test.gain_beside_best_fold();
  result.merit = -price * static_cast<double>(candidate.shape_values.size());
  for (const Sensor sensor : kSensors) {
    const auto& own = test.sensor[index_of(sensor)];
    if (!own || own->dof <= 0.0) continue;
    const double gain = worth(*own, typical);
    if (gain <= price * own->dof || p_value(*own, typical) > kSensorGate) continue;
    result.sensors.push_back(sensor);
    result.gain += gain;
    result.merit += gain - price * own->dof;
  }
}

}  // namespace

CandidateTest test_candidate(const Residuals& residuals, const Candidate& candidate) {
  const bool by_run = candidate.folds == Folds::runs;
  CandidateTest result;
  TermScore together;
  double noise_dof = 0.0;
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (!residuals.sensor[s] || candidate.columns[s].size() == 0) continue;
    const TermScore score =
        score_term(*residuals.sensor[s], candidate.columns[s], by_run ? residuals.run_fold : residuals.level_fold,
                   by_run ? residuals.runs : residuals.levels);
    result.sensor[s] = test_term(score);
    result.sensor[s]->noise_dof = scatter_dof(residuals.noise[s]);
    noise_dof += scatter_dof(residuals.noise[s]);
    if (candidate.shared) together.add(score);
  }
  if (candidate.shared && !together.score.empty()) {
    result.shared = test_term(together);
    result.shared->noise_dof = noise_dof;
  }
  return result;
}

bool enough_folds(const Standing& standing) {
  return standing.judged_folds >= 2 && 2 * standing.supporting_folds >= standing.judged_folds &&
         standing.gain_beside_best_fold > 0.0;
}

Standing standing(const CandidateTest& test, const Candidate& candidate, double typical, double price) {
  Standing result;
  if (candidate.shared) {
    if (test.shared && test.shared->dof > 0.0) of_shared(test, candidate, typical, price, result);
  } else {
    of_sensors(test, candidate, typical, price, result);
  }
  return result;
}

}  // namespace soak::calib::gap
