// SPDX-License-Identifier: Apache-2.0
#include "nav/filter/smoother.h"

#include <cstddef>
#include <utility>

#include "base/linear/dense_solve.h"
#include "nav/filter/filter_run.h"

namespace soak::nav {
namespace {

using Eigen::MatrixXd;

/// Keeps what the way back needs of a filter. An interval ends where measurements change the estimate, or where the
/// caller wants to know it.
class Recorder {
 public:
  explicit Recorder(const NavigationFilter& filter) { open(filter); }

  void before_prediction(const NavigationFilter& filter) {
    if (filter.feed_backs() != feed_backs_) mark(filter);
  }

  void after_prediction(const NavigationFilter& filter) {
    open_.transition = filter.transition() * open_.transition;
    open_.end = filter.covariance();
  }

  void mark(const NavigationFilter& filter) {
    open_.fed_back = (filter.fed_back() - fed_back_).head(open_.begin.rows());
    intervals_.push_back(std::move(open_));
    open(filter);
  }

  [[nodiscard]] const std::vector<FilterInterval>& intervals() const { return intervals_; }

 private:
  void open(const NavigationFilter& filter) {
    open_.begin = filter.covariance();
    open_.transition = MatrixXd::Identity(open_.begin.rows(), open_.begin.cols());
    open_.end = open_.begin;
    fed_back_ = filter.fed_back();
    feed_backs_ = filter.feed_backs();
  }

  std::vector<FilterInterval> intervals_;
  FilterInterval open_;
  NavigationFilter::Errors fed_back_;  ///< up to the beginning of the open interval
  std::size_t feed_backs_ = 0;         ///< up to there
};

/// A filter at a time that was asked for, after so many intervals.
struct Stop {
  std::size_t intervals = 0;
  NavigationFilter filter;
};

SmoothedPoint point_of(double t_s, Stop stop, LeftErrors left) {
  NavigationFilter::Errors errors = NavigationFilter::Errors::Zero();
  errors.head(left.errors.size()) = left.errors;
  stop.filter.feed_back(errors);
  const NavigationFilter& filter = stop.filter;
  const MatrixXd h = filter.antenna_by_errors().leftCols(left.covariance.cols());
  const Eigen::Matrix3d antenna_covariance_m2 = h * left.covariance * h.transpose();
  return {t_s,
          filter.antenna(),
          filter.antenna_velocity_mps(),
          filter.state(),
          filter.gyro_bias_rps(),
          filter.accel_bias_mps2(),
          std::move(left.covariance),
          antenna_covariance_m2};
}

}  // namespace

std::vector<LeftErrors> left_errors(std::span<const FilterInterval> intervals, const MatrixXd& last) {
  std::vector<LeftErrors> left(intervals.size() + 1);
  left.back() = {Eigen::VectorXd::Zero(last.rows()), last};
  for (std::size_t k = intervals.size(); k-- > 0;) {
    const FilterInterval& interval = intervals[k];
    const LeftErrors& after = left[k + 1];
    // C = P Φᵀ (P⁻)⁻¹;  εˢ = C (ε₊ˢ + K z);  Pˢ = P + C (P₊ˢ − P⁻) Cᵀ
    const MatrixXd c = base::solve_ldlt(interval.end, MatrixXd(interval.transition * interval.begin)).transpose();
    const MatrixXd covariance = interval.begin + c * (after.covariance - interval.end) * c.transpose();
    left[k].errors = c * (after.errors + interval.fed_back);
    left[k].covariance = 0.5 * (covariance + covariance.transpose());
  }
  return left;
}

std::vector<SmoothedPoint> smoothed(const Drive& drive, const Start& start, const FilterOptions& options,
                                    std::span<const double> t_s) {
  FilterRun run(drive, start, options);
  Recorder recorder(run.filter());
  run.before_prediction = [&](const NavigationFilter& filter) { recorder.before_prediction(filter); };
  run.after_prediction = [&](const NavigationFilter& filter) { recorder.after_prediction(filter); };
  std::vector<Stop> stops;
  for (const double wanted_s : t_s) {
    run.advance_to(wanted_s);
    recorder.mark(run.filter());
    stops.push_back({recorder.intervals().size(), run.filter()});
  }
  run.advance_to(drive.imu.back().t_s);
  recorder.mark(run.filter());
  auto left = left_errors(recorder.intervals(), run.filter().covariance());
  std::vector<SmoothedPoint> points;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    LeftErrors& at_stop = left[stops[i].intervals];
    points.push_back(point_of(t_s[i], std::move(stops[i]), std::move(at_stop)));
  }
  return points;
}

}  // namespace soak::nav
