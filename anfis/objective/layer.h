// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/model.h"

namespace soak::anfis::training {

/// Layers 1 to 5 of a model at all rows of some data, with the derivatives by the premises. The structure (inputs,
/// memberships, premises, dropped gains) is fixed at construction, parameters change; nothing is allocated after it.
/// Matrices have padded_rows() rows, a multiple of kernels.h's kLanes; the rows beyond rows() repeat the last one and
/// must be given no weight. Inputs and outputs are scaled as in Model.
class Layer {
 public:
  Layer(const Model& model, const TrainingData& data);

  /// Layers 1 to 3 [AH05 eq. 5.5-5.9] for the premises of `model`.
  void compute(const Model& model);

  /// Matrix A of the consequents [AH05 eq. 5.11-5.12], columns in the order of consequents.h.
  void consequent_matrix(const Model& model, Eigen::Ref<Eigen::MatrixXd> a) const;

  /// Layers 4 and 5 [AH05 eq. 5.10]: output of each row. After it gradient() and jacobian() may be asked.
  void compute_output(const Model& model);
  [[nodiscard]] const Eigen::VectorXd& output() const { return output_; }

  /// v^T df/d theta for all premise parameters, in the order of read_premises(); v has padded_rows() rows.
  void gradient(const Model& model, const Eigen::VectorXd& v, std::span<double> gradient);

  /// df/d theta, rows() x premise parameters.
  [[nodiscard]] Eigen::MatrixXd jacobian(const Model& model);

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] Eigen::Index padded_rows() const { return inputs_.rows(); }
  /// Scaled inputs, one column each.
  [[nodiscard]] const Eigen::MatrixXd& inputs() const { return inputs_; }
  [[nodiscard]] const Eigen::MatrixXd& strengths() const { return strengths_; }

 private:
  void compute_degrees(const Model& model);
  void compute_strengths(const Model& model);
  void multiply_degrees(const Model& model);
  void take_least_degree(const Model& model);
  void rescue_row(const Model& model, Eigen::Index row);
  void find_least_logarithms(const Model& model, Eigen::Index row);
  void collect_pull(const Model& model, std::size_t input, int membership);
  void sum_derivatives(const Membership& membership, Eigen::Index input, Eigen::Index column,
                       std::span<double> sums) const;

  std::size_t rows_;
  std::vector<Eigen::Index> first_;  ///< column of the first membership of each input
  Eigen::MatrixXd inputs_;
  Eigen::MatrixXd distance_;   ///< per membership: see model/detail/inference.h
  Eigen::MatrixXd degree_;     ///< per membership
  Eigen::MatrixXd strengths_;  ///< per rule, normalised
  Eigen::VectorXd sum_;        ///< of the strengths, before
  Eigen::MatrixXi least_;      ///< T-norm minimum: input with the least degree, per rule
  Eigen::MatrixXd pulls_;      ///< per rule: df/d ln w
  Eigen::VectorXd output_;
  Eigen::VectorXd pull_;  ///< df/d ln mu of the membership under way
  std::vector<double> log_strengths_;
  std::vector<double> point_;
};

}  // namespace soak::anfis::training
