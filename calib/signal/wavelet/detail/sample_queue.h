// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace soak::calib::signal::denoising {

/// Numbers that wait, oldest first, side by side in memory. Keeps room for at most twice as many as ever waited.
class SampleQueue {
 public:
  [[nodiscard]] std::size_t size() const { return values_.size() - first_; }
  [[nodiscard]] const double* data() const { return values_.data() + first_; }
  [[nodiscard]] double operator[](std::size_t i) const { return values_[first_ + i]; }

  void append(std::span<const double> values) {
    close_up();
    values_.insert(values_.end(), values.begin(), values.end());
  }

  /// The oldest `count` have been dealt with.
  void drop(std::size_t count) { first_ += count; }

  void clear() {
    values_.clear();
    first_ = 0;
  }

 private:
  /// Moves what waits to the front, not before as many are gone: a constant time per number.
  void close_up() {
    if (first_ < size()) return;
    values_.erase(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(first_));
    first_ = 0;
  }

  std::vector<double> values_;
  std::size_t first_ = 0;
};

}  // namespace soak::calib::signal::denoising
