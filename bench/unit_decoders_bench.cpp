// SPDX-License-Identifier: Apache-2.0
// Streams of bytes to packets, on one core. The limits are a copy and a sum of the same bytes.
#include <benchmark/benchmark.h>

#include <numeric>
#include <vector>

#include "hal/imu/detail/ahrs400_decoder.h"
#include "hal/imu/detail/vectornav_frame.h"
#include "hal/imu/detail/xsens_frames.h"
#include "tests/hal/ahrs400_peer.h"
#include "tests/hal/vectornav_peer.h"
#include "tests/hal/xsens_peer.h"

namespace soak::hal::imu {
namespace {

using test::Bytes;

/// About a megabyte, in pieces as they are read.
constexpr int kPackets = 20000;
constexpr std::size_t kPiece = 4096;

template <class Make>
Bytes stream_of(Make make) {
  Bytes all;
  for (int i = 0; i < kPackets; ++i) {
    const Bytes packet = make();
    all.insert(all.end(), packet.begin(), packet.end());
  }
  return all;
}

const Bytes& xsens_stream() {
  static const Bytes bytes = [unit = test::ScriptedUnit()]() mutable {
    return stream_of([&] { return unit.packet(); });
  }();
  return bytes;
}

const Bytes& ahrs400_stream() {
  static const Bytes bytes = [unit = test::Ahrs400Unit()]() mutable {
    return stream_of([&] {
      unit.time_s += 0.0155;
      return unit.packet();
    });
  }();
  return bytes;
}

const Bytes& vectornav_stream() {
  static const Bytes bytes = [unit = test::VectorNavUnit()]() mutable {
    unit.common = 0x0001;
    unit.imu = 0x0E10;
    unit.divisor = 16;
    return stream_of([&] { return unit.packet(); });
  }();
  return bytes;
}

template <class Decoder, class Take>
void decode(benchmark::State& state, const Bytes& stream, Take take) {
  for ([[maybe_unused]] auto _ : state) {
    Decoder decoder;
    int packets = 0;
    for (std::size_t at = 0; at < stream.size(); at += kPiece) {
      decoder.append(std::span(stream).subspan(at, std::min(kPiece, stream.size() - at)));
      while (const auto message = decoder.next()) packets += take(*message) ? 1 : 0;
    }
    if (packets < kPackets - 1) state.SkipWithError("packets are missing");
  }
  state.SetBytesProcessed(state.iterations() * std::ssize(stream));
}

void BM_Xsens(benchmark::State& state) {
  decode<XbusDecoder>(state, xsens_stream(),
                      [](const XbusMessage& message) { return decode_mt_data2(message.data).has_value(); });
}

void BM_Ahrs400(benchmark::State& state) {
  decode<Ahrs400Decoder>(state, ahrs400_stream(), [](const Ahrs400Packet& packet) {
    benchmark::DoNotOptimize(ahrs400_temp_c(packet.temp));
    return true;
  });
}

void BM_VectorNav(benchmark::State& state) {
  decode<VectorNavDecoder>(state, vectornav_stream(), [](const VectorNavMessage& message) {
    return decode_vectornav(message).time_ns.has_value();
  });
}

void BM_CopyOfTheBytes(benchmark::State& state) {
  const Bytes& stream = xsens_stream();
  Bytes copy(stream.size());
  for ([[maybe_unused]] auto _ : state) {
    std::copy(stream.begin(), stream.end(), copy.begin());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * std::ssize(stream));
}

void BM_SumOfTheBytes(benchmark::State& state) {
  const Bytes& stream = xsens_stream();
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(std::accumulate(stream.begin(), stream.end(), 0U));
  }
  state.SetBytesProcessed(state.iterations() * std::ssize(stream));
}

BENCHMARK(BM_Xsens);
BENCHMARK(BM_Ahrs400);
BENCHMARK(BM_VectorNav);
BENCHMARK(BM_CopyOfTheBytes);
BENCHMARK(BM_SumOfTheBytes);

}  // namespace
}  // namespace soak::hal::imu
