// SPDX-License-Identifier: MIT

#include "libshape/base/scratch_file.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape::internal {
namespace {

TEST(ScratchFile, GivesBackWhatWasWrittenWhereverAndHasNoName)
{
    const test::TemporaryDirectory folder;
    auto file = ScratchFile::make(folder.path(), 100 * sizeof(double));
    ASSERT_TRUE(file);
    EXPECT_TRUE(folder.names().empty());
    const std::vector<double> late{1.5, -2.0};
    const std::vector<double> early{3.25};
    file->write(98, late);
    file->write(0, early);
    ScratchFile moved = std::move(*file);
    std::vector<double> found(100, -1.0);
    moved.read(0, found);
    EXPECT_EQ(found[0], 3.25);
    EXPECT_EQ(found[50], 0.0);
    EXPECT_EQ(found[98], 1.5);
    EXPECT_EQ(found[99], -2.0);
    EXPECT_TRUE(folder.names().empty());
}

TEST(ScratchFile, IsNotMadeWhereThereIsNoRoomForIt)
{
    const test::TemporaryDirectory folder;
    EXPECT_FALSE(ScratchFile::make(folder / "missing", 8));
    EXPECT_FALSE(ScratchFile::make(folder.path(), std::uint64_t{1} << 60));
    EXPECT_TRUE(folder.names().empty());
}

TEST(ScratchFile, SaysSoWhenItEnds)
{
    const test::TemporaryDirectory folder;
    const auto file = ScratchFile::make(folder.path(), 8);
    ASSERT_TRUE(file);
    std::vector<double> numbers(2);
    const std::string message = test::message_of<FileError>([&] { file->read(0, numbers); });
    EXPECT_NE(message.find("the file ends early"), std::string::npos) << message;
}

} // namespace
} // namespace shape::internal
