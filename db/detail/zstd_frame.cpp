// SPDX-License-Identifier: Apache-2.0
#include "db/detail/zstd_frame.h"

#include <zstd.h>

#include <algorithm>
#include <new>
#include <string>

namespace soak::db::codec {
namespace {

/// Measured on shuffled noise: short matches cost more than the entropy coding of the bytes that they replace, and the
/// levels that know that gain half a percent at a tenth of the speed.
constexpr int kLevel = 1;
constexpr int kShortestMatch = 7;

/// Room for the header and the end of a block that a flush forces.
constexpr std::size_t kBytesPerFlush = 32;

}  // namespace

void ZstdCompressor::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }
void ZstdDecompressor::Free::operator()(ZSTD_DCtx_s* context) const { ZSTD_freeDCtx(context); }

ZstdCompressor::ZstdCompressor() : context_(ZSTD_createCCtx()) {
  if (!context_) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_minMatch, kShortestMatch);
}

base::Bytes ZstdCompressor::compress(std::span<const std::uint8_t> bytes, std::size_t part_size) {
  const std::size_t parts = part_size == 0 ? 1 : bytes.size() / part_size + 1;
  base::Bytes frame(ZSTD_compressBound(bytes.size()) + parts * kBytesPerFlush);
  ZSTD_CCtx_reset(context_.get(), ZSTD_reset_session_only);
  ZSTD_CCtx_setPledgedSrcSize(context_.get(), bytes.size());
  ZSTD_outBuffer out{frame.data(), frame.size(), 0};
  std::size_t begin = 0;
  do {
    const std::size_t end = std::min(bytes.size(), part_size == 0 ? bytes.size() : begin + part_size);
    ZSTD_inBuffer in{bytes.data() + begin, end - begin, 0};
    const auto mode = end == bytes.size() ? ZSTD_e_end : ZSTD_e_flush;
    // The output has room for everything: what remains unwritten after a call can only be an allocation that failed.
    if (ZSTD_compressStream2(context_.get(), &out, &in, mode) != 0) throw std::bad_alloc();
    begin = end;
  } while (begin < bytes.size());
  frame.resize(out.pos);
  frame.shrink_to_fit();
  return frame;
}

ZstdDecompressor::ZstdDecompressor() : context_(ZSTD_createDCtx()) {
  if (!context_) throw std::bad_alloc();
}

base::Status ZstdDecompressor::decompress(std::span<const std::uint8_t> frame, std::size_t size, base::Bytes& content) {
  if (ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size()) {
    return base::corrupt("the compressed data are not exactly one zstd frame");
  }
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != size) {
    return base::corrupt("the compressed data do not hold " + std::to_string(size) + " bytes");
  }
  content.resize(size);
  const std::size_t written =
      ZSTD_decompressDCtx(context_.get(), content.data(), content.size(), frame.data(), frame.size());
  if (ZSTD_isError(written) != 0U) {
    return base::corrupt(std::string("the compressed data do not decode: ") + ZSTD_getErrorName(written));
  }
  if (written != size) return base::corrupt("the compressed data end early");
  return {};
}

}  // namespace soak::db::codec
