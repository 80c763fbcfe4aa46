// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/file_content.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <tuple>

#include "libshape/base/to_size.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/io/hdf5/stored_rows.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

namespace fs = std::filesystem;

/// A file written by HDF5's own functions.
class FileContentTest : public testing::Test
{
protected:
    FileContentTest() : path_(folder_ / "file.h5") {}

    /// Writes, and reads what there is.
    template <class Write>
    FileContent content_of(const Write& write)
    {
        {
            const Id file(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
            write(file);
        }
        return read_content(path_, fs::file_size(path_));
    }

    static void add(hid_t file, const std::string& name, hid_t type, const Extents& extents,
                    const void* values, hid_t creation = H5P_DEFAULT)
    {
        const Id dataset(H5Dcreate2(file, name.c_str(), type, make_space(extents), H5P_DEFAULT,
                                    creation, H5P_DEFAULT),
                         H5Dclose);
        checked(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
    }

    test::TemporaryDirectory folder_;
    fs::path path_;
};

constexpr std::array<int, 6> six{3, 1, 4, 1, 5, 9};
constexpr std::array<double, 6> six_doubles{3, 1, 4, 1, 5, 9};

TEST_F(FileContentTest, HoldsIntegersAndWhereDoublesStand)
{
    const FileContent content = content_of([&](hid_t file) {
        add(file, "integers", H5T_STD_I32LE, {2, 3}, six.data());
        add(file, "contiguous", H5T_IEEE_F64LE, {6}, six_doubles.data());
        const Id chunked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
        const std::array<hsize_t, 1> chunk{4};
        checked(H5Pset_chunk(chunked, 1, chunk.data()));
        add(file, "chunked", H5T_IEEE_F64LE, {6}, six_doubles.data(), chunked);
    });
    EXPECT_EQ(content.groups.at("/").value,
              (std::vector<std::string>{"chunked", "contiguous", "integers"}));

    const StoredDataset& integers = content.objects.at("/integers").dataset.value;
    EXPECT_EQ(integers.extents, (Extents{2, 3}));
    ASSERT_EQ(integers.values.size, sizeof(six));
    EXPECT_EQ(std::memcmp(content.values.data() + integers.values.begin, six.data(), sizeof(six)),
              0);

    const std::string bytes = test::read_bytes(path_);
    const StoredDataset& contiguous = content.objects.at("/contiguous").dataset.value;
    EXPECT_EQ(contiguous.values.size, 0U);
    ASSERT_LE(contiguous.offset + sizeof(six_doubles), bytes.size());
    EXPECT_EQ(
        std::memcmp(bytes.data() + contiguous.offset, six_doubles.data(), sizeof(six_doubles)), 0);

    const StoredDataset& chunked = content.objects.at("/chunked").dataset.value;
    EXPECT_EQ(chunked.chunk, Extents{4});
    std::array<ChunkTable::Chunk, 2> chunks{};
    ASSERT_EQ(chunked.values.size, sizeof(chunks));
    std::memcpy(chunks.data(), content.values.data() + chunked.values.begin, sizeof(chunks));
    for (const std::size_t c : {0U, 1U}) {
        ASSERT_TRUE(lies_in_file(chunks[c], bytes.size()));
        EXPECT_EQ(chunks[c].size, 4 * sizeof(double));
        EXPECT_EQ(std::memcmp(bytes.data() + chunks[c].offset, six_doubles.data() + 4 * c,
                              (c == 0 ? 4 : 2) * sizeof(double)),
                  0);
    }
}

TEST_F(FileContentTest, HoldsAttributesAsWhatTheyAre)
{
    const FileContent content = content_of([&](hid_t file) {
        const auto attach = [&](const char* name, hid_t type, const Extents& extents,
                                const void* value) {
            const Id attribute(
                H5Acreate2(file, name, type, make_space(extents), H5P_DEFAULT, H5P_DEFAULT),
                H5Aclose);
            checked(H5Awrite(attribute, type, value));
        };
        const std::int64_t seven = 7;
        attach("integer", H5T_NATIVE_INT64, {}, &seven);
        attach("several", H5T_STD_I32LE, {6}, six.data());
        const Id text(H5Tcopy(H5T_C_S1), H5Tclose);
        checked(H5Tset_size(text, 4));
        attach("text", text, {}, "abc");
    });
    ASSERT_EQ(content.attributes.value.size(), 3U);
    const auto& [integer, several, text] = std::tie(
        content.attributes.value[0], content.attributes.value[1], content.attributes.value[2]);
    EXPECT_EQ(integer.name, "integer");
    EXPECT_EQ(integer.integer.value, 7);
    EXPECT_EQ(integer.text.refusal, "must be a string of fixed length");
    EXPECT_EQ(several.integer.refusal, "must be a single value");
    EXPECT_STREQ(text.text.value.c_str(), "abc");
    EXPECT_EQ(text.integer.refusal, "must be an integer");
}

TEST_F(FileContentTest, HasTwoLevelsAndFollowsNoLinks)
{
    const FileContent content = content_of([&](hid_t file) {
        const Id creation(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
        checked(H5Pset_create_intermediate_group(creation, 1));
        const Id group(H5Gcreate2(file, "a/b/c", creation, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
        checked(H5Lcreate_hard(file, "/", file, "/a/root", H5P_DEFAULT, H5P_DEFAULT));
        checked(H5Lcreate_soft("/a", file, "/soft", H5P_DEFAULT, H5P_DEFAULT));
        checked(H5Lcreate_external("other.h5", "/", file, "/outside", H5P_DEFAULT, H5P_DEFAULT));
    });
    EXPECT_EQ(content.groups.size(), 2U);
    EXPECT_EQ(content.groups.at("/a").value, (std::vector<std::string>{"b", "root"}));
    EXPECT_EQ(content.objects.at("/a").refusal, "");
    for (const char* link : {"/soft", "/outside"})
        EXPECT_NE(content.objects.at(link).refusal.find("link to elsewhere"), std::string::npos);
}

TEST_F(FileContentTest, HoldsNoMoreValuesThanTheFileHasRoomFor)
{
    const std::vector<int> many(100'000, 1);
    const FileContent content = content_of([&](hid_t file) {
        add(file, "d0", H5T_STD_I32LE, {100'000}, many.data());
        for (int i = 1; i < 10; ++i)
            checked(H5Lcreate_hard(file, "/d0", file, ("/d" + std::to_string(i)).c_str(),
                                   H5P_DEFAULT, H5P_DEFAULT));
    });
    EXPECT_LE(content.values.size(), 4 * fs::file_size(path_));
    EXPECT_EQ(content.objects.at("/d3").dataset.value.refusal, "");
    EXPECT_NE(content.objects.at("/d9").dataset.value.refusal.find("cannot hold them all"),
              std::string::npos);
}

TEST_F(FileContentTest, SaysWhyNothingIsThere)
{
    test::write_bytes(path_, "\x89HDF\r\n\x1a\n and no more");
    EXPECT_NE(read_content(path_, 20).refusal.find("truncated or damaged"), std::string::npos);
}

} // namespace
} // namespace shape
