// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// Products of dense matrices that hold most of the time of a search. Eigen's are compiled for any x86-64 processor and
// use half of the width of those with AVX2; these are compiled for both, and give the same bits on both: each sum has
// one order, whatever the processor. Sizes must fit. For columns of zeros to a few thousand rows; a dozen columns or
// more are worth it.
namespace soak::base {

using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd>;

/// aᵀ b.
[[nodiscard]] Eigen::MatrixXd transposed_product(const ConstMatrix& a, const ConstMatrix& b);
/// aᵀ a: the lower triangle; what lies above it is not to be read.
[[nodiscard]] Eigen::MatrixXd lower_products(const ConstMatrix& a);
/// a b.
[[nodiscard]] Eigen::MatrixXd product(const ConstMatrix& a, const ConstMatrix& b);
/// c ← c − a b.
void subtract_product(const ConstMatrix& a, const ConstMatrix& b, Eigen::MatrixXd& c);

}  // namespace soak::base
