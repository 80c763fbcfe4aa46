// SPDX-License-Identifier: MIT

#include "libshape/io/label_doubts.h"

#include <gtest/gtest.h>

namespace shape::internal {
namespace {

using Values = std::vector<std::string>;

TEST(LabelDoubts, AreValuesThatDifferInCaseOrInTheSpellingOfANumberAlone)
{
    EXPECT_EQ(values_alike({"f", "m", "F"}), (Values{"f", "F"}));
    EXPECT_EQ(values_alike({"", "TRUE", "x", "True"}), (Values{"TRUE", "True"}));
    EXPECT_EQ(values_alike({"\u00C9t\u00E9", "x", "\u00E9t\u00E9"}),
              (Values{"\u00C9t\u00E9", "\u00E9t\u00E9"}));
    EXPECT_EQ(values_alike({"1", "2", "1.0"}), (Values{"1", "1.0"}));
    EXPECT_EQ(values_alike({"1e1", "10"}), (Values{"1e1", "10"}));
    EXPECT_EQ(values_alike({"f", "m", "f", "", "1", "1", "10", "a1", "a10"}), Values());
}

TEST(LabelDoubts, AreValuesThatLookAlike)
{
    for (const Values& values : {
             Values{"New York", "New  York", "New\u00A0York", "New\tYork", "New\u3000York"},
             Values{"pre-op", "pre\u2013op", "pre\u2010op", "pre\u2011op", "pre\u2212op"},
             Values{"a b", "a \u200Bb", "a\u00AD b"},
             Values{"don't", "don\u2019t"},
             Values{"A1", "\uFF211", "\u0410\uFF11", "\u03911"}, // wide, Cyrillic, Greek
             Values{"\u041C", "M", "m", "\u043C"},
             Values{"fit", "\uFB01t"},
         })
        EXPECT_EQ(values_alike(values), values) << values.front();
    EXPECT_EQ(values_alike({"New York", "NewYork", "pre-op", "preop", "pre_op", "pre op", "e",
                            "\u00E9", "mg", "\u00B5g", "\u03BCg2", "\u0416", "K"}),
              (Values())); // a unit is not read as a letter m
    EXPECT_EQ(values_alike({"b", "a", "B", "A"}), (Values{"b", "B"}));
}

TEST(LabelDoubts, SayHowValuesDifferThatLookTheSame)
{
    const auto said = [](const Values& values) {
        const Values doubts = doubts_about({{"site", values}, {"other", {"x", "y"}}});
        return doubts.size() == 1 ? doubts.front() : "";
    };
    EXPECT_EQ(said({"f", "F"}),
              "label 'site' has the values 'f' and 'F', which are two groups; "
              "spell them alike if they mean one");
    EXPECT_EQ(said({"a b", "a  b", "a\u00A0b"}),
              "label 'site' has the values 'a b', 'a  b' and 'a\u00A0b', which differ in blanks "
              "and are 3 groups; spell them alike if they mean one");
    EXPECT_NE(said({"a-b", "a\u2013b"}).find("look alike (U+002D and U+2013) and are two groups"),
              std::string::npos);
    EXPECT_NE(said({"A", "a", "\u0410"}).find("look alike (U+0041 and U+0410)"), std::string::npos);
    EXPECT_NE(said({"ab", "a\u00ADb"}).find("that cannot be seen (U+00AD)"), std::string::npos);
    EXPECT_EQ(said({"a", "b"}), "");
}

TEST(LabelDoubts, AreNumbersThatStandApartAsCodesOfMissingValuesDo)
{
    const auto codes = [](const Values& values) {
        const auto found = missing_codes(values);
        return found ? found->codes : Values();
    };
    for (const char* code : {"-999", "999", "9999", "-99", "-9", "-999.0", "99.9", "-8", "777"})
        EXPECT_EQ(codes({"20", code, "39", "", code, "25"}), Values{code}) << code;
    EXPECT_EQ(codes({"1", "5", "9"}), Values{"9"}); // of answers from 1 to 5
    EXPECT_EQ(codes({"0", "1", "99", "-99"}), (Values{"-99", "99"}));
    EXPECT_EQ(codes({"0.5", "100", "-9"}), Values{"-9"}); // alone in being negative
    for (const Values& values :
         {Values{"60", "95", "99"}, Values{"1", "6", "9"}, Values{"1.5", "3", "9"},
          Values{"-3", "4", "-9"}, Values{"20", "38", "-1"}, Values{"20", "21", "77"},
          Values{"20", "30", "9.9"}, Values{"20", "30", "998"}, Values{"8", "9", "999"},
          Values{"0", "-9", "-9"}, Values{"20", "30", "-999", "old"}, Values{"", "", ""}})
        EXPECT_EQ(codes(values), Values()) << values[2];
    const auto found = missing_codes({"20", "-999", "39", "-999", "25"});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->count, 2U);
    EXPECT_EQ(found->low, 20.0);
    EXPECT_EQ(found->high, 39.0);
    EXPECT_EQ(doubts_about({{"age", {"20", "-999", "39", "-999", "25"}}}),
              Values{"label 'age' is -999 in 2 meshes, apart from all other numbers (20 to 39); "
                     "where that stands for a missing value, leave the cell empty"});
}

TEST(LabelDoubts, AreWordsAndSignsThatStandForNoValue)
{
    for (const char* word :
         {"unknown", "Missing", "n.d.", "N/D", "(blank)", "k.A.", "not available", "'NA'",
          "\"n/a\"", "-", "--", "?", "..", "\u2014", "*"})
        EXPECT_EQ(missing_words({"f", word, "m", "", word}), Values{word}) << word;
    EXPECT_EQ(missing_words({"f", "?", "m", "unknown", "-"}), (Values{"unknown", "?", "-"}));
    for (const Values& values :
         {Values{"+", "-", "f"}, Values{"none", "other", "f"}, Values{"unknown", "unknown"},
          Values{"-", "", "-"}, Values{"n1", "nd2", "d"}, Values{"-1", "?2", "d"}})
        EXPECT_EQ(missing_words(values), Values()) << values[0];
    EXPECT_EQ(
        doubts_about({{"sex", {"m", "?", "f", "?"}}}),
        Values{"label 'sex' is '?' in 2 meshes, which counts as a group; where that stands for a "
               "missing value, leave the cell empty"});
}

TEST(LabelDoubts, AreValuesThatSpreadsheetsMarkAsText)
{
    EXPECT_EQ(values_alike({"f", "'f", "m"}), (Values{"f", "'f"}));
    EXPECT_EQ(values_alike({"f", "=\"f\"", "\"f\""}), (Values{"f", "=\"f\"", "\"f\""}));
    EXPECT_EQ(values_alike({"'", "\"", "O'Neil", "ONeil"}), Values());
}

} // namespace
} // namespace shape::internal
