// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "calib/signal/wavelet/detail/kernels.h"
#include "calib/signal/wavelet/detail/levels.h"
#include "calib/signal/wavelet/detail/sample_queue.h"
#include "calib/signal/wavelet/threshold.h"
#include "calib/signal/wavelet/wavelet.h"

namespace soak::calib::signal::denoising {

/// A wavelet's filters as the kernels take them.
struct StreamingBanks {
  /// Precondition: that of banks_of().
  explicit StreamingBanks(const Wavelet& wavelet);

  wavelet::Banks transform;
  wavelet::Polyphase smoothing;  ///< transform.synthesis with all details taken as 0
};

/// One level of a running transform and its inverse: splits the approximations of the finer level (the signal itself at
/// the finest) into its own approximations and details, keeps the details until the coarser level has rebuilt these
/// approximations, and rebuilds those of the finer level from both.
///
/// With the signal x mirrored at its start, e[i] = x(i - (F - 2)), coefficient k is the sum of
/// rec(i) e[2k + i], i < F: the numbering of decompose(). The mirrored part is known after F - 2 samples.
///
/// What the functions return stands in the level's own memory: valid until its next call.
class StreamingLevel {
 public:
  /// The next samples of the level's signal; the approximations that follow from them.
  [[nodiscard]] std::span<const double> split(std::span<const double> samples, const StreamingBanks& banks,
                                              double threshold, Shrinkage shrinkage);
  /// The signal ends: the approximations that need what lies beyond, mirrored.
  [[nodiscard]] std::span<const double> split_end(const StreamingBanks& banks, double threshold, Shrinkage shrinkage);

  /// Rebuilt approximations of this level, from the denoised details and from none.
  struct Rebuilt {
    std::span<const double> signal;
    std::span<const double> trend;
  };
  /// The next approximations; the samples of the level's signal that follow from them. An odd signal comes out with one
  /// sample too many at its end.
  [[nodiscard]] Rebuilt rebuild(const Rebuilt& approximations, const StreamingBanks& banks);

  /// As new.
  void clear();

 private:
  void mirror_start(std::size_t length);
  void mirror_end(std::size_t length);
  std::span<const double> split_waiting(const StreamingBanks& banks, double threshold, Shrinkage shrinkage);
  void combine(std::size_t pairs, const wavelet::Polyphase& bank, const SampleQueue& approximations,
               std::vector<double>& samples);

  bool mirrored_ = false;  ///< `waiting_` begins with the mirrored start
  std::size_t count_ = 0;  ///< samples of the level's signal so far
  SampleQueue waiting_;    ///< samples and what the next coefficients need of those before
  SampleQueue details_;    ///< shrunk, from the next pair of samples to rebuild on
  SampleQueue signal_;     ///< rebuilt approximations, from the same place on
  SampleQueue trend_;
  std::vector<double> even_;  ///< working memory of the calls, like the following
  std::vector<double> odd_;
  std::vector<double> approximation_;
  std::vector<double> detail_;
  std::vector<double> signal_out_;
  std::vector<double> trend_out_;
};

}  // namespace soak::calib::signal::denoising
