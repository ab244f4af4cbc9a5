// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/curve/curve_fit.h"
#include "calib/curve/detail/family_choice.h"
#include "calib/curve/families.h"
#include "calib/vocabulary/one_way.h"

namespace soak::calib {

/// Compares residuals of rows on the way up with those on the way down, bin by bin of temperature. The noise of a
/// difference is its scatter between runs, pooled over the bins, as slow noise within a run hides from the rows' own
/// standard errors; one run alone has nothing but those. Nothing where no temperature was visited both ways in the same
/// run.
[[nodiscard]] std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve);

/// What the budget of a fitted curve is made from.
struct CurveEvidence {
  const CurveData& data;
  const Curve& curve;
  const CurveVariance& variance;
  const VarianceComponents& components;
  double runs = 0.0;
  const std::optional<SweepGap>& gap;
  std::span<const TypeBInput> type_b;
  const OneWay& one_way;
};

/// The contributions at the temperatures of the curve's points, always all seven (docs/fit.md):
///
///   noise       the rows' own standard errors, carried through the fit
///   run_to_run  σ_run/√R of the mean curve, σ_run√(1 + 1/R) of a fresh power-on, R − 1 degrees of freedom; of up to
///               three runs σ_run is the scatter of the estimated offsets with their noise, which `noise` then lacks
///   hysteresis  half the gap between heating and cooling, root mean square, of a fresh power-on: the curve is the
///   mean.
///               Where only one way was recorded the curve is that branch: with h, half the gap as known from
///               elsewhere, h of the mean and √2·h of a fresh power-on, which may be on either branch; nothing where h
///               is not known
///   thermometer, gravity, fixture    as given, the same in every run
///   model       scatter within runs that neither noise nor hysteresis explains: carried through the fit, and as such
///               for a fresh power-on; what families differ between which these rows cannot decide; of a recording
///               whose branches have offsets, the uncertainty of their mean
///
/// The parts of a fresh power-on are absent with one run, whose scatter nobody knows.
[[nodiscard]] std::vector<Contribution> curve_budget(const CurveEvidence& evidence, std::span<const double> temps_c);

}  // namespace soak::calib
