// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/extended_campaign.h"

#include <algorithm>
#include <cmath>

#include "calib/gap/base_curve/base_design.h"
#include "calib/gap/base_curve/level_spline.h"

namespace soak::calib::gap {
namespace {

LoggedCampaign with(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned) {
  LoggedCampaign all = campaign;
  all.runs.insert(all.runs.end(), planned.begin(), planned.end());
  return all;
}

std::vector<double> temperatures_of(const Observations& observations, Sensor sensor) {
  std::vector<double> temp_c;
  for (const Observation& row : observations.rows) temp_c.push_back(row.sensor_temp_c[index_of(sensor)]);
  return temp_c;
}

std::size_t nearest(const std::vector<double>& level_c, double temp_c) {
  const auto off = [&](double c) { return std::abs(c - temp_c); };
  const auto best =
      std::min_element(level_c.begin(), level_c.end(), [&](double a, double b) { return off(a) < off(b); });
  return static_cast<std::size_t>(best - level_c.begin());
}

/// What the model's coefficients say at the levels of the extended campaign, in the layout of base_design() up to the
/// scale errors. A level that the model does not have lies on its spline.
Eigen::VectorXd curve_at_levels(const Observations& known, const Observations& extended,
                                const Eigen::VectorXd& coefficients, bool with_scale) {
  const Eigen::Index count = extended.level_count();
  const Eigen::Index before = known.level_count();
  const LevelSpline spline(known.level_c);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(with_scale ? 3 * count : 2 * count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::RowVectorXd weights = spline.weights(extended.level_c[static_cast<std::size_t>(k)]);
    result(k) = weights.dot(coefficients.head(before));
    if (count == before) result(count + k) = coefficients(before + k);
    if (with_scale) result(2 * count + k) = weights.dot(coefficients.segment(2 * before, before));
  }
  return result;
}

/// A level that is new has the slope of the nearest one that the model knows: no surer than that.
Eigen::VectorXd slope_prior(const Observations& known, const Observations& extended, const Eigen::VectorXd& levels) {
  constexpr double kLeast = 1e-12;
  const Eigen::VectorXd sigmas = slope_sigmas(known.level_c, levels);
  Eigen::VectorXd prior(extended.level_count());
  for (Eigen::Index k = 0; k < prior.size(); ++k) {
    const std::size_t same = nearest(known.level_c, extended.level_c[static_cast<std::size_t>(k)]);
    prior(k) = 1.0 / std::max(kLeast, sigmas(static_cast<Eigen::Index>(same)));
  }
  return prior;
}

}  // namespace

ExtendedCampaign::ExtendedCampaign(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned,
                                   const CampaignModel& model)
    : campaign_(with(campaign, planned)),
      observations_(observe(campaign_)),
      courses_(campaign_, observations_),
      whitening_(kSensorCount) {
  const std::size_t made = campaign.runs.size();
  for (const Observation& row : observations_.rows) {
    const std::size_t number = observations_.logged[static_cast<std::size_t>(row.run)];
    planned_run_.push_back(number < made ? -1 : static_cast<int>(number - made));
  }
  const Observations& known = model.circumstances().observations;
  const std::vector<bool> keep(observations_.rows.size(), true);
  for (const Sensor sensor : kSensors) {
    const std::size_t s = index_of(sensor);
    const auto& residual = model.residuals().sensor[s];
    if (!residual) continue;
    const std::vector<double> temp_c = temperatures_of(observations_, sensor);
    const bool scale = !is_gyro(sensor) && observations_.has_positions();
    const Eigen::VectorXd curve = curve_at_levels(known, observations_, residual->coefficients(), scale);
    BaseDesign design = base_design(observations_, sensor, temp_c);
    prior_[s] = Eigen::VectorXd::Zero(design.columns.cols());
    prior_[s].segment(design.levels, design.levels) =
        slope_prior(known, observations_, residual->coefficients().head(known.level_count()));
    base_[s] = std::move(design.columns);
    slope_[s] = base_slope(observations_, sensor, temp_c, curve);
    whitening_[s].emplace(observations_, sensor, model.residuals().noise[s], keep);
  }
}

Eigen::MatrixXd ExtendedCampaign::whiten(Sensor sensor, const Eigen::MatrixXd& columns) const {
  return whitening_[index_of(sensor)]->apply(columns);
}

const std::vector<Eigen::Index>& ExtendedCampaign::rows(Sensor sensor) const {
  return whitening_[index_of(sensor)]->rows();
}

}  // namespace soak::calib::gap
