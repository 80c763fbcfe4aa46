// SPDX-License-Identifier: MIT

#include "libshape/io/label_file.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape {
namespace {

using Values = std::vector<std::string>;

class LabelFiles : public testing::Test
{
protected:
    [[nodiscard]] LabelFile read(std::string_view text, const Values& names = {"a", "b"}) const
    {
        test::write_bytes(directory_ / "l.csv", text);
        return read_label_file(directory_ / "l.csv", names);
    }
    [[nodiscard]] std::string message(std::string_view text, const Values& names = {"a", "b"}) const
    {
        return test::message_of<InvalidInput>([&] { (void)read(text, names); });
    }

    const test::TemporaryDirectory directory_;
};

TEST_F(LabelFiles, GiveLabelsInTheOrderOfTheMeshes)
{
    const LabelFile file = read("mesh,sex,age\nb,f,3\na,m,4\n");
    ASSERT_EQ(file.labels.size(), 2u);
    EXPECT_EQ(file.labels[0].name, "sex");
    EXPECT_EQ(file.labels[0].values, (Values{"m", "f"}));
    EXPECT_EQ(file.labels[1].values, (Values{"4", "3"}));
    EXPECT_TRUE(file.unused.empty());
}

TEST_F(LabelFiles, NameMeshesThatAreMissingOrRepeated)
{
    EXPECT_NE(message("name,x\na,1\nb,2\n").find("must be 'mesh'"), std::string::npos);
    EXPECT_NE(message("mesh,x\na,1\n").find("'b' is missing"), std::string::npos);
    EXPECT_NE(message("mesh,x\na,1\nb,2\na,3\n").find("'a' occurs twice"), std::string::npos);
    EXPECT_NE(message("mesh,x\na,1\nb,2\na.ply,3\n").find("'a.ply' occurs twice"),
              std::string::npos);
    EXPECT_NE(message("mesh,x\na,1\nB,2\n").find("first 'B'"), std::string::npos);
    EXPECT_NE(message("mesh,x\na,1\nc,2\n", {"a", "c.ply", "c.obj"}).find("could be several"),
              std::string::npos);
}

TEST_F(LabelFiles, MayBeOfALargerStudy)
{
    const LabelFile file = read("mesh,x\nz,0\nb,2\nc,3\na,1\n");
    EXPECT_EQ(file.labels[0].values, (Values{"1", "2"}));
    EXPECT_EQ(file.unused, (Values{"z", "c"}));
}

TEST_F(LabelFiles, MatchNamesWithEndingsBlanksAndAccentsOfEitherSpelling)
{
    const std::string composed = "Andr\xC3\xA9";
    const std::string decomposed = "Andre\xCC\x81";
    EXPECT_EQ(read("mesh,x\na.ply,1\nb.OBJ,2\n").labels[0].values, (Values{"1", "2"}));
    EXPECT_EQ(read("mesh , x \n a ,1\n\tb\xC2\xA0, 2 \n").labels[0].values, (Values{"1", "2"}));
    EXPECT_EQ(read("mesh , x \n a ,1\nb,2\n").labels[0].name, "x");
    for (const std::string& name : {composed, decomposed})
        for (const std::string& spelled : {composed, decomposed, composed + ".off"})
            EXPECT_EQ(read("mesh,x\n" + spelled + ",1\n", {name}).labels[0].values, Values{"1"});
    // Exact names come first, so that files which differ by that alone still have labels.
    EXPECT_EQ(read("mesh,x\nc.ply,1\nc,2\n", {"c", "c.ply"}).labels[0].values, (Values{"2", "1"}));
}

TEST_F(LabelFiles, PassOverRowsWithoutAnythingInTheirCells)
{
    const LabelFile file = read("mesh,x\na,1\n,\nb,2\n , \n,\n");
    EXPECT_EQ(file.labels[0].values, (Values{"1", "2"}));
    EXPECT_TRUE(file.unused.empty());
    EXPECT_EQ(read("mesh,x\na,1\nb,2\n,3\n").unused, Values{""});
}

TEST_F(LabelFiles, LeaveOutColumnsWithoutAName)
{
    const LabelFile file = read("mesh, ,x,\t,NA\na,1,2,3,4\nb,5,6,7,8\n");
    ASSERT_EQ(file.labels.size(), 2u);
    EXPECT_EQ(file.labels[0].name, "x");
    EXPECT_EQ(file.labels[0].values, (Values{"2", "6"}));
    EXPECT_EQ(file.labels[1].name, "NA"); // a name is no value
    EXPECT_EQ(file.nameless, (std::vector<std::size_t>{1, 3}));
}

TEST_F(LabelFiles, RefuseTwoColumnsOfOneName)
{
    EXPECT_NE(message("mesh,x,y, x\na,1,2,3\n").find("line 1: the columns 'x' and ' x' have one"),
              std::string::npos);
    EXPECT_NE(message("mesh,\xC3\xBC,u\xCC\x88\na,1,2\n").find("rename one"), std::string::npos);
    EXPECT_EQ(read("mesh,x,X\na,1,2\nb,3,4\n").labels.size(), 2u);
}

TEST_F(LabelFiles, AreTablesWhoseOtherCellsStayAsTheyAre)
{
    test::write_bytes(directory_ / "t.csv", " u\xCC\x88 ,mesh \n NA , f\n , \n");
    const Table table = read_label_table(directory_ / "t.csv");
    EXPECT_EQ(table.columns, (Values{"\xC3\xBC", "mesh"}));
    EXPECT_EQ(table.rows, (std::vector<Values>{{" NA ", " f"}}));
}

TEST(LabelNames, AreAlikeThatATableTakesForOne)
{
    using Pair = std::pair<std::size_t, std::size_t>;
    EXPECT_EQ(names_alike({"a", "\xC3\xBCx", "u\xCC\x88x"}), (Pair{1, 2}));
    EXPECT_EQ(names_alike({" lead", "a", "lead"}), (Pair{0, 2}));
    EXPECT_EQ(names_alike({"c.ply", "c.obj"}), (Pair{0, 1}));
    EXPECT_EQ(names_alike({"a", "A", "a b", "ab", "a"}), std::nullopt);
}

TEST(LabelFile, SaysWhichNamesOfLabelsAFileCanHold)
{
    for (const char* name : {"a", ".", "a/b", " ", "\xC3\xBC"})
        EXPECT_TRUE(is_storable_label(name)) << name;
    for (const std::string_view name : {std::string_view(), std::string_view("a\0b", 3)})
        EXPECT_FALSE(is_storable_label(name)) << name;
    EXPECT_EQ(label_name("\t u\xCC\x88 x\xC2\xA0"), "\xC3\xBC x");
}

TEST(LabelValues, AreWithoutOuterBlanksAndEmptyIfMissing)
{
    for (const char* cell :
         {"",        " ",       "NA",       "na",           " NA ",      "N/A",
          "n/a",     "#N/A",    "#NA",      "<NA>",         "NaN",       "nan",
          "NAN",     "-nan",    "NULL",     "null",         "#NULL!",    ".",
          " . ",     "\t",      "\xC2\xA0", "#VALUE!",      "#NV",       "-1.#IND",
          "1.#IND",  "1.#QNAN", "-1.#qnan", "#N/A N/A",     "NaT",       "#REF!",
          "#DIV/0!", "#NAME?",  "#NUM!",    "\xE3\x80\x80", "-nan(ind)", "NaN(ind)"})
        EXPECT_EQ(label_value(cell), "") << cell;
    for (const char* cell : {"0", "none", "x y", "nano", "N", "..", "-", "unknown", "false"})
        EXPECT_EQ(label_value(cell), cell);
    EXPECT_EQ(label_value("  x y\t"), "x y");
    EXPECT_EQ(label_value("e\xCC\x81"), "\xC3\xA9");
    EXPECT_EQ(label_value("\xE9 "), "\xE9"); // no UTF-8: as it is
}

} // namespace
} // namespace shape
