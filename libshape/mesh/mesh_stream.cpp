// SPDX-License-Identifier: MIT

#include "libshape/mesh/mesh_stream.h"

#include <algorithm>
#include <future>
#include <memory>
#include <numeric>
#include <set>
#include <system_error>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/joined_labels.h"

namespace shape {
using namespace internal;

using Eigen::Index;

MeshStream stream_of(const Collection& collection)
{
    return {collection.topology, collection.names, collection.labels,
            sizeof(double) * 3 * static_cast<std::uint64_t>(collection.topology.vertex_count()),
            [&collection](std::vector<Index> meshes) {
                return [&collection, chosen = std::move(meshes)](std::span<Points> points) {
                    for (std::size_t i = 0; i < points.size(); ++i)
                        points[i] = collection.points[to_size(chosen[i])];
                };
            }};
}

MeshStream subset(const MeshStream& stream, const std::vector<std::size_t>& meshes)
{
    MeshStream result{stream.topology, {}, {}, stream.bytes_per_mesh, {}};
    for (const LabelColumn& column : stream.labels)
        result.labels.push_back({column.name, {}});
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const std::size_t mesh = meshes[i];
        if (mesh >= stream.names.size())
            throw InvalidInput(
                join("meshes[", i, "] is ", mesh, ", must be in [0, ", stream.names.size(), ")"));
        if (i > 0 && mesh <= meshes[i - 1])
            throw InvalidInput(join("meshes[", i, "] is ", mesh, ", must be above ", meshes[i - 1],
                                    ": meshes of a stream come in their order"));
        result.names.push_back(stream.names[mesh]);
        for (std::size_t c = 0; c < result.labels.size(); ++c)
            result.labels[c].values.push_back(stream.labels[c].values[mesh]);
    }
    result.fetch = [fetch = stream.fetch, meshes](std::vector<Index> chosen) {
        for (Index& mesh : chosen)
            mesh = static_cast<Index>(meshes[to_size(mesh)]);
        return fetch(std::move(chosen));
    };
    return result;
}

MeshStream joined(const MeshStream& first, const MeshStream& second)
{
    if (!(first.topology == second.topology))
        throw InvalidInput("the meshes that are added have another triangulation");
    const std::set<std::string> names(first.names.begin(), first.names.end());
    for (const std::string& name : second.names)
        if (names.contains(name))
            throw InvalidInput(join("the name '", name,
                                    "' occurs twice; names of a collection must "
                                    "differ: rename one of the meshes"));
    MeshStream result = first;
    result.names.insert(result.names.end(), second.names.begin(), second.names.end());
    append_labels(result.labels, first.names.size(), second.labels, second.names.size());
    result.fetch = [count = first.size(), a = first.fetch,
                    b = second.fetch](std::vector<Index> meshes) -> MeshStream::Unpack {
        const auto border = std::lower_bound(meshes.begin(), meshes.end(), count);
        const auto before = to_size(border - meshes.begin());
        std::vector<Index> added(border, meshes.end());
        for (Index& mesh : added)
            mesh -= count;
        meshes.resize(before);
        std::vector<MeshStream::Unpack> parts;
        parts.push_back(meshes.empty() ? MeshStream::Unpack() : a(std::move(meshes)));
        parts.push_back(added.empty() ? MeshStream::Unpack() : b(std::move(added)));
        return [before, parts](std::span<Points> points) {
            if (parts[0])
                parts[0](points.first(before));
            if (parts[1])
                parts[1](points.subspan(before));
        };
    };
    return result;
}

void for_each_block(const MeshStream& stream, Index begin, Index end, Index size,
                    const std::function<void(Index, const Collection&)>& visit)
{
    const auto fetch = [&](Index first) {
        std::vector<Index> meshes(to_size(std::min(size, end - first)));
        std::iota(meshes.begin(), meshes.end(), first);
        return stream.fetch(std::move(meshes));
    };
    const auto fetch_ahead = [&](Index first) {
        try {
            return std::async(std::launch::async, fetch, first);
        } catch (const std::system_error&) { // no thread is to be had
            return std::async(std::launch::deferred, fetch, first);
        }
    };
    if (begin >= end)
        return;
    Collection block{stream.topology, {}, {}, {}};
    auto fetched = fetch_ahead(begin);
    for (Index first = begin; first < end; first += size) {
        block.points.resize(to_size(std::min(size, end - first)),
                            Points(stream.topology.vertex_count(), 3));
        {
            const MeshStream::Unpack unpack = fetched.get();
            if (first + size < end)
                fetched = fetch_ahead(first + size);
            unpack(block.points);
        }
        visit(first, block);
    }
}

} // namespace shape
