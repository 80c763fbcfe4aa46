// SPDX-License-Identifier: MIT

#include "libshape/io/file/watched_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

/// Whether somebody else could lock the folder now.
bool can_lock(const std::filesystem::path& folder)
{
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool done = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    ::close(descriptor);
    return done;
}

TEST(WatchedFile, TellsWhetherTheFileIsStillTheSame)
{
    const test::TemporaryDirectory directory;
    const std::filesystem::path path = directory / "a";
    const auto is_same_after = [&](const auto& change) {
        test::write_bytes(path, "old");
        const WatchedFile file(path);
        EXPECT_TRUE(file.is_as_it_was());
        change();
        return file.is_as_it_was();
    };
    EXPECT_TRUE(is_same_after([&] { EXPECT_EQ(test::read_bytes(path), "old"); }));
    const auto replace = [&](const std::string& content) {
        test::write_bytes(directory / "b", content);
        std::filesystem::last_write_time(directory / "b", std::filesystem::last_write_time(path));
        std::filesystem::rename(directory / "b", path);
    };
    EXPECT_FALSE(is_same_after([&] { replace("old"); })); // of the same size and time
    EXPECT_FALSE(is_same_after([&] {
        const auto time = std::filesystem::last_write_time(path);
        test::write_bytes(path, "longer");
        std::filesystem::last_write_time(path, time);
    }));
    EXPECT_FALSE(is_same_after([&] {
        std::filesystem::last_write_time(
            path, std::filesystem::last_write_time(path) - std::chrono::seconds(5));
    }));
    EXPECT_FALSE(is_same_after([&] { std::filesystem::remove(path); }));
}

TEST(WatchedFile, LocksItsFolderUntilItEnds)
{
    const test::TemporaryDirectory directory;
    test::write_bytes(directory / "a", "old");
    {
        WatchedFile file(directory / "a");
        EXPECT_TRUE(can_lock(directory.path()));
        file.lock_folder();
        EXPECT_FALSE(can_lock(directory.path()));
    }
    EXPECT_TRUE(can_lock(directory.path()));
}

TEST(WatchedFile, NamesPathAndCauseOfWhatIsNoFile)
{
    const test::TemporaryDirectory directory;
    const auto message = [&](const char* name) {
        return test::message_of<FileError>([&] { const WatchedFile file(directory / name); });
    };
    EXPECT_EQ(message("none"),
              "cannot write " + (directory / "none").string() + ": No such file or directory");
    std::filesystem::create_symlink("none", directory / "link");
    EXPECT_EQ(message("link"), "cannot write " + (directory / "link").string() +
                                   ": is a symbolic link; name the file it points to");
}

} // namespace
} // namespace shape
