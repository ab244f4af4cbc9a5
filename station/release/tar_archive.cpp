// SPDX-License-Identifier: Apache-2.0
#include "station/release/tar_archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

namespace soak::station {
namespace {

constexpr std::size_t kTarBlock = 512;
constexpr std::size_t kLongestTarName = 100;
constexpr std::size_t kLongestTarPrefix = 155;
constexpr std::uint64_t kMostTarBytes = std::uint64_t{1} << 33U;  // eleven octal digits

// Where the fields of a header begin.
constexpr std::size_t kModeAt = 100;
constexpr std::size_t kOwnerAt = 108;
constexpr std::size_t kGroupAt = 116;
constexpr std::size_t kSizeAt = 124;
constexpr std::size_t kTimeAt = 136;
constexpr std::size_t kChecksumAt = 148;
constexpr std::size_t kTypeAt = 156;
constexpr std::size_t kMagicAt = 257;
constexpr std::size_t kPrefixAt = 345;

void put_field(std::string& header, std::size_t at, std::string_view text) {
  std::ranges::copy(text, header.begin() + static_cast<std::ptrdiff_t>(at));
}

/// A path as a header holds it: `prefix` and `name` with a slash between them.
struct TarName {
  std::string_view prefix;
  std::string_view name;
};

/// Nothing where there is no slash at which both parts have room.
std::optional<TarName> split_name(std::string_view path) {
  if (path.empty()) return std::nullopt;
  if (path.size() <= kLongestTarName) return TarName{{}, path};
  const std::size_t slash = path.find('/', path.size() - kLongestTarName - 1);
  if (slash == std::string_view::npos || slash == 0 || slash > kLongestTarPrefix || slash + 1 == path.size()) {
    return std::nullopt;
  }
  return TarName{path.substr(0, slash), path.substr(slash + 1)};
}

/// The checksum counts its own field as spaces.
std::string tar_header(const TarName& path, std::size_t bytes, long long utc_s) {
  std::string header(kTarBlock, '\0');
  put_field(header, 0, path.name);
  put_field(header, kPrefixAt, path.prefix);
  put_field(header, kModeAt, "0000644");
  put_field(header, kOwnerAt, "0000000");
  put_field(header, kGroupAt, "0000000");
  put_field(header, kSizeAt, fmt::format("{:011o}", bytes));
  put_field(header, kTimeAt, fmt::format("{:011o}", utc_s));
  put_field(header, kChecksumAt, "        ");
  put_field(header, kTypeAt, "0");
  put_field(header, kMagicAt, std::string_view("ustar\00000", 8));
  const auto add = [](unsigned sum, char c) { return sum + static_cast<unsigned char>(c); };
  const unsigned sum = std::accumulate(header.begin(), header.end(), 0U, add);
  put_field(header, kChecksumAt, fmt::format("{:06o}", sum));
  header[kChecksumAt + 6] = '\0';
  return header;
}

}  // namespace

TarArchive::TarArchive(double utc_s) : utc_s_(std::max(0LL, std::llround(utc_s))) {}

base::Status TarArchive::add(std::string_view name, std::string_view content) {
  const auto path = split_name(name);
  if (!path) {
    return base::bad_input(fmt::format("a name in a tar file has 1 to {} bytes, its folders at most {} before that",
                                       kLongestTarName, kLongestTarPrefix),
                           std::string(name));
  }
  if (content.size() >= kMostTarBytes) {
    return base::fail(base::ErrorKind::internal, "too large for a tar file", std::string(name));
  }
  bytes_ += tar_header(*path, content.size(), utc_s_);
  bytes_ += content;
  bytes_.append((kTarBlock - content.size() % kTarBlock) % kTarBlock, '\0');
  return {};
}

std::string TarArchive::finish() {
  bytes_.append(2 * kTarBlock, '\0');
  return std::move(bytes_);
}

}  // namespace soak::station
