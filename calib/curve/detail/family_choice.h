// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "calib/curve/curve_fit.h"
#include "calib/curve/families.h"

namespace soak::calib {

/// The family with the least expected squared error on the rows that all were fitted to (Mallows' C_p,
/// anfis::expected_squared_error). For so few runs that held-out ones cannot decide: a family that cannot follow the
/// curve shows by residuals beyond the rows' own standard errors. The spline is always among the families.
[[nodiscard]] Family least_expected_error(const TrainedFamilies& trained);

/// Variance of a deployed curve at a temperature: two parts that add.
struct CurveVariance {
  std::function<double(double)> own;               ///< for a model that is right
  std::function<double(double)> between_families;  ///< for not knowing which is
};

/// Of the deployed family, which was chosen by the same data: what it states of itself leaves out that another may be
/// right.
///
/// Chosen by the expected error, each family k counts by w_k ∝ exp(−C_k/2) with its expected squared error C_k [Burnham
/// & Anderson 2002, §2.9 and §4.3; Buckland, Burnham & Augustin 1997], and with the deployed curve f:
///   own = Σ w_k v_k(T),   between families = Σ w_k (f_k(T) − f(T))²
/// Chosen by held-out runs, the ANFIS, of which the data do not know less, counts for half beside a baseline that won.
///
/// The functions refer to `trained`, which must outlive them.
[[nodiscard]] CurveVariance variance_of(const TrainedFamilies& trained, Family deployed, bool by_held_out_runs);

}  // namespace soak::calib
