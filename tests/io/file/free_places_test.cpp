// SPDX-License-Identifier: MIT

#include "libshape/io/file/free_places.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <tuple>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/io/file/output_file.h"
#include "tests/support/files.h"

namespace {

int refused_rename =
    0; ///< What file systems without a renaming that replaces nothing say; 0: this one has it.
int refused_link = 0; ///< Likewise of second names.

} // namespace

// In place of those of the C library, in the whole test program: like them unless a test says otherwise.
extern "C" int renameat2(int from_folder, const char* from, int to_folder, const char* to,
                         unsigned int flags) noexcept
{
    if (refused_rename == 0)
        return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
    errno = refused_rename;
    return -1;
}

extern "C" int linkat(int from_folder, const char* from, int to_folder, const char* to,
                      int flags) noexcept
{
    if (refused_link == 0)
        return static_cast<int>(::syscall(SYS_linkat, from_folder, from, to_folder, to, flags));
    errno = refused_link;
    return -1;
}

namespace shape {
using namespace internal;
namespace {

/// The ways of file systems: one step, a second name, neither.
class FreePlacesOf : public testing::TestWithParam<std::pair<int, int>>
{
protected:
    FreePlacesOf() { std::tie(refused_rename, refused_link) = GetParam(); }
    ~FreePlacesOf() override { refused_rename = refused_link = 0; }

    const test::TemporaryDirectory directory_;
};

INSTANTIATE_TEST_SUITE_P(FileSystems, FreePlacesOf,
                         testing::Values(std::pair{0, 0}, std::pair{EINVAL, 0},
                                         std::pair{ENOSYS, EPERM}));

TEST_P(FreePlacesOf, ArePlacesWhereAFileIsNotReplaced)
{
    FreePlaces places;
    places.add(directory_ / "out.txt");
    const auto appear = [&](const auto&) { test::write_bytes(directory_ / "out.txt", "theirs"); };
    const std::string message = test::message_of<FileError>(
        [&] { write_file_atomically(directory_ / "out.txt", "mine", appear); });
    EXPECT_NE(message.find("out.txt: since this run began"), std::string::npos) << message;
    EXPECT_EQ(test::read_bytes(directory_ / "out.txt"), "theirs");
    EXPECT_EQ(directory_.names(), std::vector<std::string>{"out.txt"});
    bool has_begun = false; // what is there already ends it before the work
    EXPECT_THROW(write_file_atomically(directory_ / "out.txt", [&](int) { has_begun = true; }),
                 FileError);
    EXPECT_FALSE(has_begun);
}

TEST_P(FreePlacesOf, AreTakenByTheRunItself)
{
    FreePlaces places;
    places.add(directory_ / "out.txt");
    places.add(directory_ / "folder/"); // with a slash or without
    write_file_atomically(directory_ / "out.txt", "first");
    write_file_atomically(directory_ / "out.txt", "second"); // its own
    EXPECT_EQ(test::read_bytes(directory_ / "out.txt"), "second");
    std::filesystem::create_directory(directory_ / "made");
    move_into_place(directory_ / "made", directory_ / "folder");
    EXPECT_EQ(directory_.names(), (std::vector<std::string>{"folder", "out.txt"}));
}

TEST_P(FreePlacesOf, KeepAFolderThatHasAppeared)
{
    FreePlaces places;
    places.add(directory_ / "folder");
    std::filesystem::create_directory(directory_ / "made");
    std::filesystem::create_directory(directory_ /
                                      "folder"); // empty: rename() alone would replace it
    EXPECT_THROW(move_into_place(directory_ / "made", directory_ / "folder"), FileError);
    EXPECT_EQ(directory_.names(), (std::vector<std::string>{"folder", "made"}));
}

TEST(FreePlaces, HoldAsLongAsTheyAreThere)
{
    const test::TemporaryDirectory directory;
    const std::filesystem::path path = directory / "out.txt";
    {
        FreePlaces places;
        places.add(path);
        EXPECT_TRUE(FreePlaces::contain(directory.path() / "." / "out.txt"));
    }
    EXPECT_FALSE(FreePlaces::contain(path));
    test::write_bytes(path, "theirs");
    test::write_bytes(directory / "made", "mine");
    move_into_place(directory / "made", path); // nothing forbids it
    EXPECT_EQ(test::read_bytes(path), "mine");
    const std::string message =
        test::message_of<FileError>([&] { move_into_place(directory / "missing", path); });
    EXPECT_NE(message.find("out.txt: No such file"), std::string::npos) << message;
}

} // namespace
} // namespace shape
