// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/stored_dataset.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>

namespace shape {
using namespace internal;
namespace {

constexpr std::uint64_t file_size = 10'000;

/// 30 by 20 doubles in chunks of 7 by 20.
StoredDataset sound()
{
    StoredDataset dataset;
    dataset.type = StoredDataset::Type::Float64;
    dataset.value_size = 8;
    dataset.rank = 2;
    dataset.extents = {30, 20};
    dataset.layout = StoredDataset::Layout::Chunked;
    dataset.chunk = {7, 20};
    dataset.filters = {H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE, H5Z_FILTER_FLETCHER32};
    return dataset;
}

TEST(StoredDataset, CountsValuesAndChunks)
{
    EXPECT_EQ(broken_rule(sound(), file_size), "");
    EXPECT_EQ(sound().count(), 600);
    EXPECT_EQ(sound().chunk_count(), 5);
    EXPECT_TRUE(sound().is_compressed());
}

TEST(StoredDataset, NamesEveryBrokenRule)
{
    struct Case
    {
        const char* rule;
        std::function<void(StoredDataset&)> change;
    };
    const std::vector<Case> cases{
        {"at most 3 dimensions", [](auto& d) { d.rank = -1; }},
        {"at most 3 dimensions", [](auto& d) { d.rank = 4; }},
        {"at most 3 dimensions",
         [](auto& d) {
             d.extents = {1, 1, 1, 1};
         }},
        {"values of 0 bytes", [](auto& d) { d.value_size = 0; }},
        {"values of 4097 bytes", [](auto& d) { d.value_size = 4097; }},
        {"virtual or unknown layout", [](auto& d) { d.layout = StoredDataset::Layout::Other; }},
        {"in another file", [](auto& d) { d.is_external = true; }},
        {"without a checksum", [](auto& d) { d.filters = {H5Z_FILTER_DEFLATE}; }},
        {"with filter 32000",
         [](auto& d) {
             d.filters = {32000, H5Z_FILTER_FLETCHER32};
         }},
        {"with filter 1", [](auto& d) { d.type = StoredDataset::Type::Int32; }},
        {"has no values",
         [](auto& d) {
             d.extents = {30, 0};
         }},
        {"has no values",
         [](auto& d) {
             d.extents = {-30, 20};
         }},
        {"more than the file can hold",
         [](auto& d) {
             d.extents = {30, PTRDIFF_MAX};
         }},
        {"declares 30 by 20 values of 8 bytes, more than the file can hold",
         [](auto& d) {
             d.filters = {}, d.extents = {30, 20}, d.value_size = 8;
         }},
        {"chunks without values",
         [](auto& d) {
             d.chunk = {7, 0};
         }},
        {"chunks of more than",
         [](auto& d) {
             d.chunk = {1 << 20, 20};
         }},
        {"chunks of another rank", [](auto& d) { d.chunk = {7}; }},
        {"chunks of another rank", [](auto& d) { d.chunk = {}; }},
        {"chunks of another rank", [](auto& d) { d.layout = StoredDataset::Layout::Contiguous; }},
    };
    for (const Case& one : cases) {
        StoredDataset changed = sound();
        one.change(changed);
        const bool is_of_room = std::string(one.rule).starts_with("declares 30");
        EXPECT_NE(broken_rule(changed, is_of_room ? 4'799 : file_size).find(one.rule),
                  std::string::npos)
            << one.rule << ", but: " << broken_rule(changed, file_size);
    }
}

TEST(StoredDataset, HasAtMostSixteenMillionChunks)
{
    StoredDataset dataset = sound();
    dataset.extents = {1 << 12, 1 << 12};
    dataset.chunk = {1, 1};
    constexpr std::uint64_t large = std::uint64_t{1} << 40;
    EXPECT_EQ(broken_rule(dataset, large), "");
    ++dataset.extents[0];
    EXPECT_NE(broken_rule(dataset, large).find("chunks; the limit is 16777216"), std::string::npos);
}

} // namespace
} // namespace shape
