// SPDX-License-Identifier: MIT

#include "libshape/io/collection_stream.h"

#include <utility>

#include "libshape/base/to_size.h"
#include "libshape/io/file_parts.h"

namespace shape {
using namespace internal;

MeshStream open_collection(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Collection);
    StoredRows rows = file.rows("/points", {any_length, any_length, 3});
    const Eigen::Index count = rows.count();
    const auto bytes = rows.stored_bytes() / static_cast<std::uint64_t>(count);
    return {read_topology(file, rows.size() / 3), read_names(file, count), read_labels(file, count),
            bytes, [rows = std::move(rows)](std::vector<Eigen::Index> meshes) {
                return [rows, fetched = rows.fetch(std::move(meshes))](std::span<Points> points) {
                    rows.unpack(*fetched, [&](std::size_t i) { return points[i].data(); });
                };
            }};
}

} // namespace shape
