#include "core/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/files.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

std::filesystem::path file_with(const std::string& name, const std::string& text) {
  const std::filesystem::path path = temporary_file(name);
  write_text_atomically(path, text);
  return path;
}

TEST(Csv, NumbersReadBackExactly) {
  const std::vector<double> values = {
      0.1, -1e-300, 5e300, 1.0 / 3, 0, std::numeric_limits<double>::infinity(), std::nan("")};
  CsvTable table({"name"});
  for (std::size_t i = 0; i < values.size(); ++i)
    table.add_row({"a \"b\", c\n" + std::to_string(i)});
  table.set_column("x_mm", values);
  const std::filesystem::path path = temporary_file("round.csv");
  table.write(path);
  const CsvTable back = CsvTable::read(path);
  ASSERT_EQ(back.rows(), values.size());
  EXPECT_EQ(back.columns(), table.columns());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(back.text(i, "name"), table.text(i, "name"));
    const double v = back.number(i, "x_mm");
    EXPECT_TRUE(v == values[i] || (std::isnan(v) && std::isnan(values[i])));
  }
}

TEST(Csv, AcceptsCrlfBlankLinesAndNoLastNewline) {
  const CsvTable t = CsvTable::read(file_with("crlf.csv",
                                              "\xEF\xBB\xBF"
                                              "a,b\r\n1, 2\r\n\r\n+3,nan"));
  ASSERT_EQ(t.rows(), 2u);
  EXPECT_EQ(t.columns()[0], "a");
  EXPECT_EQ(t.number(0, "b"), 2);
  EXPECT_EQ(t.number(1, "a"), 3);
  EXPECT_TRUE(std::isnan(t.number(1, "b")));
}

TEST(Csv, ErrorsNameFileLineAndColumn) {
  using testing::HasSubstr;
  EXPECT_THAT(error_of([] { CsvTable::read(file_with("ragged.csv", "a,b\n1,2\n3\n")); }),
              testing::AllOf(HasSubstr("ragged.csv"), HasSubstr("line 3 has 1 cells")));
  EXPECT_THAT(error_of([] { CsvTable::read(file_with("twice.csv", "a,a\n1,2\n")); }),
              HasSubstr("'a' is named twice"));
  EXPECT_THAT(error_of([] { CsvTable::read(file_with("empty.csv", "\n")); }),
              HasSubstr("is empty"));
  EXPECT_THAT(error_of([] { CsvTable::read(file_with("quote.csv", "a\n\"b")); }),
              HasSubstr("never closed"));
  const CsvTable t = CsvTable::read(file_with("cells.csv", "a,b\n1,2x\n,inf\n"));
  EXPECT_THAT(error_of([&] { t.number(0, "b"); }),
              testing::AllOf(HasSubstr("cells.csv:2"), HasSubstr("'2x'")));
  EXPECT_THAT(error_of([&] { t.number(1, "a"); }), HasSubstr("cells.csv:3"));
  EXPECT_THAT(error_of([&] { t.finite_number(1, "b"); }), HasSubstr("finite"));
  EXPECT_THAT(error_of([&] { t.number(0, "c"); }), HasSubstr("the columns are: a, b"));
}

}  // namespace
}  // namespace wheatstone
