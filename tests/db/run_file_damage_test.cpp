// SPDX-License-Identifier: Apache-2.0
#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "db/durable.h"
#include "db/run/run_file.h"
#include "tests/db/support.h"
#include "tests/long_tests.h"

namespace soak::db {
namespace {

using testing::bytes_of_file;
using testing::TempFolder;
using testing::write_noise_file;

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

void execute(const std::filesystem::path& path, const std::string& sql) {
  SQLite::Database(path.string(), SQLite::OPEN_READWRITE).exec(sql);
}

class DamagedRunFile : public ::testing::Test {
 protected:
  void SetUp() override { write_noise_file(path_, kRows); }

  /// Error of opening the file and checking all of it; success where nothing is found.
  [[nodiscard]] base::Status check() const {
    const auto reader = RunFileReader::open(path_);
    if (!reader) return base::forward_error(reader);
    return reader->verify();
  }

  static constexpr std::size_t kRows = 17'000;
  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "a.soakrun";
};

TEST_F(DamagedRunFile, NamesFileChannelAndChunkOfAFlippedByte) {
  SOAK_LONG_TEST();
  SQLite::Database database(path_.string(), SQLite::OPEN_READWRITE);
  database.exec("PRAGMA synchronous = OFF");
  SQLite::Statement query(database, "SELECT id, data FROM chunk WHERE channel_id = 2 AND first_row = 16384");
  ASSERT_TRUE(query.executeStep());
  const int id = query.getColumn(0).getInt();
  const std::string data = query.getColumn(1).getString();
  query.reset();
  SQLite::Statement update(database, "UPDATE chunk SET data = ? WHERE id = ?");
  for (std::size_t byte = 0; byte < data.size(); ++byte) {
    std::string damaged = data;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 0x10);
    update.bind(1, damaged.data(), static_cast<int>(damaged.size()));
    update.bind(2, id);
    update.exec();
    update.reset();
    const auto reader = RunFileReader::open(path_);
    ASSERT_TRUE(reader);
    const auto column = reader->read(0, 1, 16'384, 1);
    ASSERT_FALSE(column) << byte;
    ASSERT_EQ(column.error().kind, base::ErrorKind::corrupt);
    ASSERT_EQ(column.error().where, path_.string() + ", channel imu/SN1/value, chunk at row 16384");
    ASSERT_TRUE(reader->read(0, 1, 0, 16'384));  // the other chunk is still good
  }
}

TEST_F(DamagedRunFile, NoticesChangesOfEveryColumnOfAChunk) {
  const std::string original = bytes_of_file(path_);
  for (const char* change :
       {"first_row = first_row + 1", "row_count = row_count - 1", "row_count = -1", "row_count = 1e18",
        "value_count = value_count - 1", "codec = 'shuffle+zstd '", "crc32c = crc32c + 1", "presence = x'00'",
        "data = x''", "data = zeroblob(100000)", "channel_id = 1 - channel_id + 2"}) {
    write_bytes(path_, original);
    execute(path_, std::string("PRAGMA foreign_keys = OFF; UPDATE OR REPLACE chunk SET ") + change +
                       " WHERE channel_id = 2 AND first_row = 16384");
    const auto status = check();
    ASSERT_FALSE(status) << change;
    EXPECT_EQ(status.error().kind, base::ErrorKind::corrupt) << change;
  }
}

TEST_F(DamagedRunFile, NoticesAMissingChunkAndAWrongPyramid) {
  const std::string original = bytes_of_file(path_);
  for (const char* sql :
       {"DELETE FROM chunk WHERE channel_id = 2 AND first_row = 0",
        "DELETE FROM chunk WHERE channel_id = 2 AND first_row = 16384",
        "UPDATE pyramid SET maximum = maximum + 1 WHERE channel_id = 2 AND level = 1 AND bin = 2",
        "DELETE FROM pyramid WHERE channel_id = 1 AND level = 0 AND bin = 3", "DELETE FROM meta WHERE key = 'run_id'",
        "UPDATE meta SET value = 'x' WHERE key = 'clock_rate'", "UPDATE channel SET type = 'f128'",
        "DELETE FROM channel", "DROP TABLE event",
        "DROP TABLE event; CREATE VIEW event AS SELECT 1 AS id, 1 AS t_s, 1 AS kind, 1 AS text"}) {
    write_bytes(path_, original);
    execute(path_, std::string("PRAGMA foreign_keys = OFF; ") + sql);
    const auto status = check();
    ASSERT_FALSE(status) << sql;
    EXPECT_EQ(status.error().kind, base::ErrorKind::corrupt) << sql;
    EXPECT_NE(status.error().where.find(path_.string()), std::string::npos) << sql;
  }
}

TEST_F(DamagedRunFile, NamesTheChannelWhoseLabelsAreDamaged) {
  for (const char* labels : {"[\"+X\", ", "", "7", "{}"}) {
    execute(path_, std::string("UPDATE channel SET labels = '") + labels + "' WHERE id = 2");
    const auto status = check();
    ASSERT_FALSE(status) << labels;
    EXPECT_EQ(status.error().kind, base::ErrorKind::corrupt) << labels;
    EXPECT_EQ(status.error().where, path_.string() + ", channel imu/SN1/value") << labels;
  }
}

// SQLite calls such a file read-only, which would send people to its mode.
TEST(OpenRunFile, ThatIsDeletedIsNotCalledReadOnly) {
  const testing::TempFolder folder;
  const std::filesystem::path path = folder / "a.soakrun";
  auto writer = RunFileWriter::create(path, testing::run_info());
  ASSERT_TRUE(writer && writer->add_stream(testing::noise_stream()));
  ASSERT_TRUE(std::filesystem::remove(path));
  ASSERT_TRUE(
      writer->append(0, {testing::column_of(testing::times(10, 0.01)), testing::column_of(testing::noise(10, 7))}));
  const auto sealed = writer->seal();
  ASSERT_FALSE(sealed);
  EXPECT_EQ(sealed.error().kind, base::ErrorKind::internal);
  EXPECT_EQ(sealed.error().where, path.string());
  EXPECT_EQ(sealed.error().message.find("read-only"), std::string::npos) << sealed.error().message;
}

// The folders of /proc are of a file system that syncs none.
TEST(SyncName, IsNoFailureWhereTheFileSystemSyncsNoFolders) {
  EXPECT_TRUE(sync_name("/proc/self/status"));
  EXPECT_FALSE(sync_name("/proc/self/no-such-folder/file"));
}

TEST_F(DamagedRunFile, IsRefusedWhenCutShort) {
  const std::string original = bytes_of_file(path_);
  for (const std::size_t size : {std::size_t{1}, std::size_t{99}, std::size_t{1024}, std::size_t{2048},
                                 original.size() / 2, original.size() - 1}) {
    write_bytes(path_, original.substr(0, size));
    const auto status = check();
    ASSERT_FALSE(status) << size;
    EXPECT_EQ(status.error().kind, base::ErrorKind::corrupt) << size << ": " << status.error().message;
  }
  write_bytes(path_, "");
  ASSERT_FALSE(check());
  EXPECT_EQ(check().error().kind, base::ErrorKind::bad_input);
}

TEST_F(DamagedRunFile, NeverCrashesTheReaderWhereverAByteFlips) {
  const std::string original = bytes_of_file(path_);
  const auto pristine = RunFileReader::open(path_)->content_hash();
  base::Random random(3);
  for (int repeat = 0; repeat < 300; ++repeat) {
    std::string damaged = original;
    damaged[random.next() % damaged.size()] ^= static_cast<char>(1 + random.next() % 255);
    if (repeat % 2 == 0)
      damaged[random.next() % 8192] ^= static_cast<char>(1 + random.next() % 255);  // schema and roots
    write_bytes(path_, damaged);
    const auto reader = RunFileReader::open(path_);
    if (!reader) continue;
    const auto hash = reader->content_hash();
    static_cast<void>(reader->verify());
    static_cast<void>(reader->pyramid(0, 1, 0.0, 100.0, 10));
    // Names and scales of channels carry no checksum of their own; the catalog's hash of the file covers them.
    const auto& streams = reader->streams();
    const bool same_meaning = streams.size() == 1 && streams[0].name == "imu" && streams[0].unit == "SN1" &&
                              streams[0].channels == testing::noise_stream().channels;
    EXPECT_TRUE(!hash || !same_meaning || *hash == *pristine) << repeat;
  }
}

TEST_F(DamagedRunFile, IsToldApartFromANewerOneAndFromAnotherKind) {
  execute(path_, "PRAGMA user_version = 2");
  const auto newer = RunFileReader::open(path_);
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().kind, base::ErrorKind::bad_input);
  EXPECT_EQ(newer.error().where, path_.string());
  execute(path_, "PRAGMA application_id = 7");
  EXPECT_EQ(RunFileReader::open(path_).error().kind, base::ErrorKind::bad_input);
  write_bytes(path_, std::string(5000, 'x'));
  EXPECT_EQ(RunFileReader::open(path_).error().kind, base::ErrorKind::corrupt);
  EXPECT_EQ(RunFileReader::open(folder_ / "absent.soakrun").error().kind, base::ErrorKind::bad_input);
}

}  // namespace
}  // namespace soak::db
