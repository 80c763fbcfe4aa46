// SPDX-License-Identifier: MIT

#include "libshape/io/table_file.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

using Rows = std::vector<std::vector<std::string>>;

Table read(std::string_view text)
{
    static const test::TemporaryDirectory directory;
    test::write_bytes(directory / "table.csv", text);
    return read_table(directory / "table.csv");
}

TEST(TableFile, GivesEveryCellBack)
{
    const test::TemporaryDirectory directory;
    const Table table{{"mesh", "a,b", "quote\"d", "two\nlines"},
                      {{"s1", "", "\"", "x\r\ny"}, {"", " blank ", ",,", "é"}, {"", "", "", ""}}};
    write_table(directory / "t.csv", table);
    const Table back = read_table(directory / "t.csv");
    EXPECT_EQ(back.columns, table.columns);
    EXPECT_EQ(back.rows, table.rows);
}

TEST(TableFile, GivesLoneEmptyCellsBack)
{
    const test::TemporaryDirectory directory;
    const Table table{{"only"}, {{""}, {"x"}, {""}}};
    write_table(directory / "t.csv", table);
    EXPECT_EQ(read_table(directory / "t.csv").rows, table.rows);
}

TEST(TableFile, ReadsWhatSpreadsheetsWrite)
{
    const Rows rows = {{"1", "2"}, {"3", "4"}};
    for (const char* text : {"a,b\n1,2\n3,4\n", "a,b\n1,2\n3,4", "a,b\r\n1,2\r\n3,4\r\n",
                             "\xEF\xBB\xBF"
                             "a,b\n1,2\n3,4\n",
                             "\"a\",\"b\"\n\"1\",2\n3,\"4\"\n\n\n", "a,b\r\n1,2\n3,4\r\n\r\n",
                             "a,b,,\n1,2,,\n3,4,,\n", "sep=,\r\na,b\r\n1,2\r\n3,4\r\n"}) {
        SCOPED_TRACE(text);
        EXPECT_EQ(read(text).columns, (std::vector<std::string>{"a", "b"}));
        EXPECT_EQ(read(text).rows, rows);
    }
    EXPECT_TRUE(read("a,b\n").rows.empty());
}

TEST(TableFile, NamesFileLineAndRuleOfWhatItRefuses)
{
    struct Case
    {
        std::string_view text;
        const char* place;
        const char* rule;
    };
    using namespace std::string_view_literals;
    for (const Case& c : std::vector<Case>{
             {"", "t", "empty"},
             {"\n\n", "t", "empty"},
             {"a,a\n1,2\n", "line 1", "'a' occurs twice"},
             {"a,,b\n1,2,3\n", "line 1", "column 2 has no name"},
             {"a,\n1,\n2,x\n", "line 1", "column 2 has no name"},
             {",mesh\n1,a\n", "line 1", "row.names = FALSE"},
             {"sep=,\na,b\n1,2,3\n", "line 3", "has 3 cells, the header has 2"},
             {"a,b\n1,2\n3\n", "line 3",
              "has 1 cell, the header has 2; write a comma for each value that is missing"},
             {"a,b\n1,2,3\n", "line 2", "has 3 cells, the header has 2, as have all rows"},
             {"a,b\n1,2\n\n3,4\n", "line 3",
              "has 1 cell, the header has 2; take the empty line away"},
             {"a,b\n1,2\n3,4,5\n", "line 3",
              "header has 2; put values that have a comma in quotes, and write numbers"},
             // Commas at the ends of some lines.
             {"a,b\n1,2\n3,4,\n", "line 3",
              "has 3 cells, the header has 2; the last is empty: take the comma"},
             {"a,b\n1,2,\n3,4\n", "line 2",
              "has 3 cells, the header has 2; the last is empty: take the comma"},
             {"a,b\n1,2,\n3,4,5\n", "line 3", "has 3 cells, the header has 2; put values"},
             {"a,b,\n1,2,3\n4,5,\n", "line 1", "column 3 has no name"},
             // Two separators in one table.
             {"mesh,sex;age\na,f;30\nb,m;40\n", "line 1",
              "'sex;age' and all cells below it have ';' in them: separate all cells by ','"},
             {"mesh;sex,age\na;f,30\n", "line 1", "'mesh;sex' and all cells below it have ';'"},
             {"mesh,sex\tage\na,f\t30\n", "line 1", "and all cells below it have a tab in them"},
             {"mesh,sex,age\na,f;30\n", "line 2",
              "has 2 cells, the header has 3; ';' separates some of them: separate all cells by "
              "','"},
             {"mesh,sex,age\na,f,30\nb;m;40\n", "line 3",
              "has 1 cell, the header has 3; ';' separates"},
             {"mesh,sex,age\na,f,30\nb\tm\t40\n", "line 3", "a tab separates some of them"},
             {"mesh,sex,age\na,f|30\n", "line 2", "'|' separates some of them"},
             {"a,b\nx,1,2\ny,3,4\n", "line 2", "as have all rows; if their first cells"},
             {"a,b\n\"x\ny\",2\n1\n", "line 4", "has 1 cell,"},
             {"a,b\n1,\"2\n3,4\n", "line 2", "a quote is not closed"},
             {"a,b\n1,\"2\"x\n", "line 2", "text follows a closing quote"},
             {"a,b\n1,x\"2\"\n", "line 2", "a quote stands within"},
             {"a,b\r1,2\r", "line 1", "CR ends no line"},
             {"mesh;sex\na;f\n", "line 1", "separator of the cells is ';'"},
             {"mesh\tsex\na\tf\n", "line 1", "separator of the cells is a tab"},
             {"\"mesh\";\"sex\"\n\"a\";\"f\"\n", "line 1", "separator of the cells is ';'"},
             {"\"mesh\"\t\"sex\"\na\tf\n", "line 1", "separator of the cells is a tab"},
             {"mesh;\"sex\"\na;\"f\"\n", "line 1", "separator of the cells is ';'"},
             {"mesh\t\"sex, age\"\na\tf\n", "line 1", "separator of the cells is a tab"},
             {"mesh\n\"a\";\"f\"\n", "line 2", "separator of the cells is ';'"},
             {"mesh|sex\na|f\n", "line 1", "separator of the cells is '|'"},
             {"mesh:sex\na:f\n", "line 1", "separator of the cells is ':'"},
             {"mesh sex age\na f 1\nb m 2\n", "line 1", "separator of the cells is a blank"},
             {"mesh   sex\na      f\n", "line 1", "separator of the cells is a blank"},
             {"\"mesh\"|\"sex\"\n\"a\"|\"f\"\n", "line 1", "separator of the cells is '|'"},
             {"\"mesh\" | \"sex\"\n", "line 1", "separator of the cells is '|'"},
             {"\"mesh\":\"sex\"\n\"a\":\"f\"\n", "line 1", "separator of the cells is ':'"},
             {"\"mesh\":sex\na:f\n", "line 1", "separator of the cells is ':'"},
             {"\"mesh\" \"sex\"\n\"1\" \"a\" \"f\"\n", "line 1", "is a blank"}, // of write.table()
             {"\"mesh\" \"sex, age\"\n", "line 1", "separator of the cells is a blank"},
             {"\"mesh\" sex\n\"a\" 1,5\n", "line 1", "separator of the cells is a blank"},
             {"\"mesh\"^\"sex\"\n", "line 1", "separator of the cells is '^'"},
             {"mesh|\"sex\"\na|\"f\"\n", "line 1", "separator of the cells is '|'"},
             {"mesh:\"sex\"\na:\"f\"\n", "line 1", "separator of the cells is ':'"},
             {"mesh \"sex\"\na \"f\"\n", "line 1", "separator of the cells is a blank"},
             {"mesh,sex\n\"a\"|\"f\"\n", "line 2", "separator of the cells is '|'"},
             {"sep=|\nmesh|sex\na|f\n", "line 1", "separator of the cells is '|'"},
             // But not where there are commas.
             {"a,b\n\"1\" ,2\n", "line 2", "a blank follows a closing quote"},
             {"a,b\n\"1\" (x),2\n", "line 2", "a blank follows a closing quote"},
             {"a,b\n1, \"2\"\n", "line 2", "a blank stands before a quote"},
             {"a,b\nJohn \"Joe\" Smith,2\n", "line 2", "a quote stands within"},
             {"a,b\n1,\"2\"|\n", "line 2", "text follows a closing quote"},
             {"a,b\n1,\"2\";\n", "line 2", "text follows a closing quote"},
             {"a,b\n1,x;\"2\"\n", "line 2", "a quote stands within"},
             {"a,b\n1,\0\n"sv, "t", "UTF-8"},
             {"a,b\n1,\xE9\n", "t", "UTF-8"},
             {"\xFF\xFE"
              "a\0"sv,
              "t", "UTF-8"},
         }) {
        SCOPED_TRACE(c.text);
        const std::string message = test::message_of<InvalidInput>([&] { (void)read(c.text); });
        EXPECT_NE(message.find("table.csv"), std::string::npos) << message;
        EXPECT_NE(message.find(c.place), std::string::npos) << message;
        EXPECT_NE(message.find(c.rule), std::string::npos) << message;
    }
}

TEST(TableFile, PassesOverCommasAtTheEndOfAllLines)
{
    const Table wanted = read("a,b\n1,2\n,4\n");
    for (const char* text :
         {"a,b\n1,2,\n,4,\n", "a,b,\n1,2,\n,4,\n", "a,b,\n1,2\n,4\n", "a,b\n1,2,,,\n,4,,,\n",
          "a,b\r\n1,2,\r\n,4, \r\n", "a,b,,\n1,2,\n,4,\n"}) {
        const Table found = read(text);
        EXPECT_EQ(found.columns, wanted.columns) << text;
        EXPECT_EQ(found.rows, wanted.rows) << text;
    }
    EXPECT_EQ(read("a,b,c\n1,,\n2,,\n").columns.size(), 3U); // values that are missing
}

TEST(TableFile, TakesSemicolonsOfNamesAndValuesForNoSeparators)
{
    // Not in all cells, or not as often; or in quotes.
    for (const char* text :
         {"mesh,sex;age\na,f;30\nb,m\n", "mesh,sex;age\na,f;30;1\n", "mesh,sex;age\n",
          "mesh,\"sex;age\"\na,f;30\n", "mesh,sex;age\na,\"f;30\"\n", "mesh,note\na,x;y\n"})
        EXPECT_EQ(read(text).columns.size(), 2U) << text;
    // What is written is read again.
    const test::TemporaryDirectory folder;
    const Table table{{"mesh", "sex;age"}, {{"a", "f;30"}}};
    write_table(folder / "t.csv", table);
    EXPECT_EQ(read_table(folder / "t.csv").columns, table.columns);
    EXPECT_EQ(read_table(folder / "t.csv").rows, table.rows);
}

TEST(TableFile, TakesBlanksAndColonsOfOneNameForNoSeparators)
{
    for (const char* text : {"pc 1\n2\n", "pc:1\n2\n3\n", "time of day\n12 h\n", "a b\n",
                             "\"a:b c\"\n\"1 2\"\n3\n", "a|b,c\nx|y,2\n", "a b,c:d\n1 2,3:4\n"})
        EXPECT_EQ(read(text).columns.size(),
                  std::string_view(text).find(',') != std::string_view::npos ? 2U : 1U)
            << text;
}

TEST(TableFile, AdvisesOfRowNamesOnlyIfAllRowsHaveThem)
{
    for (const char* text :
         {"a,b\nx,1,2\n3,4\n", "a,b\n1,2\nx,3,4\n", "a,b\nx,y,1,2\n", "a,b\nx,1,2\ny,\"3,4\n"}) {
        const std::string message = test::message_of<InvalidInput>([&] { (void)read(text); });
        EXPECT_NE(message.find("the header has 2"), std::string::npos) << message;
        EXPECT_EQ(message.find("row.names"), std::string::npos) << message;
    }
}

TEST(TableFile, NeverCrashesOnDamagedText)
{
    const std::string valid = "mesh,a\n\"s\"\"1\",x\n\"s,2\",\"y\nz\"\n";
    Random random(1);
    int read_count = 0;
    for (int round = 0; round < 1000; ++round) {
        std::string text = valid;
        text[random.index(text.size())] = static_cast<char>(random.bits());
        try {
            for (const auto& row : read(text).rows)
                EXPECT_EQ(row.size(), 2u);
            ++read_count;
        } catch (const InvalidInput&) {
        }
    }
    EXPECT_GT(read_count, 0);
    EXPECT_LT(read_count, 1000);
}

TEST(TableFile, RefusesToWriteRaggedRowsAndRepeatedColumns)
{
    const test::TemporaryDirectory directory;
    EXPECT_THROW(write_table(directory / "t.csv", {{"a", "b"}, {{"1"}}}), InvalidInput);
    EXPECT_THROW(write_table(directory / "t.csv", {{"a", "a"}, {}}), InvalidInput);
    EXPECT_TRUE(directory.names().empty());
}

TEST(TableFile, SaysWhichFileItCannotRead)
{
    const test::TemporaryDirectory directory;
    const std::string message =
        test::message_of<FileError>([&] { (void)read_table(directory / "no.csv"); });
    EXPECT_NE(message.find("no.csv: No such file"), std::string::npos) << message;
}

TEST(Numbers, ArePrintedWithTheDigitsThatGiveThemBack)
{
    Random random(2);
    for (int round = 0; round < 20000; ++round) {
        const double value = std::bit_cast<double>(random.bits());
        if (!std::isfinite(value))
            continue;
        EXPECT_EQ(std::bit_cast<std::uint64_t>(parse_number(print_number(value), "")),
                  std::bit_cast<std::uint64_t>(value));
    }
    EXPECT_EQ(print_number(0.1), "0.1");
    EXPECT_EQ(print_number(-0.0), "-0");
    EXPECT_EQ(parse_number("+1.5e1", ""), 15.0);
}

TEST(Numbers, MustBeSpelledByTheWholeCell)
{
    for (const char* cell : {"", " 1", "1 ", "1,5", "0x10", "nan", "inf", "-inf", "1e999", "abc",
                             "1.5x", "+", "-", "+-1", "++1", "."}) {
        SCOPED_TRACE(cell);
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)parse_number(cell, "row 3, length"); });
        EXPECT_EQ(message.find("row 3, length: "), 0u) << message;
    }
}

} // namespace
} // namespace shape
