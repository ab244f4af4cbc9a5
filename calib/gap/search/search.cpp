// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/search/search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "calib/gap/search/detail/residual_structure.h"
#include "calib/gap/search/score.h"

namespace soak::calib::gap {
namespace {

constexpr std::size_t kMostTerms = 3;
constexpr double kLeastShare = 0.05;
/// Share of the winner's merit from which another effect is told as nearly as good, and a twin of it.
constexpr double kRival = 0.8;
constexpr double kTwin = 0.6;

/// One shape of an effect, tested.
struct Contender {
  const Effect* effect = nullptr;
  Candidate candidate;
  CandidateTest test;
  Standing standing;
};

/// What a parameter costs: that of the Bayesian information criterion, with visits as what is independent.
double price_of(const Observations& observations) {
  std::size_t visits = 0;
  for (std::size_t i = 0; i < observations.rows.size(); ++i) {
    const auto& row = observations.rows[i];
    if (i == 0 || row.visit != observations.rows[i - 1].visit || row.run != observations.rows[i - 1].run) ++visits;
  }
  return std::log(static_cast<double>(std::max<std::size_t>(8, visits)));
}

std::vector<Contender> contenders_of(const CampaignModel& model, const Effect& effect) {
  std::vector<Contender> list;
  if (effect.missing(model.regressor_inputs())) return list;
  for (Candidate& candidate : effect.candidates(model.regressor_inputs())) {
    Contender contender;
    contender.effect = &effect;
    contender.test = test_candidate(model.residuals(), candidate);
    contender.candidate = std::move(candidate);
    list.push_back(std::move(contender));
  }
  return list;
}

/// Whether two candidates of one effect differ in the value of their shape only.
bool same_form(const Candidate& a, const Candidate& b) {
  for (std::size_t s = 0; s < kSensorCount; ++s) {
    if (a.columns[s].cols() != b.columns[s].cols()) return false;
  }
  return true;
}

double typical_heterogeneity(const std::vector<Contender>& list) {
  std::vector<double> values;
  for (const Contender& contender : list) {
    for (const auto& test : contender.test.sensor) {
      if (test && test->heterogeneity_dof > 0.0) values.push_back(test->heterogeneity);
    }
  }
  return values.empty() ? 1.0 : base::median(values);
}

bool plausible(const CampaignModel& model, const Contender& contender, double typical) {
  if (!contender.effect->plausible) return true;
  const auto can_be = [&](const TermTest& test) {
    return test.dof <= 0.0 ||
           contender.effect->plausible(model.regressor_inputs(), contender.candidate, test.parameters,
                                       test.covariance * moderated_heterogeneity(test, typical));
  };
  if (contender.test.shared) return can_be(*contender.test.shared);
  return std::all_of(contender.test.sensor.begin(), contender.test.sensor.end(),
                     [&](const auto& test) { return !test || can_be(*test); });
}

/// Judges all shapes and keeps the best of each effect, in the order of merit.
std::vector<Contender> ranked(const CampaignModel& model, std::vector<Contender> list, double typical, double price) {
  std::vector<Contender> best;
  for (Contender& contender : list) {
    contender.standing = standing(contender.test, contender.candidate, typical, price);
    if (!plausible(model, contender, typical)) contender.standing.merit = -std::numeric_limits<double>::infinity();
    if (best.empty() || best.back().effect != contender.effect) {
      best.push_back(std::move(contender));
    } else if (contender.standing.merit > best.back().standing.merit) {
      best.back() = std::move(contender);
    }
  }
  std::stable_sort(best.begin(), best.end(),
                   [](const Contender& a, const Contender& b) { return a.standing.merit > b.standing.merit; });
  return best;
}

/// The winner with a shape between those of the grid, if one fits better.
Contender refined(const CampaignModel& model, Contender winner, double typical, double price) {
  if (!winner.effect->of_shape || winner.candidate.shape_values.empty()) return winner;
  for (const double step : {std::sqrt(2.0), std::sqrt(std::sqrt(2.0))}) {
    const double middle = winner.candidate.shape_values.front();
    std::vector<Contender> list = {std::move(winner)};
    for (const double value : {middle / step, middle * step}) {
      for (Candidate& candidate : list.front().effect->of_shape(model.regressor_inputs(), value)) {
        if (!same_form(candidate, list.front().candidate)) continue;
        list.push_back({list.front().effect, {}, test_candidate(model.residuals(), candidate), {}});
        list.back().candidate = std::move(candidate);
      }
    }
    winner = std::move(ranked(model, std::move(list), typical, price).front());
  }
  return winner;
}

/// Effects of which no shape leaves anything beside the base.
std::vector<const Effect*> absorbed(const std::vector<Contender>& list) {
  std::vector<const Effect*> all;
  std::vector<const Effect*> shown;
  for (const Contender& contender : list) {
    if (all.empty() || all.back() != contender.effect) all.push_back(contender.effect);
    const auto shows = [](const auto& test) { return test && test->dof > 0.0; };
    if (std::any_of(contender.test.sensor.begin(), contender.test.sensor.end(), shows))
      shown.push_back(contender.effect);
  }
  std::erase_if(all,
                [&](const Effect* effect) { return std::find(shown.begin(), shown.end(), effect) != shown.end(); });
  return all;
}

/// Share of the RMS in the effect's sensors that parameters from the other folds take away.
double heldout_gain(const CampaignModel& model, const Contender& winner) {
  double gained = 0.0;
  double squares = 0.0;
  const auto add = [&](const TermTest& test) {
    for (const auto& fold : test.fold_gain) gained += fold.value_or(0.0);
  };
  if (winner.test.shared) add(*winner.test.shared);
  for (const Sensor sensor : winner.standing.sensors) {
    if (!winner.test.shared) add(*winner.test.sensor[index_of(sensor)]);
    squares += model.residuals().sensor[index_of(sensor)]->residual().squaredNorm();
  }
  return squares > 0.0 ? 1.0 - std::sqrt(std::max(0.0, 1.0 - gained / squares)) : 0.0;
}

NamedEffect describe(const CampaignModel& model, const Contender& winner, double typical, double price) {
  NamedEffect effect;
  effect.effect = winner.effect;
  effect.candidate = winner.candidate;
  effect.sensors = winner.standing.sensors;
  effect.merit = winner.standing.merit;
  effect.heldout_gain = heldout_gain(model, winner);
  double strongest = -1.0;
  double dof = winner.test.shared ? winner.test.shared->dof : 0.0;
  double gain = winner.test.shared ? winner.test.shared->gain : 0.0;
  for (const Sensor sensor : effect.sensors) {
    const std::size_t s = index_of(sensor);
    const TermTest& test = winner.test.shared ? *winner.test.shared : *winner.test.sensor[s];
    effect.parameters[s] = test.parameters;
    effect.covariance[s] = test.covariance * moderated_heterogeneity(test, typical);
    effect.meaning[s] = winner.effect->meaning(model.regressor_inputs(), winner.candidate, sensor);
    if (!winner.test.shared) {
      gain += test.gain;
      dof += test.dof;
    }
    effect.gain[s] = winner.test.sensor[s]->gain;
    if (winner.test.sensor[s]->gain <= strongest) continue;
    strongest = winner.test.sensor[s]->gain;
    effect.magnitude = winner.effect->magnitude(model.regressor_inputs(), winner.candidate, sensor, test.parameters);
  }
  effect.delta_bic = gain - price * dof;
  return effect;
}

/// The one of the greatest merit among those that pass the gates; null where none does.
const Contender* winner_of(const std::vector<Contender>& best, double tests) {
  const auto passes = [&](const Contender& contender) {
    return contender.standing.p * tests <= kGate && contender.standing.merit > 0.0 && contender.standing.enough_folds;
  };
  const auto first = std::find_if(best.begin(), best.end(), passes);
  return first == best.end() ? nullptr : &*first;
}

/// Odds of another effect against the winner: e to half the difference of their merits, which are differences of the
/// Bayesian information criterion (Kass and Raftery 1995, both as likely beforehand).
double odds_of(const Contender& other, const Contender& winner) {
  return std::exp(0.5 * (other.standing.merit - winner.standing.merit));
}

class Search {
 public:
  explicit Search(CampaignModel& model) : model_(model), price_(price_of(model.regressor_inputs().observations)) {}

  SearchResult run() {
    while (result_.effects.size() < kMostTerms) {
      auto effect = next_effect();
      if (!effect) break;
      const Eigen::VectorXd common = effect->parameters[index_of(effect->sensors.front())];
      model_.add_term(effect->candidate, effect->sensors, common);
      result_.effects.push_back(*std::move(effect));
    }
    result_.residual_structure = find_residual_structure(model_, result_.effects, typical_, price_);
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool taken(const Effect& effect) const {
    return std::any_of(result_.effects.begin(), result_.effects.end(),
                       [&](const NamedEffect& named) { return named.effect == &effect; });
  }

  /// What the first effect took out of those sensors.
  [[nodiscard]] double first_gain_in(const std::vector<Sensor>& sensors) const {
    double sum = 0.0;
    for (const Sensor sensor : sensors) sum += result_.effects.front().gain[index_of(sensor)];
    return sum;
  }

  std::optional<NamedEffect> next_effect() {
    std::vector<Contender> list;
    for (const Effect& effect : library()) {
      if (taken(effect)) continue;
      for (Contender& contender : contenders_of(model_, effect)) list.push_back(std::move(contender));
    }
    if (list.empty()) return std::nullopt;
    typical_ = typical_heterogeneity(list);
    const auto tests = static_cast<double>(list.size());
    if (result_.effects.empty()) {
      result_.candidates = list.size();
      result_.typical_heterogeneity = typical_;
    }
    if (result_.effects.empty()) result_.absorbed = absorbed(list);
    const std::vector<Contender> best = ranked(model_, std::move(list), typical_, price_);
    const Contender* found = winner_of(best, tests);
    if (found == nullptr) return std::nullopt;
    const Contender& winner = *found;
    const double p = std::min(1.0, winner.standing.p * tests);
    if (!result_.effects.empty() && winner.standing.gain < kLeastShare * first_gain_in(winner.standing.sensors)) {
      return std::nullopt;
    }
    NamedEffect effect = describe(model_, refined(model_, winner, typical_, price_), typical_, price_);
    effect.p_adjusted = p;
    for (const Contender& other : best) {
      const double near = are_twins(*other.effect, *winner.effect) ? kTwin : kRival;
      if (&other != &winner && other.standing.merit >= near * winner.standing.merit) {
        effect.rivals.push_back({other.effect, odds_of(other, winner)});
      }
    }
    return effect;
  }

  CampaignModel& model_;
  SearchResult result_;
  double price_ = 1.0;
  double typical_ = 1.0;
};

}  // namespace

SearchResult search(CampaignModel& model) { return Search(model).run(); }

std::optional<NamedEffect> best_shape(const CampaignModel& model, const Effect& effect) {
  const double price = price_of(model.regressor_inputs().observations);
  std::vector<Contender> list = contenders_of(model, effect);
  if (list.empty()) return std::nullopt;
  const double typical = typical_heterogeneity(list);
  const std::vector<Contender> best = ranked(model, std::move(list), typical, price);
  if (best.front().standing.sensors.empty()) return std::nullopt;
  return describe(model, refined(model, best.front(), typical, price), typical, price);
}

}  // namespace soak::calib::gap
