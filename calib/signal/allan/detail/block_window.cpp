// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/detail/block_window.h"

#include <algorithm>
#include <iterator>

namespace soak::calib::signal::allan {

BlockWindow::BlockWindow(std::span<const AllanKind> kinds, std::span<const std::size_t> multiples)
    : multiples_(multiples.begin(), multiples.end()), capacity_(kBlock + 3 * multiples_.back()) {
  for (const AllanKind kind : kinds) sums_.push_back({kind, std::vector<SquareSum>(multiples_.size())});
}

void BlockWindow::add(std::span<const double> points) {
  while (!points.empty()) {
    const std::span<const double> fit = points.first(std::min(points.size(), capacity_ - window_.size()));
    window_.insert(window_.end(), fit.begin(), fit.end());
    points = points.subspan(fit.size());
    if (window_.size() < capacity_) return;
    for (KindSums& of : sums_) add_block(of.kind, window_, multiples_, of.sums);
    window_.erase(window_.begin(), std::next(window_.begin(), kBlock));
  }
}

void BlockWindow::end_stretch() {
  for (KindSums& of : sums_) add_blocks(of.kind, window_, multiples_, of.sums);
  window_.clear();
}

}  // namespace soak::calib::signal::allan
