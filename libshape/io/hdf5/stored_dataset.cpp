// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/stored_dataset.h"

#include <hdf5.h>

#include <algorithm>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/hdf5/handles.h"

namespace shape::internal {
namespace {

using Eigen::Index;

constexpr Index most_chunks = Index{1} << 24;    // of one dataset
constexpr Index best_packing = 1032;             // of deflate: bytes out of one
constexpr Index largest_chunk = Index{64} << 20; // [byte]

/// Doubles may be compressed, if a checksum stands over what is stored; all else has that alone.
std::string broken_rule_of_filters(const StoredDataset& dataset)
{
    const bool may_be_packed = dataset.type == StoredDataset::Type::Float64;
    if (may_be_packed &&
        (dataset.filters == std::vector<int>{H5Z_FILTER_DEFLATE} ||
         dataset.filters == std::vector<int>{H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE}))
        return "is compressed without a checksum; write it with fletcher32 (h5py: "
               "fletcher32=True), "
               "which is what tells damage";
    std::vector<int> rest = dataset.filters;
    if (!rest.empty() && rest.back() == H5Z_FILTER_FLETCHER32) {
        rest.pop_back();
        if (may_be_packed)
            for (const int filter : {H5Z_FILTER_DEFLATE, H5Z_FILTER_SHUFFLE})
                if (!rest.empty() && rest.back() == filter)
                    rest.pop_back();
    }
    if (rest.empty())
        return {};
    return join("is stored with filter ", rest.back(),
                " (compression?); only the checksum fletcher32 is read and, of float64 values, "
                "shuffle and deflate below it");
}

std::string broken_rule_of_storage(const StoredDataset& dataset)
{
    if (dataset.layout == StoredDataset::Layout::Other)
        return "has a virtual or unknown layout";
    if (dataset.is_external)
        return "has its values in another file";
    return broken_rule_of_filters(dataset);
}

std::string broken_rule_of_extents(const StoredDataset& dataset, std::uint64_t file_size)
{
    const auto value_size = static_cast<Index>(dataset.value_size);
    const Index room = static_cast<Index>(file_size) * (dataset.is_compressed() ? best_packing : 1);
    Index count = 1;
    for (const Index length : dataset.extents) {
        if (length < 1)
            return "has no values";
        if (length > room / value_size / count)
            return join("declares ", print_extents(dataset.extents), " values of ", value_size,
                        " bytes, more than the file can hold");
        count *= length;
    }
    Index room_in_chunk = largest_chunk / value_size;
    for (const Index length : dataset.chunk) {
        if (length < 1)
            return "has chunks without values";
        room_in_chunk /= length;
    }
    if (room_in_chunk == 0)
        return join("has chunks of more than ", largest_chunk, " bytes");
    if (dataset.chunk.size() !=
        (dataset.layout == StoredDataset::Layout::Chunked ? dataset.extents.size() : 0))
        return "has chunks of another rank";
    if (!dataset.chunk.empty() && dataset.chunk_count() > most_chunks)
        return join("is stored in ", dataset.chunk_count(), " chunks; the limit is ", most_chunks);
    return {};
}

} // namespace

bool StoredDataset::is_compressed() const
{
    return std::ranges::find(filters, H5Z_FILTER_DEFLATE) != filters.end();
}

Index StoredDataset::count() const
{
    Index product = 1;
    for (const Index length : extents)
        product *= length;
    return product;
}

Index StoredDataset::chunk_count() const
{
    Index product = 1;
    for (std::size_t d = 0; d < chunk.size(); ++d)
        product *= (extents[d] - 1) / chunk[d] + 1;
    return product;
}

std::string broken_rule(const StoredDataset& dataset, std::uint64_t file_size)
{
    if (dataset.rank < 0 || dataset.rank > 3 || dataset.extents.size() != to_size(dataset.rank))
        return "must be a single value or an array of at most 3 dimensions";
    if (dataset.value_size == 0 || dataset.value_size > longest_string)
        return join("has values of ", dataset.value_size, " bytes; the limit is ", longest_string);
    if (std::string rule = broken_rule_of_storage(dataset); !rule.empty())
        return rule;
    return broken_rule_of_extents(dataset, file_size);
}

std::string print_extents(const Extents& extents)
{
    std::string text;
    for (const Index length : extents)
        text += (text.empty() ? "" : " by ") + (length == any_length ? "any" : join(length));
    return text.empty() ? "single value" : text;
}

} // namespace shape::internal
