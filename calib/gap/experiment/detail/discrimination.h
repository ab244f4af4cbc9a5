// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/gap/experiment/detail/extended_campaign.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// How far apart two explanations of a campaign are, and how much farther a planned run would set them.
///
/// The distance from one to the other is the part of the first one's prediction, whitened, that the base with the
/// other's columns cannot follow, whatever its parameters and the best of its shapes; it is what a χ² of the wrong
/// explanation would grow by. The prediction holds the parameters that were estimated from the runs made.
class Discrimination {
 public:
  /// `beside`: effects that belong to the base in either case.
  Discrimination(const ExtendedCampaign& extended, const NamedEffect& one, const NamedEffect& other,
                 const std::vector<const NamedEffect*>& beside);

  /// By how much the squared distance grows with the given planned runs, of the two directions the lesser; 0 where that
  /// is below what rounding could make of it.
  [[nodiscard]] double gained(const std::vector<int>& planned_runs) const;

 private:
  struct Shape {
    Eigen::Index first = 0;  ///< column
    Eigen::Index count = 0;
  };
  /// All shapes of an effect and its prediction, as columns beside the base.
  struct Side {
    bool shared = false;
    std::vector<Shape> shapes;
    Eigen::Index prediction = 0;
  };
  /// Scalar products of the whitened columns (base, shapes, predictions), one matrix per run: that of all runs made
  /// first.
  struct SensorProducts {
    std::vector<Eigen::MatrixXd> of_run;
    Eigen::Index base = 0;  ///< the first so many columns
    Eigen::VectorXd prior;
  };
  using Products = std::array<Eigen::MatrixXd, kSensorCount>;

  void add(const ExtendedCampaign& extended, Sensor sensor, const Eigen::MatrixXd& base,
           const Eigen::MatrixXd& columns);
  [[nodiscard]] Products beside_the_base(const std::vector<int>& planned_runs) const;
  [[nodiscard]] static double distance(const Products& products, const Side& from, const Side& to);

  std::array<SensorProducts, kSensorCount> sensor_;
  std::array<Side, 2> side_;
};

}  // namespace soak::calib::gap
