// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace soak::anfis {

/// Shape of the membership functions of one model.
enum class Membership {
  bell,      ///< 1 / (1 + |(u - centre)/width|^(2 slope)) [AH05 eq. 5.6]
  gaussian,  ///< exp(-((u - centre)/width)^2 / 2) [AH05 eq. 5.7]
};

/// "bell" or "gaussian".
[[nodiscard]] std::string_view name(Membership membership);

/// One Takagi-Sugeno rule "if u is A then f = gain u + offset", all in scaled units (see Model).
struct Rule {
  double width = 1.0;   ///< premise: a of the bell, standard deviation of the Gaussian; > 0
  double slope = 0.0;   ///< premise: b of the bell, > 0; unused and 0 for the Gaussian
  double centre = 0.0;  ///< premise: where the membership is 1
  double gain = 0.0;    ///< consequent: 0 in a model of order 0
  double offset = 0.0;  ///< consequent

  friend bool operator==(const Rule&, const Rule&) = default;
};

/// Takagi-Sugeno system with one input and one output. With the scaled input u = (x - input_centre) / input_half_range
/// its output is output_centre + output_half_range sum_i wbar_i(u) (gain_i u + offset_i), where wbar are the normalised
/// firing strengths [AH05 eq. 5.5-5.11].
struct Model {
  Membership membership = Membership::bell;
  int order = 1;  ///< 1: linear consequents, 0: constant ones (every gain is 0)
  double input_centre = 0.0;
  double input_half_range = 1.0;
  double output_centre = 0.0;
  double output_half_range = 1.0;
  std::vector<Rule> rules;  ///< in rising order of centres
  double x_min = 0.0;       ///< range of the training inputs: the model says nothing outside it
  double x_max = 0.0;

  friend bool operator==(const Model&, const Model&) = default;
};

/// Whether the model can be evaluated: at least one rule, every number finite, widths, slopes and half ranges positive,
/// gains 0 in order 0, x_min <= x_max. The message names the field.
[[nodiscard]] base::Status validate(const Model& model);

/// Output at x, in the units of the training output. Nothing is clamped: outside [x_min, x_max] it extrapolates, and
/// the caller judges that. Finite for every finite x of a valid model: where no rule fires (every strength underflows)
/// the strengths keep their ratios in the limit, so that the nearest rule alone remains.
[[nodiscard]] double evaluate(const Model& model, double x);

/// The same for many inputs; y has the size of x.
void evaluate(const Model& model, std::span<const double> x, std::span<double> y);

/// Normalised firing strengths at x, one per rule: not negative, their sum is 1 [AH05 eq. 5.9].
void firing_strengths(const Model& model, double x, std::span<double> strengths);

}  // namespace soak::anfis
