// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "anfis/data/training_data.h"
#include "base/result.h"

namespace soak::anfis {

/// Many rows at few inputs as one row per condensed input, rising, with the precision_factor of all groups together:
/// for learning from groups that share their inputs. For any curve f the error of the condensed rows is that of all:
///     r^T V^-1 r = squares_within + (m - f)^T G (m - f),   G = P^T V^-1 P,   m = G^-1 P^T V^-1 y,
/// f its values at the condensed inputs, P the incidence of rows in them, V as in GroupWhitening: the residuals of the
/// means m are V^-1-orthogonal to every f. Exact where the inputs of a condensed row are equal. Where they are not,
/// each row is first moved along `shape` to the weighted mean of its neighbours' inputs: what is left is the difference
/// between f and shape over that distance, whose part of first order cancels.
///
/// Walking up the inputs, a row joins the one before if it lies less than `width` above the lowest of them. Refuses
/// (bad_input) data that validate() refuses, several inputs, data that are condensed already, a negative width, and
/// free offsets (group_variance = +infinity), for which G has no inverse, or offsets so much larger than the noise that
/// rounding leaves it none.
[[nodiscard]] base::Result<TrainingData> condense(const TrainingData& data, double width,
                                                  const std::function<double(double)>& shape);

}  // namespace soak::anfis
