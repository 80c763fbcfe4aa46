// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/isolation.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/hdf5/content_bytes.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/io/hdf5/untrusted_files.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/support/data.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// On while it lives.
struct Isolation
{
    Isolation() { isolate_hdf5_files(true); }
    ~Isolation() { isolate_hdf5_files(false); }
    Isolation(const Isolation&) = delete;
    Isolation& operator=(const Isolation&) = delete;
};

class IsolationTest : public testing::Test
{
protected:
    IsolationTest() : path_(folder_ / "c.h5")
    {
        Collection meshes = make_synthetic("faces", {.count = 5, .vertices = 300});
        for (std::size_t i = 0; i < meshes.size(); ++i)
            meshes.names[i] += "\xc3\xa9";
        write_collection(path_, meshes, {.derived = true, .compress = true});
    }

    [[nodiscard]] FileContent read() const
    {
        return read_content_isolated_if_wanted(path_, fs::file_size(path_));
    }

    test::TemporaryDirectory folder_;
    fs::path path_;
};

TEST_F(IsolationTest, GivesTheSameContent)
{
    const FileContent here = read();
    const Isolation isolation;
    const FileContent apart = read();
    EXPECT_TRUE(to_bytes(here) == to_bytes(apart));
    EXPECT_TRUE(here.values == apart.values);
    EXPECT_FALSE(here.values.empty());
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
}

TEST_F(IsolationTest, ReadsThousandsOfForeignMembersWithinItsLimits)
{
    constexpr int count = 5000;
    {
        const Id file(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
        for (int i = 0; i < count; ++i)
            (void)Id(H5Gcreate2(file, join("g", i).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Gclose);
    }
    const Isolation isolation;
    EXPECT_GT(read().groups.at("/").value.size(), std::size_t{count});
    EXPECT_EQ(read_collection(path_).size(), 15U);
}

TEST_F(IsolationTest, RefusesWhatCrashesHdf5)
{
    const fs::path directory = test::data_dir() / "hostile";
    if (!fs::exists(directory))
        GTEST_SKIP() << "no data";
    const Isolation isolation;
    int files = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(directory))
        if (entry.path().extension() == ".h5") {
            ++files;
            EXPECT_THROW((void)read_content_isolated_if_wanted(entry.path(), entry.file_size()),
                         InvalidInput)
                << entry.path();
        }
    EXPECT_GT(files, 0);
}

TEST_F(IsolationTest, BytesAreThoseOfTheContentOrOfNone)
{
    const std::string bytes = to_bytes(read());
    const std::optional<FileContent> again = from_bytes(bytes);
    ASSERT_TRUE(again);
    EXPECT_EQ(to_bytes(*again), bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(from_bytes(bytes.substr(0, size))) << size;
    EXPECT_FALSE(from_bytes(bytes + '\0'));

    FileContent foreign;
    foreign.objects["/\xff\xfe"].refusal = std::string(1, '\x80');
    const std::optional<FileContent> same = from_bytes(to_bytes(foreign));
    ASSERT_TRUE(same);
    EXPECT_EQ(same->objects.at("/\xff\xfe").refusal, "\x80");
}

} // namespace
} // namespace shape
