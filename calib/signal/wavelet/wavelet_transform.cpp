// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/wavelet/wavelet_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "calib/signal/wavelet/detail/filters.h"
#include "calib/signal/wavelet/detail/kernels.h"
#include "calib/signal/wavelet/detail/levels.h"

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

constexpr std::size_t kMaxLevels = 40;

base::Status check_level_count(std::size_t levels) {
  if (levels >= 1 && levels <= kMaxLevels) return {};
  return base::bad_input(
      "the number of levels must be 1 to " + std::to_string(kMaxLevels) + ", not " + std::to_string(levels), "levels");
}

base::Status check_signal(std::span<const double> signal) {
  if (signal.empty()) return base::bad_input("the signal has no samples");
  if (wavelet::all_finite(signal.size(), signal.data())) return {};
  const auto bad = std::find_if_not(signal.begin(), signal.end(), [](double x) { return std::isfinite(x); });
  return base::bad_input("the value is not finite: only complete signals can be decomposed",
                         "sample " + std::to_string(bad - signal.begin()));
}

base::Status check_coefficients(const Decomposition& decomposition, const Wavelet& wavelet) {
  std::size_t count = decomposition.samples;
  for (std::size_t l = 0; l < decomposition.levels(); ++l) {
    count = wavelet::coefficient_count(count, wavelet.length(), decomposition.boundary);
    if (decomposition.details[l].size() == count) continue;
    return base::bad_input(
        "there must be " + std::to_string(count) + " details, not " + std::to_string(decomposition.details[l].size()),
        "level " + std::to_string(l + 1));
  }
  if (decomposition.approximation.size() == count) return {};
  return base::bad_input("there must be " + std::to_string(count) + " approximation coefficients, not " +
                         std::to_string(decomposition.approximation.size()));
}

/// Makes room for what decompose() writes.
void lay_out(Decomposition& into, std::size_t levels, std::size_t length) {
  into.details.resize(levels);
  std::size_t count = into.samples;
  for (std::vector<double>& details : into.details) {
    count = wavelet::coefficient_count(count, length, into.boundary);
    details.resize(count);
  }
  into.approximation.resize(count);
}

/// Memory for the approximations between the levels: of two neighbouring levels one is read while the other is written.
/// Only ever grows, so that nothing is allocated or cleared twice.
class Workspace {
 public:
  Workspace(std::vector<double>& memory, const std::vector<std::vector<double>>& details) {
    std::array<std::size_t, 2> most{};
    for (std::size_t l = 0; l + 1 < details.size(); ++l) most[l % 2] = std::max(most[l % 2], details[l].size());
    if (memory.size() < most[0] + most[1]) memory.resize(most[0] + most[1]);
    half_ = {memory.data(), memory.data() + most[0]};
  }

  /// The approximation that belongs to the details of the l-th level from the finest.
  [[nodiscard]] double* level(std::size_t l) const { return half_[l % 2]; }

 private:
  std::array<double*, 2> half_{};
};

}  // namespace

base::Result<Wavelet> wavelet_named(std::string_view name) {
  for (const wavelet::NamedFilter& filter : wavelet::filters()) {
    if (filter.name == name) return wavelet_of(filter);
  }
  return base::bad_input("there is no wavelet '" + std::string(name) + "'; there are " + known_names());
}

std::size_t useful_levels(std::size_t samples, const Wavelet& wavelet) {
  std::size_t levels = 0;
  for (std::size_t n = samples / 2; wavelet.length() >= 2 && n >= wavelet.length() - 1; n /= 2) ++levels;
  return levels;
}

base::Status decompose(std::span<const double> signal, const Wavelet& wavelet, std::size_t levels, Boundary boundary,
                       Decomposition& into) {
  for (const base::Status& status :
       {wavelet::check_filters(wavelet), check_level_count(levels), check_signal(signal)}) {
    if (!status) return status;
  }
  into.samples = signal.size();
  into.boundary = boundary;
  lay_out(into, levels, wavelet.length());
  const Workspace workspace(into.workspace, into.details);
  const wavelet::Banks banks = wavelet::banks_of(wavelet);
  std::span<const double> from = signal;
  for (std::size_t l = 0; l < levels; ++l) {
    double* approximation = l + 1 < levels ? workspace.level(l) : into.approximation.data();
    wavelet::analyse(from, banks, boundary, approximation, into.details[l].data());
    from = {approximation, into.details[l].size()};
  }
  return {};
}

base::Status reconstruct(const Decomposition& decomposition, const Wavelet& wavelet, std::vector<double>& scratch,
                         std::span<double> signal) {
  for (const base::Status& status : {wavelet::check_filters(wavelet), check_level_count(decomposition.levels()),
                                     check_coefficients(decomposition, wavelet)}) {
    if (!status) return status;
  }
  if (signal.empty() || signal.size() != decomposition.samples) {
    return base::bad_input("the signal must have room for " + std::to_string(decomposition.samples) + " samples, not " +
                           std::to_string(signal.size()));
  }
  const Workspace workspace(scratch, decomposition.details);
  const wavelet::Banks banks = wavelet::banks_of(wavelet);
  std::span<const double> from = decomposition.approximation;
  for (std::size_t l = decomposition.levels(); l-- > 0;) {
    const std::span<double> to =
        l > 0 ? std::span<double>(workspace.level(l - 1), decomposition.details[l - 1].size()) : signal;
    wavelet::synthesise(from, decomposition.details[l], banks, decomposition.boundary, to);
    from = to;
  }
  return {};
}

}  // namespace soak::calib::signal
