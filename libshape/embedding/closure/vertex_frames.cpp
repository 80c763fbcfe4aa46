// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/vertex_frames.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {

std::vector<Eigen::Matrix3d> vertex_frames(const Topology& topology,
                                           const std::vector<Eigen::Matrix3d>& transitions)
{
    const int edge_count = topology.edge_count();
    if (transitions.size() != to_size(edge_count))
        throw InvalidInput(join("transitions has ", transitions.size(), " entries, the topology ",
                                edge_count, " edges"));
    // Transposed, the equation of an edge is M^T G_v^T = G_u^T: the unknowns are the G_v^T, stacked.
    // Since M is a rotation, the normal matrix has deg(v) I on its diagonal and -M^T in block (u, v).
    const int size = 3 * (topology.vertex_count() - 1);
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(to_size(size + 9 * edge_count));
    Eigen::VectorXd degree = Eigen::VectorXd::Zero(topology.vertex_count());
    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(size, 3);
    for (int e = 0; e < edge_count; ++e) {
        const int h = topology.edge_halfedges()(e, 0);
        int v = topology.source(h);
        int u = topology.target(h);
        Eigen::Matrix3d block = -transitions[to_size(e)].transpose(); // (u, v)
        if (v > u) {
            std::swap(v, u);
            block.transposeInPlace();
        }
        degree[v] += 1.0;
        degree[u] += 1.0;
        if (v == 0) { // G_0 is known
            rhs.middleRows<3>(3 * (u - 1)) -= block;
            continue;
        }
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                entries.emplace_back(3 * (u - 1) + i, 3 * (v - 1) + j, block(i, j));
    }
    for (int i = 0; i < size; ++i)
        entries.emplace_back(i, i, degree[i / 3 + 1]);
    SparseMatrix normal(size, size); // lower triangle
    normal.setFromTriplets(entries.begin(), entries.end());
    const Eigen::MatrixXd solution = SparseCholesky(normal, Ordering::MinimumDegree).solve(rhs);

    std::vector<Eigen::Matrix3d> frames(to_size(topology.vertex_count()));
    frames[0].setIdentity();
    parallel_for(frames.size() - 1, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            frames[i + 1] = nearest_rotation(
                solution.middleRows<3>(3 * static_cast<Eigen::Index>(i)).transpose());
    });
    return frames;
}

} // namespace shape::internal
