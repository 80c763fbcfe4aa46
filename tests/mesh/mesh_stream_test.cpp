// SPDX-License-Identifier: MIT

#include "libshape/mesh/mesh_stream.h"

#include <gtest/gtest.h>

#include <latch>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/joined_labels.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"

namespace shape {
namespace {

using Eigen::Index;

/// A stream whose fetch() does something else first.
MeshStream with_reader(const Collection& collection, const std::function<void(Index first)>& before)
{
    MeshStream stream = stream_of(collection);
    stream.fetch = [fetch = stream.fetch, before](std::vector<Index> meshes) {
        before(meshes.front());
        return fetch(std::move(meshes));
    };
    return stream;
}

TEST(MeshStream, WorksOnABlockWhileASlowReaderFetchesTheNext)
{
    const Collection collection = test::bumpy_spheres(9, 1);
    std::latch worked_on(1); // else the reader of the second block would never go on
    const MeshStream slow = with_reader(collection, [&](Index first) {
        if (first == 3)
            worked_on.wait();
    });
    std::vector<Index> firsts;
    for_each_block(slow, 0, 9, 3, [&](Index first, const Collection& block) {
        if (first == 0)
            worked_on.count_down();
        firsts.push_back(first);
        EXPECT_EQ(block.points.front(), collection.points[internal::to_size(first)]);
    });
    EXPECT_EQ(firsts, (std::vector<Index>{0, 3, 6}));
}

TEST(MeshStream, SubsetNamesAnIndexOutOfRange)
{
    const Collection collection = test::bumpy_spheres(3, 1);
    try {
        (void)subset(stream_of(collection), {0, 3});
        FAIL() << "nothing was thrown";
    } catch (const InvalidInput& error) {
        EXPECT_STREQ(error.what(), "meshes[1] is 3, must be in [0, 3)");
    }
}

TEST(MeshStream, EndsWithTheErrorOfAReaderThatFailsInTheMiddle)
{
    const Collection collection = test::bumpy_spheres(9, 1);
    const MeshStream broken = with_reader(collection, [](Index first) {
        if (first == 6)
            throw FileError("cannot read c.h5: Input/output error");
    });
    std::vector<Index> firsts;
    EXPECT_EQ(test::message_of<FileError>([&] {
                  for_each_block(broken, 0, 9, 3,
                                 [&](Index first, const Collection&) { firsts.push_back(first); });
              }),
              "cannot read c.h5: Input/output error");
    EXPECT_EQ(firsts, (std::vector<Index>{0, 3}));
}

TEST(MeshStream, WaitsForItsReaderWhenTheWorkFails)
{
    const Collection collection = test::bumpy_spheres(6, 1);
    std::latch failed(1);
    bool was_read = false;
    const MeshStream slow = with_reader(collection, [&](Index first) {
        if (first != 3)
            return;
        failed.wait();
        was_read = true;
    });
    EXPECT_THROW(for_each_block(slow, 0, 6, 3,
                                [&](Index, const Collection&) {
                                    failed.count_down();
                                    throw Interrupted("stopped");
                                }),
                 Interrupted);
    EXPECT_TRUE(was_read); // what it refers to is still there then
}

TEST(AppendLabels, FillsWhatOneOfThemLacks)
{
    Labels all{{"mood", {"calm", "glad"}}};
    internal::append_labels(all, 2, {{"side", {"left"}}, {"mood", {"sad"}}}, 1);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0].values, (std::vector<std::string>{"calm", "glad", "sad"}));
    EXPECT_EQ(all[1].name, "side");
    EXPECT_EQ(all[1].values, (std::vector<std::string>{"", "", "left"}));
    internal::append_labels(all, 3, {}, 2);
    EXPECT_EQ(all[0].values, (std::vector<std::string>{"calm", "glad", "sad", "", ""}));
}

} // namespace
} // namespace shape
