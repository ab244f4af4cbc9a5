// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "calib/signal/wavelet/denoising.h"
#include "calib/signal/wavelet/wavelet_transform.h"

namespace soak::calib::signal {

/// Denoised samples and their trend, one of each for every sample pushed, in order (see Denoised).
struct StreamedSamples {
  std::vector<double> signal;
  std::vector<double> trend;
};

/// Denoises a signal while it arrives: what denoise() with Boundary::symmetric gives for the whole signal at the same
/// thresholds, the same bits, from the first sample to the last, however the signal is cut into pushes. Only the
/// thresholds must be known beforehand: take Denoised::thresholds of a stretch recorded earlier, and renew them with
/// set_thresholds() when the noise changes.
///
/// A sample can only be denoised once the wavelets that overlap it have been seen. With L levels and filters of F taps,
/// sample i is final when sample i + latency() is there, at the latest: a pair of samples needs F/2 approximations from
/// its own on, the last of which ends F - 1 samples after the pair's first and must itself come back from the levels
/// above,
///   latency(L) = F - 1 + 2 latency(L - 1) = (2^L - 1)(F - 1),  latency(0) = 0.
/// (db8, 6 levels, 200 Hz: 945 samples, 4.7 s.) Once under way, samples come out 2^L at a time.
///
/// Memory: about 2.5 latency() numbers and working memory for 1024 samples, whatever the length of the signal. Time:
/// O(F) per sample, all levels together.
class StreamingDenoiser {
 public:
  /// Most levels: with F = 20 the latency is 1.2 million samples.
  static constexpr std::size_t kMaxLevels = 16;

  /// `thresholds`: one per level, finest first; their number is the number of levels. Refuses none or more than
  /// kMaxLevels of them, one that is negative or not finite, and a wavelet whose filters do not all have the same even
  /// length from 2 to 20.
  [[nodiscard]] static base::Result<StreamingDenoiser> create(const Wavelet& wavelet, Shrinkage shrinkage,
                                                              std::span<const double> thresholds);
  StreamingDenoiser(StreamingDenoiser&&) noexcept;
  StreamingDenoiser& operator=(StreamingDenoiser&&) noexcept;
  ~StreamingDenoiser();

  /// Largest number of samples that are inside after a push.
  [[nodiscard]] std::size_t latency() const;

  /// Takes the next samples and appends those that are final now to `into`. Refuses a sample that is not finite (a
  /// missing one), naming its index counted from the start of the signal; then none of `samples` was taken. After a
  /// gap, flush() and go on.
  [[nodiscard]] base::Status push(std::span<const double> samples, StreamedSamples& into);

  /// Ends the signal and appends the samples still inside, so that as many have come out as went in. The next push
  /// starts a new signal with the same thresholds.
  void flush(StreamedSamples& into);

  /// New thresholds, for samples pushed from now on. Samples still inside are denoised with these, the ones before, or
  /// partly with either. Refuses what create() refuses, and another number than there are levels.
  [[nodiscard]] base::Status set_thresholds(std::span<const double> thresholds);

 private:
  struct Impl;
  explicit StreamingDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace soak::calib::signal
