// SPDX-License-Identifier: MIT

#include "libshape/io/file/output_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "libshape/base/error.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

TEST(OutputFile, ReplacesAFileAndLeavesNothingElse)
{
    const test::TemporaryDirectory directory;
    write_file_atomically(directory / "out.txt", "old");
    write_file_atomically(directory / "out.txt", std::string("new\0bytes", 9));
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), std::string("new\0bytes", 9));
    EXPECT_EQ(directory.names(), std::vector<std::string>{"out.txt"});
}

TEST(OutputFile, TakesPathsWithoutADirectoryAndNamesOfFullLength)
{
    const test::TemporaryDirectory directory;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(directory.path());
    write_file_atomically("out.txt", "here");
    std::filesystem::current_path(before);
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), "here");
    const std::string longest(255, 'n');
    write_file_atomically(directory / longest, "long");
    EXPECT_EQ(test::read_bytes(directory / longest), "long");
}

TEST(OutputFile, FollowsTheUmask)
{
    const test::TemporaryDirectory directory;
    const mode_t before = ::umask(027);
    write_file_atomically(directory / "out.txt", "x");
    ::umask(before);
    struct stat status = {};
    ASSERT_EQ(::stat((directory / "out.txt").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(OutputFile, ShowsTheCheckTheNewFileAndTheOldTarget)
{
    const test::TemporaryDirectory directory;
    write_file_atomically(directory / "out.txt", "old");
    bool called = false;
    write_file_atomically(directory / "out.txt", "new", [&](const std::filesystem::path& path) {
        called = true;
        EXPECT_EQ(path.parent_path(), directory.path());
        EXPECT_EQ(path.filename().string().front(), '.');
        EXPECT_EQ(test::read_bytes(path), "new");
        EXPECT_EQ(test::read_bytes(directory / "out.txt"), "old");
    });
    EXPECT_TRUE(called);
}

TEST(OutputFile, KeepsTheTargetWhenTheCheckThrows)
{
    const test::TemporaryDirectory directory;
    write_file_atomically(directory / "out.txt", "old");
    EXPECT_THROW(write_file_atomically(directory / "out.txt", "new",
                                       [](const auto&) { throw NumericalError("no"); }),
                 NumericalError);
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), "old");
    EXPECT_EQ(directory.names(), std::vector<std::string>{"out.txt"});
}

TEST(OutputFile, AsksAgainJustBeforeItRenames)
{
    const test::TemporaryDirectory directory;
    write_file_atomically(directory / "out.txt", "old");
    std::string calls;
    const auto write = [&](const auto& before_renaming) {
        write_file_atomically(
            directory / "out.txt",
            [&](int descriptor) {
                calls += 'w';
                EXPECT_EQ(::write(descriptor, "new", 3), 3);
            },
            [&](const std::filesystem::path&) { calls += 'c'; }, before_renaming);
    };
    EXPECT_THROW(write([] { throw NumericalError("no"); }), NumericalError);
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), "old");
    write([&] {
        calls += 'r';
        EXPECT_EQ(test::read_bytes(directory / "out.txt"), "old");
    });
    EXPECT_EQ(calls, "wcwcr");
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), "new");
    EXPECT_EQ(directory.names(), std::vector<std::string>{"out.txt"});
}

TEST(OutputFile, KeepsTheTargetWhenTheSystemRefusesToWrite)
{
    const test::TemporaryDirectory directory;
    write_file_atomically(directory / "out.txt", "old");
    // A limit of the file size stands for a full disk.
    const auto handler = ::signal(SIGXFSZ, SIG_IGN);
    rlimit before = {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small = {1000, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string message = test::message_of<FileError>(
        [&] { write_file_atomically(directory / "out.txt", std::string(5000, 'x')); });
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    ::signal(SIGXFSZ, handler);
    EXPECT_NE(message.find("out.txt"), std::string::npos) << message;
    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    EXPECT_EQ(test::read_bytes(directory / "out.txt"), "old");
    EXPECT_EQ(directory.names(), std::vector<std::string>{"out.txt"});
}

TEST(OutputFile, RefusesTargetsThatAreNotRegularFiles)
{
    const test::TemporaryDirectory directory;
    const auto message = [&](const std::filesystem::path& path) {
        return test::message_of<FileError>([&] { write_file_atomically(path, "x"); });
    };
    test::write_bytes(directory / "file", "content");
    std::filesystem::create_directory(directory / "folder");
    std::filesystem::create_symlink("file", directory / "link");
    ASSERT_EQ(::mkfifo((directory / "fifo").c_str(), 0600), 0);
    EXPECT_NE(message(directory / "folder").find("is a directory"), std::string::npos);
    EXPECT_NE(message(directory / "link").find("symbolic link"), std::string::npos);
    EXPECT_NE(message(directory / "fifo").find("not a regular file"), std::string::npos);
    EXPECT_NE(message("/dev/null").find("not a regular file"), std::string::npos);
    EXPECT_NE(message(directory / "folder/").find("names no file"), std::string::npos);
    EXPECT_NE(message(directory / "missing/out.txt").find("No such file"), std::string::npos);
    EXPECT_NE(message(directory / "file/out.txt").find("Not a directory"), std::string::npos);
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"fifo", "file", "folder", "link"}));
    EXPECT_EQ(test::read_bytes(directory / "file"), "content");
}

TEST(OutputFile, NamesADirectoryItMayNotWriteTo)
{
    if (::geteuid() == 0)
        GTEST_SKIP() << "the superuser may write everywhere";
    const test::TemporaryDirectory directory;
    std::filesystem::permissions(
        directory.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    const std::string message =
        test::message_of<FileError>([&] { write_file_atomically(directory / "out.txt", "x"); });
    std::filesystem::permissions(directory.path(), std::filesystem::perms::owner_all);
    EXPECT_NE(message.find("Permission denied"), std::string::npos) << message;
    EXPECT_TRUE(directory.names().empty());
}

} // namespace
} // namespace shape
