// SPDX-License-Identifier: Apache-2.0
#include "station/release/tar_archive.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>

namespace soak::station {
namespace {

constexpr std::size_t kPrefixAt = 345;

std::string text_at(const std::string& archive, std::size_t at) { return archive.c_str() + at; }

TEST(TarArchive, AShortPathStandsInOnePiece) {
  TarArchive archive(0.0);
  ASSERT_TRUE(archive.add("hand-over/SN1.soakcal", "x"));
  const std::string bytes = archive.finish();
  EXPECT_EQ(text_at(bytes, 0), "hand-over/SN1.soakcal");
  EXPECT_EQ(text_at(bytes, kPrefixAt), "");
}

TEST(TarArchive, ALongPathIsSplitAtASlash) {
  const std::string folder(150, 'f');
  const std::string file(99, 's');
  TarArchive archive(0.0);
  ASSERT_TRUE(archive.add(folder + '/' + file, "x"));
  const std::string bytes = archive.finish();
  EXPECT_EQ(text_at(bytes, 0), file);
  EXPECT_EQ(text_at(bytes, kPrefixAt), folder);
}

TEST(TarArchive, APathWithoutRoomIsRefused) {
  TarArchive archive(0.0);
  EXPECT_FALSE(archive.add("", "x"));
  EXPECT_FALSE(archive.add(std::string(101, 's'), "x"));
  EXPECT_FALSE(archive.add("folder/" + std::string(101, 's'), "x"));
  EXPECT_FALSE(archive.add(std::string(156, 'f') + "/file", "x"));
  EXPECT_FALSE(archive.add(std::string(120, 'f') + '/', "x"));
}

}  // namespace
}  // namespace soak::station
