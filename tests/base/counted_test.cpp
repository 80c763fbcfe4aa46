// SPDX-License-Identifier: MIT

#include "libshape/base/counted.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

namespace shape {
using namespace internal;
namespace {

TEST(Counted, OneIsTheOnlySingular)
{
    EXPECT_EQ(counted(1, "mesh", "meshes"), "1 mesh");
    EXPECT_EQ(counted(0, "mesh", "meshes"), "0 meshes");
    EXPECT_EQ(counted(2, "mesh", "meshes"), "2 meshes");
    EXPECT_EQ(counted(11, "vertex", "vertices"), "11 vertices");
    EXPECT_EQ(counted(-1, "vertex", "vertices"), "-1 vertices");
}

TEST(Counted, APluralThatIsNotGivenHasAnS)
{
    EXPECT_EQ(counted(1, "face"), "1 face");
    EXPECT_EQ(counted(0, "face"), "0 faces");
    EXPECT_EQ(counted(80, "boundary loop"), "80 boundary loops");
}

TEST(Counted, CountsOfAnyWidth)
{
    EXPECT_EQ(counted(std::size_t{1}, "byte"), "1 byte");
    EXPECT_EQ(counted(std::uint64_t{1} << 63, "byte"), "9223372036854775808 bytes");
    EXPECT_EQ(counted((std::int64_t{1} << 32) + 1, "byte"), "4294967297 bytes");
}

} // namespace
} // namespace shape
