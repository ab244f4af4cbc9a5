// SPDX-License-Identifier: Apache-2.0
#include "station/io/csv_scanner.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace soak::station {
namespace {

using Row = std::vector<std::string>;

std::vector<Row> all_rows(std::string_view text, char separator = ',') {
  CsvScanner scanner(text, separator);
  std::vector<Row> rows;
  std::vector<std::string_view> cells;
  while (scanner.next(cells).value()) rows.emplace_back(cells.begin(), cells.end());
  return rows;
}

TEST(CsvScanner, SplitsLinesOfBothLineEnds) {
  const std::vector<Row> expected = {{"a", "b", ""}, {"1", "", "3"}};
  EXPECT_EQ(all_rows("a,b,\n1,,3\n"), expected);
  EXPECT_EQ(all_rows("a,b,\r\n1,,3\r\n"), expected);
  EXPECT_EQ(all_rows("a\tb\t\n1\t\t3", '\t'), expected);
}

// The examples are those of RFC 4180, section 2, rules 5 to 7.
TEST(CsvScanner, ReadsQuotedCellsOfRfc4180) {
  EXPECT_EQ(all_rows("\"aaa\",\"bbb\",\"ccc\"\r\nzzz,yyy,xxx\r\n"),
            (std::vector<Row>{{"aaa", "bbb", "ccc"}, {"zzz", "yyy", "xxx"}}));
  EXPECT_EQ(all_rows("\"aaa\",\"b\r\nbb\",\"ccc\"\r\nzzz,yyy,xxx"),
            (std::vector<Row>{{"aaa", "b\r\nbb", "ccc"}, {"zzz", "yyy", "xxx"}}));
  EXPECT_EQ(all_rows("\"aaa\",\"b\"\"bb\",\"ccc\""), (std::vector<Row>{{"aaa", "b\"bb", "ccc"}}));
}

TEST(CsvScanner, CountsLinesThroughQuotedLineEndsAndEmptyLines) {
  CsvScanner scanner("h,i\n\n\"two\nlines\",1\nlast,2", ',');
  std::vector<std::string_view> cells;
  std::vector<std::size_t> lines;
  while (scanner.next(cells).value()) lines.push_back(scanner.line());
  EXPECT_EQ(lines, (std::vector<std::size_t>{1, 3, 5}));
  EXPECT_FALSE(scanner.row_was_ended());
}

TEST(CsvScanner, RefusesAQuoteThatNothingEnds) {
  CsvScanner scanner("a,b\n1,\"2\n3,4\n", ',');
  std::vector<std::string_view> cells;
  ASSERT_TRUE(scanner.next(cells).value());
  const auto result = scanner.next(cells);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().where, "line 2");
}

TEST(CsvScanner, WritesCellsThatItReadsBack) {
  for (const std::string& text : {std::string("plain"), std::string("a,b"), std::string("say \"so\""),
                                  std::string("two\r\nlines"), std::string(" blanks ")}) {
    EXPECT_EQ(all_rows(csv_cell(text) + ",x\n"), (std::vector<Row>{{text, "x"}}));
  }
}

}  // namespace
}  // namespace soak::station
