// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan_stream.h"

#include <utility>

#include "calib/signal/allan/detail/checks.h"
#include "calib/signal/allan/detail/phase_integrator.h"
#include "calib/signal/allan/detail/thinned_level.h"

namespace soak::calib::signal {
namespace {

constexpr std::size_t kLevels = 24;
constexpr std::size_t kBatch = 4096;  ///< points that go into the levels at a time: 32 KB
static_assert(AllanStream::kExact <= allan::kBlock);

/// 1, 2, 3, then 4, 5, 6 and 7 times powers of two.
std::vector<std::size_t> grid_up_to(std::size_t longest) {
  std::vector<std::size_t> multiples = {1, 2, 3};
  for (std::size_t power = 1; 4 * power <= longest; power *= 2) {
    for (std::size_t m = 4 * power; m < 8 * power && m <= longest; m += power) multiples.push_back(m);
  }
  return multiples;
}

/// The whole grid at full rate; on each thinned level its last octave, (kExact/2, kExact].
std::vector<allan::ThinnedLevel> make_levels() {
  const std::vector<std::size_t> grid = grid_up_to(AllanStream::kExact);
  std::vector<allan::ThinnedLevel> levels(kLevels, allan::ThinnedLevel(std::span(grid).last(4)));
  levels.front() = allan::ThinnedLevel(grid);
  return levels;
}

}  // namespace

struct AllanStream::Impl {
  double interval_s;
  allan::PhaseIntegrator integrator;
  std::vector<allan::ThinnedLevel> levels = make_levels();
  std::vector<double> points;  ///< not in the levels yet
  std::vector<double> means;   ///< their copy, thinned beside them
  std::vector<std::size_t> stretches;
  std::size_t samples = 0;

  Impl(double rate_hz, std::size_t bridge) : interval_s(1.0 / rate_hz), integrator(bridge) {}

  void begin_stretch() {
    hand_on();
    for (allan::ThinnedLevel& level : levels) level.end_stretch();
    stretches.push_back(0);
  }

  void point(double x) {
    points.push_back(x);
    ++stretches.back();
    if (points.size() == kBatch) hand_on();
  }

  void hand_on() {
    means = points;
    for (allan::ThinnedLevel& level : levels) {
      if (points.empty() && means.empty()) break;
      level.add(points, means);
    }
    points.clear();
  }
};

namespace {

/// Deviations of one level, whose points are 2^j samples apart.
void append_points(const allan::ThinnedLevel& level, std::size_t spacing, std::vector<AllanStream::Point>& result) {
  const std::span<const allan::KindSums> phase = level.phase().sums();
  const allan::KindSums& modified = level.means().sums().front();
  const std::span<const std::size_t> multiples = level.phase().multiples();
  for (std::size_t k = 0; k < multiples.size(); ++k) {
    const std::size_t m = multiples[k] * spacing;
    const auto deviation = [&](const allan::KindSums& of) {
      return allan::deviation_of(of.kind, of.sums[k], m, multiples[k]);
    };
    if (phase[0].sums[k].terms == 0) return;
    result.push_back({m, deviation(phase[0]), deviation(modified), deviation(phase[1]), phase[0].sums[k].terms});
  }
}

}  // namespace

base::Result<AllanStream> AllanStream::create(double rate_hz, std::size_t bridge) {
  if (auto status = allan::check_rate_hz(rate_hz); !status) return base::forward_error(status);
  return AllanStream(std::make_unique<Impl>(rate_hz, bridge));
}

AllanStream::AllanStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AllanStream::AllanStream(AllanStream&&) noexcept = default;
AllanStream& AllanStream::operator=(AllanStream&&) noexcept = default;
AllanStream::~AllanStream() = default;

base::Status AllanStream::push(std::span<const double> rate) {
  if (auto status = allan::check_samples(rate, impl_->samples); !status) return status;
  impl_->samples += rate.size();
  for (const double value : rate) impl_->integrator.take(value, *impl_);
  impl_->hand_on();
  return {};
}

std::vector<AllanStream::Point> AllanStream::points() const {
  std::vector<Point> result;
  std::size_t spacing = 1;
  for (const allan::ThinnedLevel& level : impl_->levels) {
    allan::ThinnedLevel so_far = level;
    so_far.end_stretch();
    append_points(so_far, spacing, result);
    spacing *= 2;
  }
  return result;
}

double AllanStream::interval_s() const { return impl_->interval_s; }

const GapReport& AllanStream::gaps() const { return impl_->integrator.gaps(); }

const std::vector<std::size_t>& AllanStream::stretches() const { return impl_->stretches; }

}  // namespace soak::calib::signal
