// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/thinned_level.h"

#include <array>

namespace soak::calib::signal::allan {
namespace {

constexpr std::array kOfPhase = {AllanKind::overlapping, AllanKind::overlapping_hadamard};
constexpr std::array kOfMeans = {AllanKind::modified};

void keep_every_second(std::vector<double>& points, bool& skip) {
  std::size_t kept = 0;
  for (const double x : points) {
    if (!skip) points[kept++] = x;
    skip = !skip;
  }
  points.resize(kept);
}

void keep_means_of_pairs(std::vector<double>& means, std::optional<double>& first_half) {
  std::size_t kept = 0;
  for (const double x : means) {
    if (first_half) {
      means[kept++] = 0.5 * (*first_half + x);
      first_half.reset();
    } else {
      first_half = x;
    }
  }
  means.resize(kept);
}

}  // namespace

ThinnedLevel::ThinnedLevel(std::span<const std::size_t> multiples)
    : phase_(kOfPhase, multiples), means_(kOfMeans, multiples) {}

void ThinnedLevel::add(std::vector<double>& points, std::vector<double>& means) {
  phase_.add(points);
  means_.add(means);
  keep_every_second(points, skip_);
  keep_means_of_pairs(means, first_half_);
}

void ThinnedLevel::end_stretch() {
  phase_.end_stretch();
  means_.end_stretch();
  skip_ = false;
  first_half_.reset();
}

}  // namespace soak::calib::signal::allan
