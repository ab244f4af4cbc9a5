// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Single passes over samples, in an order of additions that vector registers keep: the same bits on every x86-64.
namespace soak::calib {

/// sum_i (v_i - origin), in eight interleaved partial sums.
[[nodiscard]] double sum_above(std::span<const double> values, double origin);

/// sum_i (v_i - centre)^2, in eight interleaved partial sums.
[[nodiscard]] double squares_about(std::span<const double> values, double centre);

/// Whether any of the values is NaN.
[[nodiscard]] bool has_gap(std::span<const double> values);

/// Adds x_i/n to sum_x and y_i/n to sum_y, one after the other. Both have the same length.
void add_quotients(std::span<const double> x, std::span<const double> y, double n, double& sum_x, double& sum_y);

/// minutes_i = (t_i - start_s)/60; both have the same length.
void minutes_since(std::span<const double> t_s, double start_s, std::span<double> minutes);

/// The samples that are not NaN of every n-th row, n such that at most `most` are looked at; of a channel with values
/// in few rows the next one after such a row.
[[nodiscard]] std::vector<double> thinned(std::span<const double> values, std::size_t most);

/// The same for samples that come in pieces of any length: `rows` in all.
class Thinner {
 public:
  Thinner(std::size_t rows, std::size_t most) : stride_(rows / most + 1) {}
  void add(std::span<const double> values);
  [[nodiscard]] std::vector<double>& taken() { return taken_; }

 private:
  std::size_t stride_;
  std::size_t to_next_ = 0;  ///< rows until the next group of stride_ begins
  bool open_ = false;        ///< nothing was taken of this group
  std::vector<double> taken_;
};

/// Samples about a level. NaN samples make `sum` NaN and are not seen by `peak`.
struct Deviation {
  double sum = 0.0;   ///< of the samples less the level
  double peak = 0.0;  ///< largest distance from the level
};
[[nodiscard]] Deviation deviation_from(std::span<const double> values, double level);

/// Changes between neighbouring samples.
struct Changes {
  std::size_t none = 0;   ///< neighbours that are equal
  double smallest = 0.0;  ///< smallest change; 0 without any
};
[[nodiscard]] Changes changes_of(std::span<const double> values);

/// Extreme values; of at least one sample.
struct Extremes {
  double low = 0.0;
  double high = 0.0;
};
[[nodiscard]] Extremes extremes_of(std::span<const double> values);

}  // namespace soak::calib
