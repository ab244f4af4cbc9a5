// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/spectrum/autocorrelation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/signal/documents/detail/common.h"
#include "calib/signal/samples/sample_grid.h"
#include "calib/signal/spectrum/gauss_markov.h"

namespace soak::calib {
namespace {

using nlohmann::json;
using namespace signal_json;

json process_json(const base::Result<signal::GaussMarkov>& process) {
  if (!process) return {};
  return {{"sigma", process->sigma},
          {"correlation_s", process->correlation_s},
          {"beta_per_s", process->beta_per_s},
          {"white_sigma", process->white_sigma},
          {"rms_misfit", process->rms_misfit}};
}

base::Result<json> correlation_json(std::vector<double> values, double rate_hz, std::size_t longest) {
  signal::remove_stretch_means(values);
  const auto acf = signal::autocorrelation(values, longest);
  if (!acf) return base::forward_error(acf);
  std::vector<double> lags_s;
  for (std::size_t k = 0; k < acf->correlation.size(); ++k) lags_s.push_back(static_cast<double>(k) / rate_hz);
  return json{{"lag_s", lags_s},
              {"acf", acf->correlation},
              {"variance", acf->variance},
              {"correlation_time_s", number(signal::correlation_time_s(*acf, rate_hz))},
              {"gauss_markov_1", process_json(signal::fit_gauss_markov_1(*acf, rate_hz))},
              {"gauss_markov_2", process_json(signal::fit_gauss_markov_2(*acf, rate_hz))}};
}

}  // namespace

base::Result<json> acf_json(const SignalRecord& record, const AcfRequest& request) {
  const std::vector<double> values = bridged_values(record);
  const std::size_t room = longest_stretch(values);
  const double lag_s = request.longest_lag_s.value_or(0.1 * static_cast<double>(room) / record.rate_hz);
  const double lag = std::max(4.0, std::round(lag_s * record.rate_hz));
  if (!(lag_s > 0.0) || lag >= static_cast<double>(room)) {
    return base::bad_input(fmt::format("a longest lag of {:g} s: the longest stretch of the record lasts {:g} s", lag_s,
                                       static_cast<double>(room) / record.rate_hz),
                           "--max-lag-s");
  }
  const auto longest = static_cast<std::size_t>(lag);
  const auto before = correlation_json(values, record.rate_hz, longest);
  if (!before) return base::forward_error(before);
  json document = header(record);
  document.update(*before);
  document["after_wmra"] = nullptr;
  if (!request.after) return document;
  const auto denoised = denoised_values(record, *request.after);
  if (!denoised) return base::forward_error(denoised);
  const auto after = correlation_json(*denoised, record.rate_hz, longest);
  if (!after) return base::forward_error(after);
  document["after_wmra"] = *after;
  return document;
}

}  // namespace soak::calib
