// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "db/run/sample.h"

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

/// The same where it is stored: bytes of somebody else.
struct StoredColumn {
  std::uint64_t rows = 0;
  std::uint64_t values = 0;
  std::string_view codec;
  std::span<const std::uint8_t> presence;
  std::span<const std::uint8_t> data;

  StoredColumn() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a view of it, as a string_view is of a string
  StoredColumn(const EncodedColumn& encoded)
      : rows(encoded.rows),
        values(encoded.values),
        codec(encoded.codec),
        presence(encoded.presence),
        data(encoded.data) {}
};

/// CRC-32C over identity, sizes, codec and bytes of a stored chunk: a flipped byte, and a chunk in a place that is not
/// its own, do not go unnoticed.
[[nodiscard]] std::uint32_t checksum_of(const StoredColumn& encoded, std::int64_t channel_id, std::uint64_t first_row);

/// How much time a column is worth.
enum class Effort : std::uint8_t {
  smallest,  ///< with the transform that promises the smallest result
  quick,     ///< the words as they are, without a choice: for rows that are soon encoded again
};

/// Encodes columns without loss. One thread at a time.
class ColumnEncoder {
 public:
  /// `column` has at most kMaxChunkRows rows.
  [[nodiscard]] EncodedColumn encode(const Column& column, Effort effort = Effort::smallest);

 private:
  ZstdCompressor compressor_;
};

/// Words of each width while they are decoded.
using WordBuffers = std::tuple<std::vector<std::uint8_t>, std::vector<std::uint16_t>, std::vector<std::uint32_t>,
                               std::vector<std::uint64_t>>;

/// Decodes what ColumnEncoder made. One thread at a time.
class ColumnDecoder {
 public:
  /// Corrupt where sizes, bitmap, codec or frames do not fit each other; memory is bounded by kMaxChunkRows.
  [[nodiscard]] base::Result<Column> decode(const StoredColumn& encoded, SampleType type);
  /// The same into a column whose memory is used again. After an error its content is undefined.
  [[nodiscard]] base::Status decode(const StoredColumn& encoded, SampleType type, Column& column);

 private:
  [[nodiscard]] base::Status decode_presence(const StoredColumn& encoded, std::vector<std::uint8_t>& present);

  ZstdDecompressor decompressor_;
  base::Bytes content_;
  base::Bytes packed_;
  WordBuffers words_;
};

}  // namespace soak::db::codec
