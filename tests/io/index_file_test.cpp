// SPDX-License-Identifier: MIT

#include "libshape/io/index_file.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

TEST(IndexFile, HoldsIndicesInAnyLayout)
{
    const test::TemporaryDirectory folder;
    test::write_bytes(folder / "tags.txt", "# head\n3 1 4\r\n\n  1 # and a comment\n5");
    EXPECT_EQ(read_indices(folder / "tags.txt", 6, "vertex"), (std::vector{3, 1, 4, 1, 5}));
}

TEST(IndexFile, RefusalsNameTheLine)
{
    const test::TemporaryDirectory folder;
    const auto refusal = [&](const char* content) {
        test::write_bytes(folder / "tags.txt", content);
        return test::message_of<InvalidInput>(
            [&] { (void)read_indices(folder / "tags.txt", 6, "vertex"); });
    };
    EXPECT_NE(refusal("1\n6\n").find("tags.txt: line 2: vertex 6 is out of range [0, 5]"),
              std::string::npos);
    EXPECT_NE(refusal("1\n-1\n").find("line 2: vertex -1"), std::string::npos);
    EXPECT_NE(refusal("1 2.5\n").find("line 1: vertex is '2.5', must be an integer"),
              std::string::npos)
        << refusal("1 2.5\n");
    EXPECT_NE(refusal("").find("empty"), std::string::npos);
    EXPECT_NE(refusal("# none\n").find("holds no vertex"), std::string::npos);
}

TEST(IndexFile, ThatIsMissingIsAFileError)
{
    EXPECT_THROW((void)read_indices("/no/such/file", 6, "vertex"), FileError);
}

} // namespace
} // namespace shape
