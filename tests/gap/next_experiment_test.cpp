// SPDX-License-Identifier: Apache-2.0
// Which run would tell two effects apart: judged by what the physics of both says of the actions.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "calib/gap/experiment/detail/discrimination.h"
#include "calib/gap/experiment/next_experiment.h"
#include "tests/errors.h"
#include "tests/gap/made_up_campaign.h"

namespace soak::calib::gap {
namespace {

using made_up::Hidden;
using made_up::hysteresis;
using made_up::Moment;
using made_up::Plan;
using made_up::unit_of;

Hidden warm_up(const Plan& plan) {
  return [=](Sensor sensor, const Moment& m) { return 6.0 * unit_of(plan, sensor) * std::exp(-m.t_s / 1600.0); };
}

/// What gyros feel of the Earth, or of gravity, in headings (head()) in which the two are alike: the axis after the
/// upward one points north.
Hidden towards_north(double rate_rps) {
  return [=](Sensor sensor, const Moment& m) {
    return is_gyro(sensor) ? rate_rps * m.up[(axis_of(sensor) + 2) % 3] : 0.0;
  };
}

/// Opposite faces of the fixture stand in opposite headings.
void head(LoggedCampaign& campaign) {
  for (LoggedRun& run : campaign.runs) {
    for (Segment& segment : run.run.segments) {
      segment.position->azimuth_deg = segment.key.position[0] == '+' ? 0.0 : 180.0;
    }
  }
}

const Effect* effect_named(std::string_view name) {
  const auto& all = library();
  return &*std::find_if(all.begin(), all.end(), [&](const Effect& effect) { return effect.name == name; });
}

/// A campaign with what the workflow makes of it.
struct Prepared {
  explicit Prepared(LoggedCampaign made)
      : campaign(std::move(made)),
        observations(observe(campaign)),
        history(campaign, observations),
        model(observations, history) {}

  LoggedCampaign campaign;
  Observations observations;
  TemperatureHistory history;
  CampaignModel model;
};

/// The effect of that name whose temperature history imitates a prediction as well as it can, sensor by sensor: a rival
/// that explains as much.
NamedEffect imitation(const CampaignModel& model, const NamedEffect& original, std::string_view name) {
  NamedEffect best;
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : effect_named(name)->candidates(model.regressor_inputs())) {
    NamedEffect effect{.effect = effect_named(name), .candidate = candidate, .sensors = original.sensors};
    double misfit = 0.0;
    for (const Sensor sensor : effect.sensors) {
      const std::size_t s = index_of(sensor);
      const Eigen::VectorXd wanted = original.candidate.columns[s] * original.parameters[s];
      const Eigen::MatrixXd& columns = candidate.columns[s];
      effect.parameters[s] = (columns.transpose() * columns).ldlt().solve(columns.transpose() * wanted);
      misfit += (wanted - columns * effect.parameters[s]).squaredNorm() / wanted.squaredNorm();
    }
    if (misfit < least) best = effect;
    least = std::min(least, misfit);
  }
  return best;
}

/// Squared distance per hour that each action adds between an effect and its imitation, by the action's first words.
std::map<std::string, double> per_hour(const Prepared& prepared, std::string_view effect, std::string_view imitator) {
  std::map<std::string, double> result;
  const auto winner = best_shape(prepared.model, *effect_named(effect));
  const auto source = run_template(prepared.campaign);
  EXPECT_TRUE(winner && source);
  if (!winner || !source) return result;
  const ExperimentBatch batch(prepared.campaign, prepared.model, *source, actions(*source));
  const auto gained = batch.gained(*winner, imitation(prepared.model, *winner, imitator), {});
  for (std::size_t a = 0; a < gained.size(); ++a) {
    result[batch.actions()[a].name.substr(0, 10)] = gained[a] / batch.hours()[a];
  }
  return result;
}

std::string best_of(const std::map<std::string, double>& actions) {
  return std::max_element(actions.begin(), actions.end(), [](auto& a, auto& b) { return a.second < b.second; })->first;
}

/// What is said of an effect with rivals that the test appoints.
NextExperiment between(const Prepared& prepared, std::string_view effect, const std::vector<std::string_view>& rivals) {
  auto winner = best_shape(prepared.model, *effect_named(effect));
  EXPECT_TRUE(winner);
  if (!winner) return {};
  for (const auto& rival : rivals) winner->rivals.push_back({effect_named(rival), {}});
  return next_experiment(prepared.campaign, prepared.model, {*winner}, 0);
}

// The unit still moves while it is recorded. With a longer soak the rate is gone, the memory is not; at half the ramp
// rate it is half, the memory is not.
TEST(NextExperiment, OfHysteresisAndRateIsALongerSoakRatherThanARepeat) {
  Plan plan;
  plan.settling_s = 1200.0;
  const Prepared prepared(made_up::campaign(plan, hysteresis(plan)));
  const auto actions = per_hour(prepared, "thermal_hysteresis", "temperature_rate");
  EXPECT_EQ(best_of(actions), "longer soa");
  EXPECT_GT(actions.at("longer soa"), 1.5 * actions.at("repeat of "));
}

// After a power cycle on the way up the warm-up comes again; the memory of the branch does not.
TEST(NextExperiment, OfWarmUpAndHysteresisIsAPowerCycle) {
  for (const int levels : {5, 7}) {
    Plan plan;
    plan.levels = levels;
    const Prepared prepared(made_up::campaign(plan, warm_up(plan)));
    EXPECT_EQ(best_of(per_hour(prepared, "warmup_transient", "thermal_hysteresis")), "power cycl") << levels;
  }
}

// In these headings g-sensitivity can do all that the Earth does. It turns with the unit, the Earth does not: nothing
// but a turn of the fixture changes anything.
TEST(NextExperiment, OfTheEarthAndGSensitivityIsATurnOfTheFixtureAndNothingElseShowsAnything) {
  LoggedCampaign campaign = made_up::campaign({}, towards_north(5e-5));
  head(campaign);
  const auto actions = per_hour(Prepared(std::move(campaign)), "earth_rate", "g_sensitivity");
  ASSERT_TRUE(actions.contains("azimuth tu"));
  for (const auto& [action, value] : actions) {
    if (action == "azimuth tu") {
      EXPECT_GT(value, 1.0);
    } else {
      EXPECT_EQ(value, 0.0) << action;
    }
  }
}

TEST(NextExperiment, SaysWhatTellsFromWhomAtWhatPrice) {
  LoggedCampaign campaign = made_up::campaign({}, towards_north(5e-5));
  head(campaign);
  const Prepared prepared(std::move(campaign));
  const NextExperiment next = between(prepared, "g_sensitivity", {"earth_rate"});
  ASSERT_FALSE(next.experiments.empty());
  const Experiment& best = next.experiments.front();
  EXPECT_EQ(best.procedure, "azimuth-turn");
  EXPECT_GT(best.sigma, 3.0);
  // Runs of the campaign last 12 · 30 min + 13 · 18 min = 9.9 h.
  EXPECT_NEAR(best.hours, 9.9, 0.1);
  EXPECT_TRUE(base::mentions_in_order(
      next.text, {best.action, "g_sensitivity", "earth_rate", "10 h", "procedures/azimuth-turn.toml"}));
}

TEST(NextExperiment, SaysThatATurnNeedsHeadings) {
  const Prepared prepared(made_up::campaign({}, towards_north(5e-5)));
  const NextExperiment next = between(prepared, "g_sensitivity", {"earth_rate"});
  ASSERT_FALSE(next.experiments.empty());
  EXPECT_EQ(next.experiments.back().procedure, "azimuth-turn");
  EXPECT_EQ(next.experiments.back().sigma, 0.0);
  EXPECT_NE(next.experiments.back().needs.find("azimuths_deg"), std::string::npos) << next.experiments.back().needs;
  EXPECT_NE(next.text.find("azimuths_deg"), std::string::npos) << next.text;
}

TEST(NextExperiment, IsNotSoughtWithoutARival) {
  const Plan plan;
  const NextExperiment next = between(Prepared(made_up::campaign(plan, hysteresis(plan))), "thermal_hysteresis", {});
  EXPECT_EQ(next.text, "");
  EXPECT_TRUE(next.experiments.empty());
}

TEST(NextExperiment, OfWhatCannotBeForetoldIsTheLibrarysSentence) {
  // A tilt is drawn anew with every mounting.
  const Plan plan;
  const NextExperiment next =
      between(Prepared(made_up::campaign(plan, warm_up(plan))), "warmup_transient", {"fixture_tilt"});
  EXPECT_EQ(next.text, effect_named("warmup_transient")->experiment);
  EXPECT_TRUE(next.experiments.empty());
}

// A planned repeat is worth what a run that was really made is worth: the second half of a campaign as planned runs of
// the first half.
TEST(NextExperiment, ForetellsOfARepeatWhatARepeatTells) {
  const Plan plan;
  const LoggedCampaign all = made_up::campaign(plan, hysteresis(plan));
  LoggedCampaign half = all;
  half.runs.resize(3);
  const Prepared prepared(half);
  const auto winner = best_shape(prepared.model, *effect_named("thermal_hysteresis"));
  ASSERT_TRUE(winner);
  const NamedEffect rival = imitation(prepared.model, *winner, "warmup_transient");
  const ExtendedCampaign made(half, {all.runs[3], all.runs[4], all.runs[5]}, prepared.model);
  const Discrimination seen(made, *winner, rival, {});
  const auto source = run_template(half);
  ASSERT_TRUE(source);
  const ExperimentBatch batch(half, prepared.model, *source, actions(*source));
  const double foretold = batch.gained(*winner, rival, {}).front();
  for (int run = 0; run < 3; ++run) EXPECT_NEAR(seen.gained({run}) / foretold, 1.0, 0.25) << run;
}

/// A unit behind air that ramps, by the formula of a first-order lag: temperature at `t_s` after the ramp's begin.
double behind_a_ramp(double from_c, double to_c, double rate_kps, double tau_s, double t_s) {
  const double length_s = std::abs(to_c - from_c) / rate_kps;
  const double rate = to_c > from_c ? rate_kps : -rate_kps;
  if (t_s <= length_s) return from_c + rate * (t_s - tau_s * -std::expm1(-t_s / tau_s));
  return to_c - rate * tau_s * -std::expm1(-length_s / tau_s) * std::exp(-(t_s - length_s) / tau_s);
}

TEST(RunTemplate, FindsRampAndLagInTheLog) {
  for (const double tau_s : {120.0, 300.0, 500.0}) {
    for (const double rate_kpmin : {1.0, 3.0}) {
      LoggedCampaign campaign;
      LoggedRun run;
      base::Random random(7);
      const double soak_s = 1500.0;
      for (int visit = 0; visit < 6; ++visit) {
        const double from_c = visit == 0 ? -20.0 : 15.0 * visit - 35.0;
        const double to_c = 15.0 * visit - 20.0;
        const double way_s = visit == 0 ? 0.0 : 15.0 / rate_kpmin * 60.0 + soak_s;
        const double begin_s = run.log.t_s.empty() ? 0.0 : run.log.t_s.back() + 10.0;
        for (double t = 0.0; t < way_s + 600.0; t += 10.0) {
          run.log.t_s.push_back(begin_s + t);
          const double c = visit == 0 ? to_c : behind_a_ramp(from_c, to_c, rate_kpmin / 60.0, tau_s, t);
          run.log.temp_c.push_back(c + 0.01 * random.gaussian());
        }
        Segment segment;
        segment.key.visit = visit;
        segment.plateau_c = to_c;
        segment.t_start_s = begin_s + way_s;
        segment.t_end_s = run.log.t_s.back();
        segment.blocks.push_back({.t_s = segment.t_start_s + 30.0, .temp_c = to_c});
        run.run.segments.push_back(segment);
      }
      campaign.runs.push_back(run);
      const auto found = run_template(campaign);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->settling.tau_s, tau_s, 0.1 * tau_s) << rate_kpmin;
      ASSERT_TRUE(found->settling.rate_kps) << tau_s << " " << rate_kpmin;
      EXPECT_NEAR(*found->settling.rate_kps * 60.0, rate_kpmin, 0.1 * rate_kpmin) << tau_s;
      EXPECT_NEAR(found->visits[3].soak_s, soak_s, 0.1 * soak_s) << tau_s << " " << rate_kpmin;
    }
  }
}

}  // namespace
}  // namespace soak::calib::gap
