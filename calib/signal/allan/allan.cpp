// SPDX-License-Identifier: Apache-2.0
#include "calib/signal/allan/allan.h"

#include <algorithm>
#include <cmath>

#include "calib/signal/allan/detail/differences.h"
#include "calib/signal/samples/sample_grid.h"

namespace soak::calib::signal {
namespace {

struct RecordSink {
  std::vector<double>& phase;
  std::vector<Stretch>& stretches;

  void begin_stretch() { stretches.push_back({phase.size(), 0}); }
  void point(double x) {
    phase.push_back(x);
    ++stretches.back().count;
  }
};

base::Status check_record(std::span<const double> samples, double rate_hz) {
  if (auto status = check_rate(rate_hz); !status) return status;
  return check_none_infinite(samples);
}

}  // namespace

base::Result<PhaseRecord> PhaseRecord::from_rate(std::span<const double> rate, double rate_hz, std::size_t bridge) {
  if (auto status = check_record(rate, rate_hz); !status) return base::forward_error(status);
  PhaseRecord record;
  record.interval_s_ = 1.0 / rate_hz;
  // Each stretch has one point more than samples, and a missing sample between it and the next.
  record.phase_.reserve(rate.size() + 1);
  RecordSink sink{record.phase_, record.stretches_};
  allan::PhaseIntegrator integrator(bridge);
  for (const double value : rate) integrator.take(value, sink);
  record.gaps_ = integrator.gaps();
  if (record.longest(AllanKind::overlapping) == 0) return base::bad_input("the record has no two samples in a row");
  return record;
}

base::Result<PhaseRecord> PhaseRecord::from_phase(std::span<const double> phase, double rate_hz) {
  if (auto status = check_record(phase, rate_hz); !status) return base::forward_error(status);
  PhaseRecord record;
  record.interval_s_ = 1.0 / rate_hz;
  record.phase_.reserve(phase.size());
  RecordSink sink{record.phase_, record.stretches_};
  bool inside = false;
  double first = 0.0;
  for (const double x : phase) {
    if (std::isnan(x)) {
      ++record.gaps_.missing;
      if (inside) ++record.gaps_.gaps;
      inside = false;
      continue;
    }
    if (!inside) {
      sink.begin_stretch();
      first = x;
      inside = true;
    }
    // No deviation depends on where a stretch begins; without that constant the product keeps more digits.
    sink.point((x - first) * rate_hz);
  }
  if (record.longest(AllanKind::overlapping) == 0) return base::bad_input("the record has no three points in a row");
  return record;
}

std::size_t PhaseRecord::longest(AllanKind kind) const {
  std::size_t longest = 0;
  for (const Stretch& stretch : stretches_) longest = std::max(longest, allan::longest_of(kind, stretch.count));
  return longest;
}

AllanPoint allan_point(const PhaseRecord& record, AllanKind kind, std::size_t multiple) {
  return allan_points(record, kind, {&multiple, 1}).front();
}

std::vector<AllanPoint> allan_points(const PhaseRecord& record, AllanKind kind,
                                     std::span<const std::size_t> multiples) {
  std::vector<allan::SquareSum> sums(multiples.size());
  for (const Stretch& stretch : record.stretches()) {
    const std::span<const double> points = record.phase().subspan(stretch.first, stretch.count);
    allan::add_blocks(kind, points, multiples, sums);
    for (std::size_t k = 0; k < multiples.size(); ++k) {
      if (!allan::shares_blocks(kind, multiples[k])) allan::add_stretch(kind, points, multiples[k], sums[k]);
    }
  }
  std::vector<AllanPoint> result;
  for (std::size_t k = 0; k < multiples.size(); ++k) {
    const double deviation = allan::deviation_of(kind, sums[k], multiples[k], multiples[k]);
    result.push_back({multiples[k], deviation, sums[k].terms});
  }
  return result;
}

std::vector<std::size_t> log_spaced_multiples(std::size_t longest, std::size_t per_decade) {
  std::vector<std::size_t> multiples;
  if (longest == 0) return multiples;
  const auto last = static_cast<double>(longest);
  const double steps = std::max(1.0, std::round(static_cast<double>(per_decade) * std::log10(last)));
  for (double k = 0.0; k <= steps; k += 1.0) {
    // round(longest^(k/steps)), each number once
    const auto multiple = static_cast<std::size_t>(std::llround(std::pow(last, k / steps)));
    if (multiples.empty() || multiple > multiples.back()) multiples.push_back(multiple);
  }
  return multiples;
}

}  // namespace soak::calib::signal
