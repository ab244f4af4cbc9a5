// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan_stream.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "calib/signal/allan/detail/differences.h"
#include "calib/signal/samples/sample_grid.h"

namespace soak::calib::signal {
namespace allan {
namespace {

constexpr std::array kOfPhase = {AllanKind::overlapping, AllanKind::overlapping_hadamard};
constexpr std::array kOfMeans = {AllanKind::modified};

void keep_every_second(std::vector<double>& points, bool& skip) {
  std::size_t kept = 0;
  for (const double x : points) {
    if (!skip) points[kept++] = x;
    skip = !skip;
  }
  points.resize(kept);
}

void keep_means_of_pairs(std::vector<double>& means, std::optional<double>& first_half) {
  std::size_t kept = 0;
  for (const double x : means) {
    if (first_half) {
      means[kept++] = 0.5 * (*first_half + x);
      first_half.reset();
    } else {
      first_half = x;
    }
  }
  means.resize(kept);
}

}  // namespace

/// Squared differences of one kind at several multiples.
struct KindSums {
  AllanKind kind = AllanKind::overlapping;
  std::vector<SquareSum> sums;
};

/// Sums of squared differences of points that come in piece by piece. Keeps the points from the beginning of the first
/// block that is not added up yet: at most a block and three times the longest multiple.
class BlockWindow {
 public:
  /// Overlapping kinds; multiples up to kBlock.
  BlockWindow(std::span<const AllanKind> kinds, std::span<const std::size_t> multiples)
      : multiples_(multiples.begin(), multiples.end()), capacity_(kBlock + 3 * multiples_.back()) {
    for (const AllanKind kind : kinds) sums_.push_back({kind, std::vector<SquareSum>(multiples_.size())});
  }

  void add(std::span<const double> points) {
    while (!points.empty()) {
      const std::span<const double> fit = points.first(std::min(points.size(), capacity_ - window_.size()));
      window_.insert(window_.end(), fit.begin(), fit.end());
      points = points.subspan(fit.size());
      if (window_.size() < capacity_) return;
      for (KindSums& of : sums_) add_block(of.kind, window_, multiples_, of.sums);
      window_.erase(window_.begin(), std::next(window_.begin(), kBlock));
    }
  }

  /// Adds up what is left; no difference reaches on to the points that follow.
  void end_stretch() {
    for (KindSums& of : sums_) add_blocks(of.kind, window_, multiples_, of.sums);
    window_.clear();
  }

  /// Of the blocks that are complete and the stretches that have ended, one entry per kind.
  [[nodiscard]] std::span<const KindSums> sums() const { return sums_; }
  [[nodiscard]] std::span<const std::size_t> multiples() const { return multiples_; }

 private:
  std::vector<std::size_t> multiples_;
  std::size_t capacity_;
  std::vector<KindSums> sums_;
  std::vector<double> window_;
};

/// A stretch thinned by a power of two: every 2^j-th phase point for the Allan and Hadamard deviations, the means of
/// 2^j phase points for the modified Allan deviation, whose windows consist of such means.
class ThinnedLevel {
 public:
  /// Multiples in points of this level.
  explicit ThinnedLevel(std::span<const std::size_t> multiples)
      : phase_(kOfPhase, multiples), means_(kOfMeans, multiples) {}

  /// Takes the next phase points and means, and leaves in their place what goes on to the next level: every second
  /// point from the first of the stretch on, and the means of pairs.
  void add(std::vector<double>& points, std::vector<double>& means) {
    phase_.add(points);
    means_.add(means);
    keep_every_second(points, skip_);
    keep_means_of_pairs(means, first_half_);
  }

  void end_stretch() {
    phase_.end_stretch();
    means_.end_stretch();
    skip_ = false;
    first_half_.reset();
  }

  [[nodiscard]] const BlockWindow& phase() const { return phase_; }  ///< overlapping Allan, overlapping Hadamard
  [[nodiscard]] const BlockWindow& means() const { return means_; }  ///< modified Allan

 private:
  BlockWindow phase_;
  BlockWindow means_;
  bool skip_ = false;                 ///< the next phase point
  std::optional<double> first_half_;  ///< of a pair of means that is not complete
};

}  // namespace allan

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
    feed_levels();
    for (allan::ThinnedLevel& level : levels) level.end_stretch();
    stretches.push_back(0);
  }

  void point(double x) {
    points.push_back(x);
    ++stretches.back();
    if (points.size() == kBatch) feed_levels();
  }

  void feed_levels() {
    means = points;
    for (allan::ThinnedLevel& level : levels) {
      if (points.empty() && means.empty()) break;
      level.add(points, means);
    }
    points.clear();
  }
};

base::Result<AllanStream> AllanStream::create(double rate_hz, std::size_t bridge) {
  if (auto status = check_rate(rate_hz); !status) return base::forward_error(status);
  return AllanStream(std::make_unique<Impl>(rate_hz, bridge));
}

AllanStream::AllanStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AllanStream::AllanStream(AllanStream&&) noexcept = default;
AllanStream& AllanStream::operator=(AllanStream&&) noexcept = default;
AllanStream::~AllanStream() = default;

base::Status AllanStream::push(std::span<const double> rate) {
  if (auto status = check_none_infinite(rate, impl_->samples); !status) return status;
  impl_->samples += rate.size();
  for (const double value : rate) impl_->integrator.take(value, *impl_);
  impl_->feed_levels();
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

const MissingSamples& AllanStream::gaps() const { return impl_->integrator.gaps(); }

const std::vector<std::size_t>& AllanStream::stretches() const { return impl_->stretches; }

}  // namespace soak::calib::signal
