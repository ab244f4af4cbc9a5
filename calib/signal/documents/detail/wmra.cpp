// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "calib/signal/documents/detail/common.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/wavelet/wavelet.h"

namespace soak::calib {

base::Result<WmraResult> wmra(const SignalRecord& record, const WmraRequest& request) {
  const auto wavelet = signal::wavelet_named(request.wavelet);
  if (!wavelet) return base::forward_error(wavelet);
  const std::vector<double> values = signal_json::bridged_values(record);
  WmraResult result;
  std::size_t longest = 0;
  for (const signal::SampleRange& range : signal::stretches_of(values)) {
    const std::span<const double> stretch(values.data() + range.first, range.count());
    auto split = signal::denoise(stretch, *wavelet, request.options);
    if (!split) return base::forward_error(split);
    for (std::size_t i = 0; i < stretch.size(); ++i) {
      if (std::isnan(record.values[range.first + i])) continue;
      result.t_s.push_back(record.t_s[range.first + i]);
      result.raw.push_back(stretch[i]);
      result.denoised.push_back(split->signal[i]);
      result.trend.push_back(split->trend[i]);
    }
    if (range.count() > longest) {
      longest = range.count();
      result.useful_levels = signal::useful_levels(longest, *wavelet);
      result.sigma = std::move(split->sigma);
      result.thresholds = std::move(split->thresholds);
    }
    ++result.stretches;
  }
  if (result.stretches == 0) return base::bad_input("the record has no samples");
  return result;
}

}  // namespace soak::calib
