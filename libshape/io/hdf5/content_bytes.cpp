// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/content_bytes.h"

#include <nlohmann/json.hpp>

namespace shape::internal {

// As CBOR, whose strings take any bytes; names in files are not always UTF-8. The functions have the names that
// nlohmann_json looks for.

template <class Value>
void to_json(nlohmann::json& json, const Found<Value>& found)
{
    json = nlohmann::json::array({found.value, found.refusal});
}

template <class Value>
void from_json(const nlohmann::json& json, Found<Value>& found)
{
    json.at(0).get_to(found.value);
    json.at(1).get_to(found.refusal);
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StoredDataset::Range, begin, size)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StoredDataset, type, value_size, rank, extents, layout,
                                   is_external, chunk, filters, offset, values, refusal)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StoredAttribute, name, text, integer)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StoredObject, refusal, dataset)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FileContent, refusal, attributes, groups, objects)

std::string to_bytes(const FileContent& content)
{
    std::string bytes;
    nlohmann::json::to_cbor(content, bytes);
    return bytes;
}

std::optional<FileContent> from_bytes(const std::string& bytes)
{
    try {
        return nlohmann::json::from_cbor(bytes).get<FileContent>();
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

} // namespace shape::internal
