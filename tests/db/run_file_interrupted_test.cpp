// SPDX-License-Identifier: Apache-2.0
// Run files whose writer came to an end before it could seal them.
#include <array>
#include <csignal>

#include "db/catalog/catalog.h"
#include "tests/db/sample_catalog.h"

namespace soak::db {
namespace {

using testing::column_of;
using testing::in_child;
using testing::noise;
using testing::noise_stream;
using testing::run_info;
using testing::status_of;
using testing::TempFolder;
using testing::times;

constexpr std::size_t kBatch = 700;

/// Adds noise rows `first` to `first + kBatch - 1`, which depend on nothing but `first`.
base::Status append_batch(RunFileWriter& writer, std::size_t first) {
  return writer.append(0, {column_of(times(kBatch, 0.01, first)), column_of(noise(kBatch, first))});
}

/// Writes `flushed` batches and another one that is not flushed, then dies.
void leave_file(const std::filesystem::path& path, std::size_t flushed) {
  const int status = status_of(in_child([&] {
    auto writer = RunFileWriter::create(path, run_info());
    if (!writer || !writer->add_stream(noise_stream())) return 1;
    for (std::size_t i = 0; i < flushed; ++i) {
      if (!append_batch(*writer, i * kBatch) || !writer->flush()) return 2;
    }
    if (!append_batch(*writer, flushed * kBatch)) return 3;
    ::raise(SIGKILL);
    return 4;
  }));
  ASSERT_EQ(status, -SIGKILL);
}

/// What the same rows look like in a file that was never interrupted.
std::string content_of_whole_file(const std::filesystem::path& path, std::size_t batches) {
  auto writer = RunFileWriter::create(path, run_info());
  EXPECT_TRUE(writer->add_stream(noise_stream()));
  for (std::size_t i = 0; i < batches; ++i) EXPECT_TRUE(append_batch(*writer, i * kBatch));
  EXPECT_TRUE(writer->seal());
  return RunFileReader::open(path)->content_hash().value();
}

TEST(InterruptedRunFile, IsSealedWithEverythingThatWasFlushed) {
  // None, a short chunk only, and full chunks (16,384 rows) with a rest.
  for (const std::size_t batches : {0U, 3U, 60U}) {
    const TempFolder folder;
    const auto path = folder / "a.soakrun";
    leave_file(path, batches);
    const auto sha256 = RunFileWriter::seal_interrupted(path, "killed");
    ASSERT_TRUE(sha256) << sha256.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.soakrun-wal"));
    const auto reader = RunFileReader::open(path);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_TRUE(reader->sealed());
    EXPECT_EQ(reader->rows(0), batches * kBatch);
    EXPECT_EQ(*reader->content_hash(), content_of_whole_file(folder / "whole.soakrun", batches));
    ASSERT_EQ(reader->events()->size(), 1U);
    const RunEvent event = reader->events()->front();
    EXPECT_EQ(event.kind, "interrupted");
    EXPECT_EQ(event.text, "killed");
    EXPECT_DOUBLE_EQ(event.t_s, batches == 0 ? 0.0 : static_cast<double>(batches * kBatch - 1) * 0.01);
    // verify() compares the pyramid, which the second writer had to take up in its middle, with the samples.
    const auto whole = reader->verify();
    EXPECT_TRUE(whole) << whole.error().message;
  }
}

TEST(InterruptedRunFile, IsSealedOnceOnly) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  leave_file(path, 2);
  const auto sha256 = RunFileWriter::seal_interrupted(path, "killed");
  ASSERT_TRUE(sha256);
  EXPECT_EQ(*RunFileWriter::seal_interrupted(path, "again"), *sha256);
  EXPECT_EQ(RunFileReader::open(path)->events()->size(), 1U);
}

TEST(InterruptedRunFile, IsLeftAloneWhileItsWriterLives) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  auto writer = RunFileWriter::create(path, run_info());
  ASSERT_TRUE(writer->add_stream(noise_stream()));
  ASSERT_TRUE(append_batch(*writer, 0));
  ASSERT_TRUE(writer->flush());
  const auto refused = status_of(in_child([&] {
    const auto sealed = RunFileWriter::seal_interrupted(path, "impatient");
    return !sealed && sealed.error().kind == base::ErrorKind::bad_input ? 0 : 1;
  }));
  EXPECT_EQ(refused, 0);
  ASSERT_TRUE(append_batch(*writer, kBatch));
  ASSERT_TRUE(writer->seal());
  const auto reader = RunFileReader::open(path);
  EXPECT_EQ(reader->rows(0), 2 * kBatch);
  EXPECT_TRUE(reader->events()->empty());
  EXPECT_TRUE(reader->verify());
}

TEST(InterruptedRunFile, RefusesOtherFiles) {
  const TempFolder folder;
  EXPECT_EQ(RunFileWriter::seal_interrupted(folder / "none.soakrun", "x").error().kind, base::ErrorKind::bad_input);
  EXPECT_FALSE(std::filesystem::exists(folder / "none.soakrun"));
  std::ofstream(folder / "text.soakrun") << std::string(5000, 'x');
  EXPECT_EQ(RunFileWriter::seal_interrupted(folder / "text.soakrun", "x").error().kind, base::ErrorKind::corrupt);
  auto catalog = Catalog::open(folder.path());  // a SQLite file in WAL mode of another kind
  EXPECT_EQ(RunFileWriter::seal_interrupted(folder / "station.db", "x").error().kind, base::ErrorKind::bad_input);
}

TEST(InterruptedRunFile, SurvivesAKillWhileItIsSealed) {
  base::Random random(3);
  for (int kill = 0; kill < 6; ++kill) {
    const TempFolder folder;
    const auto path = folder / "a.soakrun";
    leave_file(path, 30);
    const pid_t child = in_child([&] { return RunFileWriter::seal_interrupted(path, "first") ? 0 : 1; });
    ::usleep(static_cast<useconds_t>(random.uniform(0.0, 20'000.0)));
    ::kill(child, SIGKILL);
    const int status = status_of(child);
    ASSERT_TRUE(status == -SIGKILL || status == 0) << status;
    const auto sha256 = RunFileWriter::seal_interrupted(path, "second");
    ASSERT_TRUE(sha256) << sha256.error().message;
    const auto reader = RunFileReader::open(path);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_EQ(reader->rows(0), 30 * kBatch);
    EXPECT_EQ(reader->events()->size(), 1U);
    EXPECT_TRUE(reader->verify());
  }
}

TEST(OrphanRunFiles, AreThoseThatTheCatalogDoesNotName) {
  const TempFolder folder;
  auto catalog = Catalog::open(folder.path());
  testing::fill(*catalog);
  const auto runs = folder.path() / "runs";
  EXPECT_TRUE(orphan_run_files(*catalog)->empty());
  testing::write_noise_file(runs / (std::string(testing::kRunId) + ".soakrun"), 10);  // in the catalog
  testing::write_noise_file(runs / "b.soakrun", 10);
  leave_file(runs / "c.soakrun", 1);
  std::ofstream(runs / "a.soakrun") << "no SQLite";
  std::ofstream(runs / "d.soakrun.tmp") << "of an import";
  const auto orphans = orphan_run_files(*catalog);
  ASSERT_TRUE(orphans);
  ASSERT_EQ(orphans->size(), 3U);
  EXPECT_EQ((*orphans)[0].path, runs / "a.soakrun");
  EXPECT_FALSE((*orphans)[0].info);
  EXPECT_FALSE((*orphans)[0].problem.empty());
  EXPECT_TRUE((*orphans)[1].sealed);
  EXPECT_EQ((*orphans)[1].info->label, run_info().label);
  EXPECT_EQ((*orphans)[1].units, std::vector<std::string>{"SN1"});
  EXPECT_EQ((*orphans)[2].path, runs / "c.soakrun");
  EXPECT_FALSE((*orphans)[2].sealed);
  EXPECT_TRUE((*orphans)[2].problem.empty());
}

}  // namespace
}  // namespace soak::db
