// SPDX-License-Identifier: MIT

#include "libshape/base/letter_case.h"

#include <gtest/gtest.h>

namespace shape::internal {
namespace {

TEST(LetterCase, ChangesLettersOfAsciiAlone)
{
    const std::string all = "@AZ[`az{09 \xC3\x84\xFF";
    EXPECT_EQ(lower_case(all), "@az[`az{09 \xC3\x84\xFF");
    EXPECT_EQ(upper_case(all), "@AZ[`AZ{09 \xC3\x84\xFF");
    EXPECT_EQ(lower_case(""), "");
}

} // namespace
} // namespace shape::internal
