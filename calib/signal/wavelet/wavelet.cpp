// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/wavelet.h"

#include <string>

#include "calib/signal/wavelet/detail/filters.h"

namespace soak::calib::signal {
namespace {

std::string known_names() {
  std::string names;
  for (const wavelet::NamedFilter& filter : wavelet::filters()) {
    if (!names.empty()) names += ", ";
    names += filter.name;
  }
  return names;
}

Wavelet wavelet_of(const wavelet::NamedFilter& filter) {
  Wavelet wavelet;
  wavelet.name = filter.name;
  wavelet.rec_lo.assign(filter.rec_lo.begin(), filter.rec_lo.end());
  wavelet.dec_lo.assign(filter.rec_lo.rbegin(), filter.rec_lo.rend());
  for (std::size_t k = 0; k < filter.rec_lo.size(); ++k) {
    // g[k] = (-1)^(k + 1) h[k]
    wavelet.dec_hi.push_back(k % 2 == 0 ? -filter.rec_lo[k] : filter.rec_lo[k]);
  }
  wavelet.rec_hi.assign(wavelet.dec_hi.rbegin(), wavelet.dec_hi.rend());
  return wavelet;
}

}  // namespace

base::Result<Wavelet> wavelet_named(std::string_view name) {
  for (const wavelet::NamedFilter& filter : wavelet::filters()) {
    if (filter.name == name) return wavelet_of(filter);
  }
  return base::bad_input("there is no wavelet '" + std::string(name) + "'; there are " + known_names());
}

}  // namespace soak::calib::signal
