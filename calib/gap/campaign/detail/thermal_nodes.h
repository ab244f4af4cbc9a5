// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

namespace soak::calib::gap {

/// Logarithm of the chance that a Gaussian value lies in an interval, with its derivatives by the Gaussian's mean.
struct IntervalLikelihood {
  double log_chance = 0.0;
  double score = 0.0;      ///< first derivative
  double curvature = 0.0;  ///< minus the second derivative; not below 0: the logarithm is concave
};

/// `low` < `high`: distances of the interval's ends from the mean; `sigma` > 0 in the same unit. Finite at any
/// distance.
[[nodiscard]] IntervalLikelihood interval_likelihood(double low, double high, double sigma);

/// The chamber's air and the unit's thermometer in one run; all of one length, finite, `t_s` rising.
struct AirAndUnit {
  std::vector<double> t_s;
  std::vector<double> air_c;
  std::vector<double> unit_c;  ///< in steps
};

/// A unit that follows the air through two thermal nodes: T = o + a F₁ + b F₂, dFₖ/dt = (A − Fₖ)/τₖ. o holds the unit's
/// own warmth and how its thermometer rounds; a + b ≠ 1 is heat that leaks elsewhere, or a thermometer of another
/// scale. Each run starts its nodes anew.
struct ThermalNodes {
  std::array<double, 2> tau_s{};
  std::vector<std::vector<double>> unit_c;  ///< T of each run, at its t_s
};

/// Maximum likelihood of all parameters over all runs: each reading says that T, but for a Gaussian error, lies within
/// half a step of it. So the moments between two steps count, which tell T far better than a step. Nothing where the
/// runs hold fewer rows than parameters. Cost linear in rows, some hundred passes.
[[nodiscard]] std::optional<ThermalNodes> fit_thermal_nodes(const std::vector<AirAndUnit>& runs, double step_c);

}  // namespace soak::calib::gap
