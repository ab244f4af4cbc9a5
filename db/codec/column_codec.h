// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/bytes.h"
#include "base/result.h"
#include "db/codec/zstd_frame.h"
#include "db/sample.h"

namespace soak::db::codec {

/// Rows that a chunk may hold at most: what bounds the memory that a hostile file can ask for.
inline constexpr std::size_t kMaxChunkRows = 65536;

/// A stretch of one column as it is stored.
struct EncodedColumn {
  std::uint64_t rows = 0;
  std::uint64_t values = 0;  ///< present ones
  std::string codec;         ///< [decimal+][rotate+|offset+|delta+|delta2+]shuffle+zstd
  base::Bytes presence;      ///< zstd frame of one bit per row, lowest first; empty = all present
  base::Bytes data;          ///< zstd frame of the present values' byte planes
};

/// CRC-32C over identity, sizes, codec and bytes of a stored chunk: a flipped byte, and a chunk in a place that is not
/// its own, do not go unnoticed.
[[nodiscard]] std::uint32_t checksum_of(const EncodedColumn& encoded, std::int64_t channel_id, std::uint64_t first_row);

/// Encodes columns without loss, with the transform that promises the smallest result. One thread at a time.
class ColumnEncoder {
 public:
  /// `column` has at most kMaxChunkRows rows.
  [[nodiscard]] EncodedColumn encode(const Column& column);

 private:
  ZstdCompressor compressor_;
};

/// Decodes what ColumnEncoder made. One thread at a time.
class ColumnDecoder {
 public:
  /// Corrupt where sizes, bitmap, codec or frames do not fit each other; memory is bounded by kMaxChunkRows.
  [[nodiscard]] base::Result<Column> decode(const EncodedColumn& encoded, SampleType type);

 private:
  [[nodiscard]] base::Result<std::vector<std::uint8_t>> presence_of(const EncodedColumn& encoded);

  ZstdDecompressor decompressor_;
};

}  // namespace soak::db::codec
