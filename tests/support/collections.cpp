// SPDX-License-Identifier: MIT

#include "tests/support/collections.h"

#include <algorithm>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/io/label_file.h"
#include "libshape/io/mesh_file.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"

namespace shape::test {
using namespace internal;
namespace {

std::filesystem::path ict_folder()
{
    return data_dir() / "ict_faces600";
}

} // namespace

Collection bumpy_spheres(int count, unsigned seed)
{
    Random random(seed);
    Collection collection{icosphere(1).topology, {}, {}, {}};
    for (int i = 0; i < count; ++i) {
        const auto shape_seed = static_cast<unsigned>(random.index(1u << 30));
        collection.names.push_back(join("sphere", i / 10, i % 10));
        collection.points.push_back(random.uniform(0.5, 2.0) *
                                    bumpy_sphere(1, 0.3, shape_seed).points);
    }
    return moved(std::move(collection), seed + 1);
}

Collection moved(Collection collection, unsigned seed)
{
    for (Points& points : collection.points)
        points = moved(points, seed++);
    return collection;
}

Collection ict_faces()
{
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(ict_folder()))
        if (entry.path().extension() == ".ply")
            paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<NamedMesh> meshes;
    for (const auto& path : paths)
        meshes.push_back(read_mesh(path));
    Collection collection = collect(std::move(meshes));
    collection.labels = read_label_file(ict_folder() / "labels.csv", collection.names).labels;
    return collection;
}

bool has_ict_faces()
{
    return std::filesystem::exists(ict_folder());
}

} // namespace shape::test
