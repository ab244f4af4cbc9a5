// SPDX-License-Identifier: Apache-2.0
#include "db/detail/column_codec.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "db/detail/transform.h"

namespace soak::db::codec {
namespace {

/// Measured on shuffled noise: short matches cost more than the entropy coding of the bytes that they replace, and the
/// levels that know that gain half a percent at a tenth of the speed.
constexpr int kLevel = 1;
constexpr int kShortestMatch = 7;

/// Room for the header and the end of a block that a flush forces.
constexpr std::size_t kBytesPerFlush = 32;

constexpr std::string_view kDecimalPrefix = "decimal+";
constexpr std::string_view kCodecEnd = "shuffle+zstd";

bool is_float(SampleType type) { return type == SampleType::f32 || type == SampleType::f64; }
bool is_signed(SampleType type) { return type != SampleType::u8 && type != SampleType::u16 && type != SampleType::u32; }

/// The choice of a transform looks at so many runs of so many words each: as sure as all of a chunk, for an eighth of
/// the time. Each run is long beside its first word, whose difference to the run before means nothing.
constexpr std::size_t kSampledRuns = 8;
constexpr std::size_t kSampledRunWords = 256;

/// How the words of a chunk are written.
struct Choice {
  bool decimal = false;
  Transform transform = Transform::plain;
  double cost = std::numeric_limits<double>::infinity();  ///< bytes, of the words that the choice has seen
};

/// Byte planes of the transformed words, then the footer: the number of decimals (1 byte, only with "decimal+"), then
/// the reference word (only with "offset+").
struct Planes {
  std::string codec;
  base::Bytes bytes;
};

/// Calls `work` with an unsigned number of `size` bytes, for its type.
template <class Work>
auto with_word_of(std::size_t size, const Work& work) {
  if (size == 1) return work(std::uint8_t{});
  if (size == 2) return work(std::uint16_t{});
  return size == 4 ? work(std::uint32_t{}) : work(std::uint64_t{});
}

template <class Word>
std::vector<Word> words_from(std::span<const std::uint8_t> bytes) {
  std::vector<Word> words(bytes.size() / sizeof(Word));
  if (!words.empty()) std::memcpy(words.data(), bytes.data(), bytes.size());
  return words;
}

template <class Word>
Word least_of(std::span<const Word> words, bool as_signed) {
  if (words.empty()) return 0;
  if (!as_signed) return *std::min_element(words.begin(), words.end());
  using Signed = std::make_signed_t<Word>;
  return *std::min_element(words.begin(), words.end(),
                           [](Word a, Word b) { return static_cast<Signed>(a) < static_cast<Signed>(b); });
}

/// Runs of the words, spread evenly; all words where there are few.
template <class Number>
std::vector<Number> sample_of(const std::vector<Number>& words) {
  if (words.size() <= kSampledRuns * kSampledRunWords) return words;
  std::vector<Number> sample;
  sample.reserve(kSampledRuns * kSampledRunWords);
  for (std::size_t run = 0; run < kSampledRuns; ++run) {
    const auto first =
        words.begin() + static_cast<std::ptrdiff_t>(run * (words.size() - kSampledRunWords) / (kSampledRuns - 1));
    sample.insert(sample.end(), first, first + kSampledRunWords);
  }
  return sample;
}

/// The transform of the words that promises the smallest result, if it is below `best`.
template <class Word>
Choice better_of(const Choice& best, const std::vector<Word>& words, bool as_signed, bool decimal) {
  Choice better = best;
  const Word reference = least_of(std::span(words), as_signed);
  for (const Transform transform : kTransforms) {
    std::vector<Word> transformed = words;
    apply(transform, std::span(transformed), reference);
    const double cost = entropy_bytes(shuffled(std::span<const Word>(transformed)), words.size());
    if (cost < better.cost) better = {decimal, transform, cost};
  }
  return better;
}

template <class Word>
Planes planes_of(std::vector<Word> words, Transform transform, bool as_signed, std::optional<unsigned> digits) {
  const Word reference = transform == Transform::offset ? least_of(std::span<const Word>(words), as_signed) : Word{0};
  apply(transform, std::span(words), reference);
  base::Bytes bytes = shuffled(std::span<const Word>(words));
  if (digits) bytes.push_back(static_cast<std::uint8_t>(*digits));
  if (transform == Transform::offset) {
    base::ByteWriter footer;
    footer.write(reference);
    bytes.insert(bytes.end(), footer.bytes().begin(), footer.bytes().end());
  }
  std::string codec(digits ? kDecimalPrefix : "");
  return {codec.append(name_of(transform)).append(kCodecEnd), std::move(bytes)};
}

template <class Word>
Planes best_of_integers(std::span<const std::uint8_t> bytes, bool as_signed) {
  auto words = words_from<Word>(bytes);
  const Choice best = better_of<Word>({}, sample_of(words), as_signed, false);
  return planes_of(std::move(words), best.transform, as_signed, {});
}

/// Short decimals as whole numbers, where the sample and then every number of the chunk are such.
template <class Number, class Word>
Planes best_of_floats(std::span<const std::uint8_t> bytes) {
  auto words = words_from<Word>(bytes);
  const Choice best = better_of<Word>({}, sample_of(words), false, false);
  const auto numbers = words_from<Number>(bytes);
  const auto sample = sample_of(numbers);
  if (const auto some = decimals_of(std::span<const Number>(sample))) {
    const Choice better = better_of(best, some->mantissas, true, true);
    auto all = better.decimal ? decimals_of(std::span<const Number>(numbers)) : std::nullopt;
    if (all) return planes_of(std::move(all->mantissas), better.transform, true, all->digits);
  }
  return planes_of(std::move(words), best.transform, false, {});
}

Planes best_of(std::span<const std::uint8_t> bytes, SampleType type) {
  if (type == SampleType::f32) return best_of_floats<float, std::uint32_t>(bytes);
  if (type == SampleType::f64) return best_of_floats<double, std::uint64_t>(bytes);
  return with_word_of(size_of(type),
                      [&](auto word) { return best_of_integers<decltype(word)>(bytes, is_signed(type)); });
}

Planes plain_of(std::span<const std::uint8_t> bytes, SampleType type) {
  return with_word_of(size_of(type), [&](auto word) {
    return planes_of(words_from<decltype(word)>(bytes), Transform::plain, false, {});
  });
}

/// The present values, one after the other.
base::Bytes packed(const Column& column) {
  if (column.present.empty()) return column.raw;
  const std::size_t size = size_of(column.type);
  base::Bytes values;
  for (std::size_t row = 0; row < column.present.size(); ++row) {
    if (column.present[row] == 0) continue;
    const auto first = column.raw.begin() + static_cast<std::ptrdiff_t>(row * size);
    values.insert(values.end(), first, first + static_cast<std::ptrdiff_t>(size));
  }
  return values;
}

/// Undoes packed(): the values in the rows that have one, zeros in the others.
void spread(const base::Bytes& values, const std::vector<std::uint8_t>& present, std::size_t size, base::Bytes& raw) {
  raw.assign(present.size() * size, 0);
  std::size_t next = 0;
  for (std::size_t row = 0; row < present.size(); ++row) {
    if (present[row] == 0) continue;
    std::memcpy(raw.data() + row * size, values.data() + next, size);
    next += size;
  }
}

base::Bytes bitmap_of(const std::vector<std::uint8_t>& present) {
  base::Bytes bitmap((present.size() + 7) / 8, 0);
  for (std::size_t row = 0; row < present.size(); ++row) {
    if (present[row] != 0) bitmap[row / 8] = static_cast<std::uint8_t>(bitmap[row / 8] | (1U << (row % 8)));
  }
  return bitmap;
}

struct ParsedCodec {
  bool decimal = false;
  Transform transform = Transform::plain;
};

std::optional<ParsedCodec> parse_codec(std::string_view codec) {
  ParsedCodec parsed;
  parsed.decimal = codec.starts_with(kDecimalPrefix);
  if (parsed.decimal) codec.remove_prefix(kDecimalPrefix.size());
  for (const Transform transform : kTransforms) {
    if (codec != std::string(name_of(transform)).append(kCodecEnd)) continue;
    parsed.transform = transform;
    return parsed;
  }
  return std::nullopt;
}

/// Words from planes and footer, in their buffer; `footer` starts at the reference word.
template <class Word>
std::span<const Word> words_of(std::span<const std::uint8_t> planes, Transform transform,
                               std::span<const std::uint8_t> footer, WordBuffers& buffers) {
  auto& words = std::get<std::vector<Word>>(buffers);
  words.resize(planes.size() / sizeof(Word));
  unshuffle(planes, std::span(words));
  const Word reference = base::ByteReader(footer).read<Word>().value_or(0);
  undo(transform, std::span(words), reference);
  return words;
}

template <class T>
void put(std::span<const T> numbers, base::Bytes& raw) {
  raw.resize(numbers.size_bytes());
  if (!numbers.empty()) std::memcpy(raw.data(), numbers.data(), numbers.size_bytes());
}

template <class Number>
void put_decimals(std::span<const std::uint64_t> mantissas, unsigned digits, base::Bytes& raw) {
  raw.resize(mantissas.size() * sizeof(Number));
  for (std::size_t i = 0; i < mantissas.size(); ++i) {
    const auto number = decimal_value<Number>(mantissas[i], digits);
    std::memcpy(raw.data() + i * sizeof(Number), &number, sizeof(Number));
  }
}

/// Values from the content of a data frame whose length has been checked.
base::Status put_values(const base::Bytes& content, std::size_t count, const ParsedCodec& codec, SampleType type,
                        WordBuffers& buffers, base::Bytes& raw) {
  const std::size_t width = codec.decimal ? sizeof(std::uint64_t) : size_of(type);
  const auto planes = std::span(content).first(count * width);
  const auto footer = std::span(content).subspan(count * width);
  if (codec.decimal) {
    const unsigned digits = footer.front();
    if (digits > kMaxDecimalDigits) return base::corrupt("a number of decimals is out of range");
    const auto mantissas = words_of<std::uint64_t>(planes, codec.transform, footer.subspan(1), buffers);
    type == SampleType::f32 ? put_decimals<float>(mantissas, digits, raw)
                            : put_decimals<double>(mantissas, digits, raw);
  } else {
    with_word_of(width,
                 [&](auto word) { put(words_of<decltype(word)>(planes, codec.transform, footer, buffers), raw); });
  }
  return {};
}

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

std::uint32_t checksum_of(const StoredColumn& encoded, std::int64_t channel_id, std::uint64_t first_row) {
  base::ByteWriter header;
  header.write(channel_id);
  header.write(first_row);
  header.write(encoded.rows);
  header.write(encoded.values);
  header.write_text16(encoded.codec);
  const std::uint32_t with_presence = base::crc32c(encoded.presence, base::crc32c(header.bytes()));
  return base::crc32c(encoded.data, with_presence);
}

EncodedColumn ColumnEncoder::encode(const Column& column, Effort effort) {
  EncodedColumn encoded;
  encoded.rows = column.rows();
  const base::Bytes values = packed(column);
  encoded.values = values.size() / size_of(column.type);
  if (encoded.values < encoded.rows) encoded.presence = compressor_.compress(bitmap_of(column.present), 0);
  Planes planes = effort == Effort::quick ? plain_of(values, column.type) : best_of(values, column.type);
  encoded.codec = std::move(planes.codec);
  encoded.data = compressor_.compress(planes.bytes, encoded.values);
  return encoded;
}

base::Status ColumnDecoder::decode_presence(const StoredColumn& encoded, std::vector<std::uint8_t>& present) {
  present.clear();
  if (encoded.presence.empty()) {
    if (encoded.values != encoded.rows) return base::corrupt("values are missing without a bitmap that says which");
    return {};
  }
  auto unpacked = decompressor_.decompress(encoded.presence, (encoded.rows + 7) / 8, content_);
  if (!unpacked) return unpacked;
  present.resize(encoded.rows);
  std::uint64_t count = 0;
  for (std::size_t row = 0; row < present.size(); ++row) {
    present[row] = static_cast<std::uint8_t>((content_[row / 8] >> (row % 8)) & 1U);
    count += present[row];
  }
  if (count != encoded.values) return base::corrupt("the bitmap of present values does not match their number");
  return {};
}

base::Status ColumnDecoder::decode(const StoredColumn& encoded, SampleType type, Column& column) {
  if (encoded.rows == 0 || encoded.rows > kMaxChunkRows || encoded.values > encoded.rows) {
    return base::corrupt("the number of rows or values is out of range");
  }
  const auto codec = parse_codec(encoded.codec);
  if (!codec || (codec->decimal && !is_float(type))) {
    return base::corrupt("unknown codec '" + std::string(encoded.codec) + "'; a newer program may have written it");
  }
  column.type = type;
  if (const auto decoded = decode_presence(encoded, column.present); !decoded) return decoded;
  const std::size_t width = codec->decimal ? sizeof(std::uint64_t) : size_of(type);
  const std::size_t footer =
      (codec->decimal ? 1U : 0U) + (codec->transform == Transform::offset ? width : std::size_t{0});
  auto unpacked = decompressor_.decompress(encoded.data, encoded.values * width + footer, content_);
  if (!unpacked) return unpacked;
  base::Bytes& values = column.present.empty() ? column.raw : packed_;
  if (auto put = put_values(content_, encoded.values, *codec, type, words_, values); !put) return put;
  if (!column.present.empty()) spread(packed_, column.present, size_of(type), column.raw);
  return {};
}

base::Result<Column> ColumnDecoder::decode(const StoredColumn& encoded, SampleType type) {
  Column column;
  if (const auto decoded = decode(encoded, type, column); !decoded) return base::forward_error(decoded);
  return column;
}

}  // namespace soak::db::codec
