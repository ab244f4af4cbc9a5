// SPDX-License-Identifier: Apache-2.0
#include "calib/segments/data_gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "calib/segments/detail/gate.h"
#include "calib/segments/statistics.h"

namespace soak::calib {
namespace {

/// Dropouts and irregular sampling. `rows`: what is known of the rows' times, or becomes known now.
void judge_times(const gate::Samples& samples, gate::KnownTimes& rows, gate::SensorSummary& summary) {
  const double interval_s = samples.facts().interval_s;
  gate::KnownTimes times = rows;
  if (!summary.complete || rows.interval_s != interval_s) {
    const auto t_s = samples.present.t_s();
    times = {interval_s, gate::loss_of(samples.view.t_s(), t_s, interval_s), gate::share_off(t_s, interval_s)};
    if (summary.complete) rows = times;
  }
  summary.dropouts = gate::dropouts(samples, times.loss);
  summary.sampling_judged = !summary.dropouts && times.share_off;
  if (summary.sampling_judged) summary.irregular_sampling = gate::irregular_sampling(samples, *times.share_off);
}

/// Those that its statistics leave out: none where they count every sample.
std::vector<std::size_t> spikes_of(const gate::Samples& samples, std::span<const double> values) {
  const std::size_t counted = samples.view.segment.sensor[index_of(samples.sensor)].count;
  if (counted >= samples.present.values().size()) return {};
  return find_spikes(values, gate::step_of(samples.view, samples.sensor));
}

/// The values, spikes with the number before them.
std::vector<double> without(std::span<const std::size_t> spikes, std::span<const double> values) {
  std::vector<double> healed(values.begin(), values.end());
  for (const std::size_t row : spikes) healed[row] = row > 0 ? healed[row - 1] : healed[row + 1];
  return healed;
}

}  // namespace

namespace gate {

void summarise(const View& segment, Sensor sensor, const Present& present, std::span<const double> values,
               SegmentState& state, KnownTimes& known) {
  const Samples samples{segment, sensor, present};
  SensorSummary& summary = state.sensor[index_of(sensor)];
  summary.recorded = true;
  summary.complete = present.complete();
  summary.samples = present.values().size();
  summary.levels = levels_of(segment.t_s(), values, state.stretches,
                             std::max(samples.facts().noise, samples.facts().step), segment.limits.knock_sigmas);
  if (samples.facts().interval_s > 0.0) judge_times(samples, known, summary);
  summary.spikes = spikes_of(samples, values);
  const auto& spikes = summary.spikes;
  const std::vector<double> healed = spikes.empty() ? std::vector<double>() : without(spikes, values);
  const Present rest(segment.t_s(), spikes.empty() ? values : healed, summary.complete);
  const Samples judged{segment, sensor, rest};
  summary.saturated = saturated(judged);
  if (!summary.saturated) summary.stuck = stuck(judged);
}

}  // namespace gate

struct Examination::Impl {
  const Recording& recording;
  std::span<const Segment> segments;
  UnitType type;
  GateLimits limits;
  gate::Facts facts;
  double row_interval_s = 0.0;
  std::vector<gate::SegmentState> states;
  std::vector<gate::KnownTimes> known;

  [[nodiscard]] gate::View view(std::size_t index) const {
    return {recording, segments, segments[index], type, limits, facts, states[index]};
  }
};

Examination::Examination(const Recording& recording, std::span<const Segment> segments, const UnitType& type,
                         const GateLimits& limits)
    : impl_(new Impl{recording, segments, type, limits, gate::run_facts(recording, segments), 0.0, {}, {}}) {
  for (const Segment& segment : segments) {
    const auto [first, last] = gate::rows_of(recording, segment);
    const std::span<const double> t_s(recording.t_s.data() + first, last - first);
    impl_->states.push_back({first, last, gate::stretches(t_s), {}});
  }
  impl_->known.resize(segments.size());
  impl_->row_interval_s = gate::row_interval_s(recording, impl_->states);
}

Examination::~Examination() = default;

void Examination::add(Sensor sensor, std::span<const double> samples) {
  const auto rows_of = [&](const gate::SegmentState& state) {
    return samples.subspan(state.first, state.last - state.first);
  };
  std::vector<gate::Present> presents;
  for (std::size_t i = 0; i < impl_->states.size(); ++i) {
    const gate::View view = impl_->view(i);
    const bool complete = view.segment.sensor[index_of(sensor)].count == view.rows();
    presents.emplace_back(view.t_s(), rows_of(impl_->states[i]), complete);
  }
  impl_->facts.sensor[index_of(sensor)] = gate::sensor_facts(presents, impl_->row_interval_s);
  for (std::size_t i = 0; i < impl_->states.size(); ++i) {
    gate::summarise(impl_->view(i), sensor, presents[i], rows_of(impl_->states[i]), impl_->states[i], impl_->known[i]);
  }
}

std::vector<std::vector<Finding>> Examination::findings() const {
  impl_->facts.attitude = gate::attitude_facts(impl_->segments, impl_->type);
  std::vector<std::vector<Finding>> findings;
  for (std::size_t i = 0; i < impl_->states.size(); ++i) {
    auto& found = findings.emplace_back();
    for (const gate::Check check : gate::kChecks) check(impl_->view(i), found);
  }
  return findings;
}

std::vector<std::vector<Finding>> examine(const Recording& recording, std::span<const Segment> segments,
                                          const UnitType& type, const GateLimits& limits) {
  Examination examination(recording, segments, type, limits);
  for (const Sensor sensor : kSensors) {
    const std::vector<double>& samples = recording.sensor[index_of(sensor)];
    if (!samples.empty()) examination.add(sensor, samples);
  }
  return examination.findings();
}

}  // namespace soak::calib
