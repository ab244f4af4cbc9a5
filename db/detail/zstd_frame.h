// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/bytes.h"
#include "base/result.h"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace soak::db::codec {

/// Makes one zstd frame (RFC 8878) of some bytes. Reusable; one thread at a time.
class ZstdCompressor {
 public:
  ZstdCompressor();
  /// A frame that states its content size. `bytes` is cut into parts of `part_size` (the last may be shorter), each of
  /// which starts a block of its own: parts of unlike statistics then get entropy tables of their own.
  [[nodiscard]] base::Bytes compress(std::span<const std::uint8_t> bytes, std::size_t part_size);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
};

/// Reads zstd frames that nobody vouches for. Reusable; one thread at a time.
class ZstdDecompressor {
 public:
  ZstdDecompressor();
  /// Replaces `content` by that of `frame`, which must be one whole frame of exactly `size` bytes of content; corrupt
  /// otherwise. Memory is bounded by `size` whatever the frame claims; that of `content` is used again.
  [[nodiscard]] base::Status decompress(std::span<const std::uint8_t> frame, std::size_t size, base::Bytes& content);

 private:
  struct Free {
    void operator()(ZSTD_DCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_DCtx_s, Free> context_;
};

}  // namespace soak::db::codec
