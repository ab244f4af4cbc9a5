// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/next_experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calib/gap/experiment/detail/discrimination.h"

namespace soak::calib::gap {
namespace {

constexpr double kTells = 1.0;                       ///< sigma from which an experiment can tell two effects
constexpr std::string_view kTurning = "earth_rate";  ///< what a turn of the fixture changes

/// An effect and those that it may be mistaken for, each as it fits the runs made.
struct Question {
  const NamedEffect& winner;
  std::vector<NamedEffect> rivals;
  std::vector<std::string_view> unpredicted;  ///< rivals that say nothing of the next run
  std::vector<const NamedEffect*> beside;     ///< other effects, in the base with either
};

/// An action with what it adds between the winner and each rival.
struct Answer {
  const Action* action = nullptr;
  double hours = 0.0;
  std::vector<double> squares;
};

bool predicts(const NamedEffect& effect) {
  const auto& columns = effect.candidate.columns;
  return effect.candidate.folds == Folds::runs &&
         std::any_of(columns.begin(), columns.end(), [](const auto& own) { return own.size() > 0; });
}

/// Temperature of the plateau at which winner and rival differ most, each about its own mean.
double spot_c(const CampaignModel& model, const NamedEffect& winner, const NamedEffect& rival) {
  const Observations& observations = model.regressor_inputs().observations;
  const auto rows = static_cast<Eigen::Index>(observations.rows.size());
  const auto of = [&](const NamedEffect& effect, Sensor sensor) -> Eigen::VectorXd {
    const std::size_t s = index_of(sensor);
    if (std::find(effect.sensors.begin(), effect.sensors.end(), sensor) == effect.sensors.end()) {
      return Eigen::VectorXd::Zero(rows);
    }
    return effect.candidate.columns[s] * effect.parameters[s];
  };
  Eigen::VectorXd differs = Eigen::VectorXd::Zero(observations.level_count());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(observations.level_count());
  for (const Sensor sensor : kSensors) {
    if (!model.residuals().sensor[index_of(sensor)]) continue;
    Eigen::VectorXd off = of(winner, sensor) - of(rival, sensor);
    off.array() -= off.mean();
    const double block = std::max(1e-300, model.residuals().noise[index_of(sensor)].block);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const int level = observations.rows[static_cast<std::size_t>(i)].level;
      differs(level) += off(i) * off(i) / (block * block);
      count(level) += 1.0;
    }
  }
  Eigen::Index spot = 0;
  differs.cwiseQuotient(count.cwiseMax(1.0)).maxCoeff(&spot);
  return observations.level_c[static_cast<std::size_t>(spot)];
}

void answer(const ExperimentBatch& batch, const Question& question, std::vector<Answer>& answers) {
  const std::size_t first = answers.size();
  for (std::size_t a = 0; a < batch.actions().size(); ++a) {
    answers.push_back({&batch.actions()[a], batch.hours()[a], {}});
  }
  for (const NamedEffect& rival : question.rivals) {
    const std::vector<double> squares = batch.gained(question.winner, rival, question.beside);
    for (std::size_t a = 0; a < squares.size(); ++a) answers[first + a].squares.push_back(squares[a]);
  }
}

/// The least over the rivals that count; nothing where none does.
std::optional<double> least_of(const Answer& answer, const std::vector<bool>& counts) {
  std::optional<double> least;
  for (std::size_t r = 0; r < counts.size(); ++r) {
    if (counts[r]) least = std::min(least.value_or(answer.squares[r]), answer.squares[r]);
  }
  return least;
}

/// The rivals that one action tells together, the stronger ones before.
std::vector<bool> told(const std::vector<Answer>& answers, std::size_t rivals) {
  std::vector<bool> result(rivals, false);
  for (std::size_t r = 0; r < rivals; ++r) {
    result[r] = true;
    result[r] = std::any_of(answers.begin(), answers.end(), [&](const Answer& answer) {
      return least_of(answer, result).value_or(0.0) >= kTells * kTells;
    });
  }
  return result;
}

/// `counts`: rivals that count.
std::vector<Experiment> ranked(const std::vector<Answer>& answers, const std::vector<bool>& counts) {
  std::vector<Experiment> list;
  for (const Answer& answer : answers) {
    const double sigma = std::sqrt(least_of(answer, counts).value_or(0.0));
    list.push_back({answer.action->name, answer.action->procedure, answer.hours, sigma, ""});
  }
  const auto per_hour = [](const Experiment& e) { return e.hours > 0.0 ? e.sigma * e.sigma / e.hours : 0.0; };
  std::stable_sort(list.begin(), list.end(),
                   [&](const Experiment& a, const Experiment& b) { return per_hour(a) > per_hour(b); });
  return list;
}

bool is_asked_of(const Question& question, std::string_view name) {
  return question.winner.effect->name == name ||
         std::any_of(question.rivals.begin(), question.rivals.end(),
                     [&](const NamedEffect& rival) { return rival.effect->name == name; });
}

/// What the first experiment that can tell anything does.
std::string promise(const Question& question, const std::vector<Experiment>& experiments,
                    const std::vector<std::string_view>& from) {
  constexpr double kSure = 3.0;
  const auto best = std::find_if(experiments.begin(), experiments.end(),
                                 [](const Experiment& experiment) { return experiment.sigma >= kTells; });
  std::string text = fmt::format("{}: tells {} from {} at {:.1f} sigma, {:.0f} h of chamber time", best->action,
                                 question.winner.effect->name, fmt::join(from, ", "), best->sigma,
                                 std::max(1.0, std::round(best->hours)));
  if (best->sigma < kSure) {
    text += fmt::format(", {:.0f} such runs for {:.0f} sigma", std::ceil(std::pow(kSure / best->sigma, 2.0)), kSure);
  }
  return best->procedure.empty()
             ? text
             : text + fmt::format(" (a copy of your procedure, changed as procedures/{}.toml shows)", best->procedure);
}

std::string sentence(const Question& question, const std::vector<Experiment>& experiments,
                     const std::vector<bool>& is_told) {
  std::vector<std::string_view> from;
  std::vector<std::string_view> open = question.unpredicted;
  for (std::size_t r = 0; r < is_told.size(); ++r) {
    (is_told[r] ? from : open).push_back(question.rivals[r].effect->name);
  }
  std::string text = from.empty() ? "" : promise(question, experiments, from);
  if (!open.empty()) {
    text += fmt::format("{} {} from {}; {}",
                        text.empty() ? "no run whose readings can be predicted tells" : "; it does not tell",
                        question.winner.effect->name, fmt::join(open, ", "), question.winner.effect->experiment);
  }
  for (const Experiment& experiment : experiments) {
    if (!experiment.needs.empty()) text += fmt::format("; {}: {}", experiment.action, experiment.needs);
  }
  return text;
}

NextExperiment simulated(const LoggedCampaign& campaign, const CampaignModel& model, const Question& question) {
  const auto source = run_template(campaign);
  if (!source) return {std::string(question.winner.effect->experiment), {}};
  const ExperimentBatch usual(campaign, model, *source, actions(*source));
  std::vector<Answer> answers;
  answer(usual, question, answers);
  std::optional<ExperimentBatch> fine;  // its levels are new to all runs
  if (auto grid = fine_grid(*source, spot_c(model, question.winner, question.rivals.front()))) {
    fine.emplace(campaign, model, *source, std::vector<Action>{*std::move(grid)});
    answer(*fine, question, answers);
  }
  const std::vector<bool> is_told = told(answers, question.rivals.size());
  const bool any = std::find(is_told.begin(), is_told.end(), true) != is_told.end();
  NextExperiment next;
  next.experiments = ranked(answers, any ? is_told : std::vector<bool>(is_told.size(), true));
  if (is_asked_of(question, kTurning)) {
    if (auto needs = what_a_turn_needs(*source)) {
      next.experiments.push_back({"azimuth turn of the fixture", "azimuth-turn", 0.0, 0.0, *std::move(needs)});
    }
  }
  next.text = sentence(question, next.experiments, is_told);
  return next;
}

}  // namespace

NextExperiment next_experiment(const LoggedCampaign& campaign, const CampaignModel& plain,
                               const std::vector<NamedEffect>& effects, std::size_t which) {
  Question question{effects.at(which), {}, {}, {}};
  if (question.winner.rivals.empty()) return {};
  CampaignModel model = plain;
  for (std::size_t other = 0; other < effects.size(); ++other) {
    const NamedEffect& effect = effects[other];
    if (other == which || !predicts(effect)) continue;
    model.add_term(effect.candidate, effect.sensors, effect.parameters[index_of(effect.sensors.front())]);
    question.beside.push_back(&effect);
  }
  for (const Rival& rival : question.winner.rivals) {
    auto fitted = best_shape(model, *rival.effect);
    if (fitted && predicts(*fitted)) {
      question.rivals.push_back(*std::move(fitted));
    } else {
      question.unpredicted.push_back(rival.effect->name);
    }
  }
  if (question.rivals.empty() || !predicts(question.winner)) {
    return {std::string(question.winner.effect->experiment), {}};
  }
  return simulated(campaign, model, question);
}

}  // namespace soak::calib::gap
