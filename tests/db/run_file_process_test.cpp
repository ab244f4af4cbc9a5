// SPDX-License-Identifier: Apache-2.0
#include <sys/mount.h>
#include <sys/resource.h>

#include <array>
#include <csignal>
#include <optional>

#include "db/run/run_file.h"
#include "tests/db/support.h"

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
using testing::write_noise_file;

/// Writes rows without end and reports the number of rows after each flush to `report`.
int write_for_ever(const std::filesystem::path& path, int report) {
  auto writer = RunFileWriter::create(path, run_info());
  if (!writer || !writer->add_stream(noise_stream())) return 1;
  base::Random random(static_cast<std::uint64_t>(::getpid()));
  for (std::uint64_t rows = 0;;) {
    const auto count = static_cast<std::size_t>(random.uniform(1.0, 3000.0));
    if (!writer->append(0, {column_of(times(count, 0.01, rows)), column_of(noise(count, rows))})) return 2;
    if (!writer->flush()) return 3;
    rows += count;
    if (::write(report, &rows, sizeof rows) != sizeof rows) return 4;
  }
}

TEST(RunFileProcess, LosesNoFlushedRowWhenTheWriterIsKilled) {
  base::Random random(77);
  for (int kill = 0; kill < 8; ++kill) {
    const TempFolder folder;
    const auto path = folder / "a.soakrun";
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = in_child([&] { return write_for_ever(path, pipe[1]); });
    ::close(pipe[1]);
    // The kill comes at some point of the work that follows a random number of flushes.
    const auto flushes = 1 + random.next() % 20;
    std::uint64_t rows = 0;
    for (std::uint64_t i = 0; i < flushes; ++i) ASSERT_EQ(::read(pipe[0], &rows, sizeof rows), sizeof rows);
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    EXPECT_EQ(status_of(child), -SIGKILL);
    for (std::uint64_t later = 0; ::read(pipe[0], &later, sizeof later) == sizeof later;) rows = later;
    ::close(pipe[0]);
    const auto reader = RunFileReader::open(path);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_GE(reader->rows(0), rows);
    const auto whole = reader->verify();
    EXPECT_TRUE(whole) << whole.error().message << " " << whole.error().where;
  }
}

/// In a child that may not make files longer than `bytes`: what a full disk looks like.
int with_file_limit(rlim_t bytes, const std::function<int()>& work) {
  return status_of(in_child([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 100;
    return work();
  }));
}

bool is_disk_full(const base::Error& error, const std::filesystem::path& path) {
  return error.kind == base::ErrorKind::internal && error.where.find(path.string()) != std::string::npos;
}

TEST(RunFileProcess, LeavesNothingBehindWhenTheDiskIsTooFullToCreate) {
  for (const rlim_t limit : {0U, 1000U, 4096U, 9000U}) {
    const TempFolder folder;
    const auto path = folder / "a.soakrun";
    const int status = with_file_limit(limit, [&] {
      const auto writer = RunFileWriter::create(path, run_info());
      return writer ? 1 : is_disk_full(writer.error(), path) ? 0 : 2;
    });
    EXPECT_EQ(status, 0) << "limit " << limit;
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "limit " << limit;
  }
}

TEST(RunFileProcess, KeepsWhatWasFlushedWhenTheDiskFills) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const int status = with_file_limit(1'000'000, [&] {
    auto writer = RunFileWriter::create(path, run_info());
    if (!writer || !writer->add_stream(noise_stream())) return 1;
    for (std::uint64_t rows = 0; rows < 10'000'000;) {
      auto written = writer->append(0, {column_of(times(5000, 0.01, rows)), column_of(noise(5000, rows))});
      if (written) written = writer->flush();
      if (!written) return is_disk_full(written.error(), path) ? 0 : 2;
      rows += 5000;
      if (::write(pipe[1], &rows, sizeof rows) != sizeof rows) return 3;
    }
    return 4;
  });
  EXPECT_EQ(status, 0);
  ::close(pipe[1]);
  std::uint64_t rows = 0;
  for (std::uint64_t later = 0; ::read(pipe[0], &later, sizeof later) == sizeof later;) rows = later;
  ::close(pipe[0]);
  EXPECT_GT(rows, 0U);
  const auto reader = RunFileReader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_GE(reader->rows(0), rows);
  EXPECT_TRUE(reader->verify());
}

TEST(RunFileProcess, WritesTheRowsOfAFailedFlushOnceThereIsRoomAgain) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  const int status = status_of(in_child([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    auto writer = RunFileWriter::create(path, run_info());
    if (!writer || !writer->add_stream(noise_stream())) return 1;
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit tight{100'000, limit.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &tight);
    if (writer->append(0, {column_of(times(60'000, 0.01)), column_of(noise(60'000, 1))})) return 2;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    return writer->seal() ? 0 : 3;
  }));
  EXPECT_EQ(status, 0);
  const auto reader = RunFileReader::open(path);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(*reader->read(0, 1) == column_of(noise(60'000, 1)));
  EXPECT_TRUE(reader->verify());
}

/// Runs `work` where `folder` is read-only: behind a read-only bind mount, else as a user who may not write. Returns
/// its status; nothing if this process may do neither.
std::optional<int> in_read_only_folder(const std::filesystem::path& folder, const std::function<int()>& work) {
  const char* const name = folder.c_str();
  if (::mount(name, name, nullptr, MS_BIND, nullptr) == 0) {
    if (::mount(nullptr, name, nullptr, MS_BIND | MS_REMOUNT | MS_RDONLY, nullptr) == 0) {
      const int status = status_of(in_child(work));
      ::umount(name);
      return status;
    }
    ::umount(name);
  }
  constexpr uid_t kNobody = 65534;
  std::filesystem::permissions(folder, std::filesystem::perms(0555));
  const bool changes_user = ::geteuid() == 0;
  const int status = status_of(in_child([&] { return changes_user && ::setuid(kNobody) != 0 ? 101 : work(); }));
  std::filesystem::permissions(folder, std::filesystem::perms(0755));
  return status == 101 ? std::nullopt : std::optional(status);
}

int read_everything(const std::filesystem::path& path) {
  const auto reader = RunFileReader::open(path);
  if (!reader) return 1;
  return reader->verify() && reader->read(0, 1) ? 0 : 2;
}

TEST(RunFileProcess, ReadsASealedFileFromAReadOnlyFolder) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  write_noise_file(path, 3000);
  const auto status = in_read_only_folder(folder.path(), [&] { return read_everything(path); });
  if (!status) GTEST_SKIP() << "this process may neither mount nor change its user";
  EXPECT_EQ(*status, 0);
}

TEST(RunFileProcess, ReadsAnAbandonedFileFromAReadOnlyFolder) {
  const TempFolder folder;
  const auto path = folder / "a.soakrun";
  {
    auto writer = RunFileWriter::create(path, run_info());
    ASSERT_TRUE(writer->add_stream(noise_stream()));
    ASSERT_TRUE(writer->append(0, {column_of(times(3000, 0.01)), column_of(noise(3000, 7))}));
    ASSERT_TRUE(writer->flush());
  }
  const auto status = in_read_only_folder(folder.path(), [&] { return read_everything(path); });
  if (!status) GTEST_SKIP() << "this process may neither mount nor change its user";
  EXPECT_EQ(*status, 0);
}

TEST(RunFileProcess, SaysSoWhenTheFolderIsReadOnly) {
  const TempFolder folder;
  const auto status = in_read_only_folder(folder.path(), [&] {
    const auto writer = RunFileWriter::create(folder / "a.soakrun", run_info());
    if (writer || writer.error().kind != base::ErrorKind::internal) return 1;
    const auto catalog = Catalog::open(folder.path());
    if (catalog || catalog.error().kind != base::ErrorKind::internal) return 2;
    return catalog.error().where.find(folder.path().string()) == std::string::npos ? 3 : 0;
  });
  if (!status) GTEST_SKIP() << "this process may neither mount nor change its user";
  EXPECT_EQ(*status, 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace soak::db
