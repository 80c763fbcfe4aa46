// SPDX-License-Identifier: MIT

#include "libshape/io/collection_stream.h"

#include <gtest/gtest.h>

#include <fstream>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_file.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/h5py.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// Meshes of 642 vertices: 64 of them stand in one chunk.
Collection several_chunks()
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    Collection collection{mesh.topology, {}, {}, {{"side", {}}}};
    for (int i = 0; i < 150; ++i) {
        collection.names.push_back(join("m", i));
        collection.points.emplace_back((1.0 + 0.01 * i) * mesh.points);
        collection.labels[0].values.push_back(i % 3 == 0 ? "left" : "right");
    }
    return collection;
}

/// All meshes as they come by, `block` at a time from mesh `begin` on.
std::vector<Points> all_of(const MeshStream& stream, Eigen::Index begin, Eigen::Index block)
{
    std::vector<Points> points;
    for_each_block(stream, begin, stream.size(), block,
                   [&](Eigen::Index first, const Collection& b) {
                       EXPECT_EQ(first, begin + static_cast<Eigen::Index>(points.size()));
                       points.insert(points.end(), b.points.begin(), b.points.end());
                   });
    return points;
}

TEST(CollectionStream, GivesEveryBitOfTheCollectionInBlocksOfAnySize)
{
    const test::TemporaryDirectory directory;
    const Collection collection = several_chunks();
    for (const bool compress : {false, true})
        for (const bool derived : {false, true}) {
            write_collection(directory / "c.h5", collection,
                             {.derived = derived, .compress = compress});
            const MeshStream stream = open_collection(directory / "c.h5");
            EXPECT_TRUE(stream.topology == collection.topology);
            EXPECT_EQ(stream.names, collection.names);
            EXPECT_EQ(stream.labels[0].values, collection.labels[0].values);
            for (const Eigen::Index block : {1, 7, 64, 200})
                EXPECT_EQ(all_of(stream, 0, block), collection.points);
            EXPECT_EQ(all_of(stream, 149, 4).front(), collection.points.back());
            EXPECT_EQ(read_collection(directory / "c.h5").points, collection.points);
        }
}

TEST(CollectionStream, CompressedFilesAreSmallerAndReadByH5py)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "plain.h5", several_chunks());
    write_collection(directory / "packed.h5", several_chunks(), {.compress = true});
    EXPECT_LT(std::filesystem::file_size(directory / "packed.h5"),
              std::filesystem::file_size(directory / "plain.h5"));
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    EXPECT_EQ(test::run_h5py(directory / "packed.h5", "r",
                             "g = h5py.File(r'" + (directory / "plain.h5").string() +
                                 "')\nprint((f['points'][...] == g['points'][...]).all(), "
                                 "f['points'].compression, f['points'].shuffle, "
                                 "f['points'].fletcher32)\n"),
              "True gzip True True\n");
}

TEST(CollectionStream, ReadsAFileThatIsWrittenInOtherChunks)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    const Collection collection = several_chunks();
    write_collection(directory / "c.h5", collection);
    const auto copies = test::edit_with_h5py(
        directory / "c.h5",
        {"v = f['points'][...]; del f['points']; f.create_dataset('points', data=v, "
         "chunks=(7, 100, 2), fletcher32=True)",
         "v = f['points'][...]; del f['points']; f.create_dataset('points', data=v, "
         "chunks=(150, 1, 3), fletcher32=True, compression='gzip')",
         "v = f['points'][...]; del f['points']; f.create_dataset('points', data=v, "
         "chunks=(1, 642, 3), maxshape=(None, 642, 3))"});
    for (const auto& copy : copies) {
        EXPECT_EQ(all_of(open_collection(copy), 0, 32), collection.points);
        EXPECT_EQ(read_collection(copy).points, collection.points);
    }
}

TEST(CollectionStream, NamesTheMeshesOfADamagedBlockInTheMiddle)
{
    const test::TemporaryDirectory directory;
    const Collection collection = several_chunks();
    for (const bool compress : {false, true}) {
        write_collection(directory / "c.h5", collection, {.compress = compress});
        std::string bytes = test::read_bytes(directory / "c.h5");
        // Positions take most of the file: half-way stands the second of three chunks.
        bytes[bytes.size() / 2] ^= 1;
        test::write_bytes(directory / "d.h5", bytes);
        const MeshStream stream = open_collection(directory / "d.h5");
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)all_of(stream, 0, 16); });
        EXPECT_NE(message.find("d.h5: /points: the stored values of rows 64 to 127 are damaged"),
                  std::string::npos)
            << message;
        EXPECT_EQ(all_of(stream, 128, 16).back(), collection.points.back()); // the rest is sound
    }
}

TEST(CollectionStream, SaysThatTheFileChangedWhileItWasRead)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", several_chunks());
    const MeshStream stream = open_collection(directory / "c.h5");
    std::vector<Points> points(1, Points(642, 3));
    stream.fetch({0})(points);
    std::ofstream(directory / "c.h5", std::ios::binary | std::ios::app) << "x";
    const std::string message = test::message_of<FileError>([&] { (void)stream.fetch({100}); });
    EXPECT_NE(message.find("c.h5: it changed while it was read"), std::string::npos) << message;
    std::filesystem::resize_file(directory / "c.h5", 4096);
    EXPECT_THROW((void)stream.fetch({100}), FileError);
}

TEST(CollectionStream, RefusesMeshesThatDoNotAscend)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", several_chunks());
    const MeshStream meshes = open_collection(directory / "c.h5");
    EXPECT_NO_THROW((void)meshes.fetch({1, 70, 149}));
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)meshes.fetch({1, 70, 5});
              }).find("rows[2] of /points is 5"),
              std::string::npos);
}

TEST(CollectionStream, GoesOnReadingAFileThatIsReplacedAsAWhole)
{
    const test::TemporaryDirectory directory;
    const Collection collection = several_chunks();
    write_collection(directory / "c.h5", collection);
    const MeshStream stream = open_collection(directory / "c.h5");
    write_collection(directory / "c.h5", subset(collection, {1, 2}));
    EXPECT_EQ(all_of(stream, 0, 64), collection.points);
}

TEST(CollectionStream, RefusesPositionsThatAreNotFinite)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", several_chunks());
    const auto copies =
        test::edit_with_h5py(directory / "c.h5", {"f['points'][70, 5, 1] = np.nan"});
    const std::string message = test::message_of<InvalidInput>(
        [&] { (void)all_of(open_collection(copies.front()), 0, 64); });
    EXPECT_NE(message.find("/points: value (70, 5, 1) is nan"), std::string::npos) << message;
}

TEST(CollectionStream, SubsetsAndJoinedStreamsKeepNamesLabelsAndBits)
{
    const Collection collection = test::bumpy_spheres(10, 3);
    Collection more = test::bumpy_spheres(4, 5);
    for (std::string& name : more.names)
        name = "more " + name;
    more.labels = {{"colour", {"r", "g", "b", ""}}};
    const MeshStream both = joined(stream_of(collection), stream_of(more));
    EXPECT_EQ(both.size(), 14);
    EXPECT_EQ(both.labels.back().name, "colour");
    EXPECT_EQ(both.labels.back().values[0], "");
    EXPECT_EQ(both.labels.back().values[11], "g");
    const MeshStream some = subset(both, {1, 9, 10, 13});
    EXPECT_EQ(some.names, (std::vector{collection.names[1], collection.names[9], more.names[0],
                                       more.names[3]}));
    EXPECT_EQ(all_of(some, 0, 3), (std::vector{collection.points[1], collection.points[9],
                                               more.points[0], more.points[3]}));
    EXPECT_THROW((void)joined(both, stream_of(more)), InvalidInput);
    EXPECT_THROW((void)subset(both, {1, 14}), InvalidInput);
    EXPECT_THROW((void)subset(both, {9, 1}), InvalidInput);
    EXPECT_THROW((void)subset(both, {1, 1}), InvalidInput);
    const test::TestMesh other = test::bumpy_sphere(2, 0.3, 1);
    const Collection single{other.topology, {"o"}, {other.points}, {}};
    EXPECT_THROW((void)joined(both, stream_of(single)), InvalidInput);
}

} // namespace
} // namespace shape
