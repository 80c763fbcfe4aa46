// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "libshape/embedding/embedder.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

/// Points between two meshes, which no mesh has: linear start, descent and repair all have work to do.
std::vector<ShapePoint> between(const Topology& topology, const Points& first, const Points& second)
{
    const ShapePoint a = test::shape_of(topology, first);
    const ShapePoint b = test::shape_of(topology, second);
    std::vector<ShapePoint> points;
    for (const double t : {0.3, 0.5, 0.7})
        points.push_back({(1.0 - t) * a.edge_lengths + t * b.edge_lengths,
                          (1.0 - t) * a.dihedral_angles + t * b.dihedral_angles});
    return points;
}

/// Every target embedded by one embedder, each in a thread of its own; the first call to come makes
/// what all of them need.
std::vector<Points> embedded_at_once(const Embedder& embedder,
                                     const std::vector<ShapePoint>& targets)
{
    std::vector<Points> found(targets.size());
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < targets.size(); ++i)
        threads.emplace_back([&, i] { found[i] = embedder.embed(targets[i]).points; });
    for (std::thread& thread : threads)
        thread.join();
    return found;
}

TEST(Concurrency, AnEmbedderCalledFromSeveralThreadsGivesTheBitsOfOne)
{
    const test::ThreadScope scope(2);
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.4, 1);
    const std::vector<Points> references{mesh.points, test::bumpy_sphere(2, 0.4, 2).points};
    const std::vector<ShapePoint> targets = between(mesh.topology, references[0], references[1]);
    for (const EmbeddingQuality quality : {EmbeddingQuality::Preview, EmbeddingQuality::Fine}) {
        const EmbeddingOptions options{.quality = quality};
        const std::vector<Points> found =
            embedded_at_once(Embedder(mesh.topology, references, options), targets);
        const Embedder alone(mesh.topology, references, options);
        for (std::size_t i = 0; i < targets.size(); ++i)
            EXPECT_EQ(found[i], alone.embed(targets[i]).points) << i;
    }
}

} // namespace
} // namespace shape
