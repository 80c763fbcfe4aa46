// SPDX-License-Identifier: MIT

#include "libshape/embedding/patch_frames.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"

namespace shape {
namespace {

using Eigen::Matrix3d;

/// The three smallest eigenvectors, stacked 3 by 3 blocks, by inverse iterations from a fixed start.
Eigen::MatrixXd smallest_eigenvectors(const SparseMatrix& matrix)
{
    const SparseCholesky factor(matrix, Ordering::MinimumDegree);
    Random random(1);
    Eigen::MatrixXd vectors =
        Eigen::MatrixXd::NullaryExpr(matrix.rows(), 3, [&] { return random.uniform(-1.0, 1.0); });
    // The gap to the fourth eigenvalue is that of smooth fields, so a few iterations suffice.
    constexpr int iterations = 5;
    for (int i = 0; i < iterations; ++i) {
        const Eigen::HouseholderQR<Eigen::MatrixXd> qr(factor.solve(vectors));
        vectors = qr.householderQ() * Eigen::MatrixXd::Identity(matrix.rows(), 3);
    }
    return vectors;
}

} // namespace

PatchFrames::PatchFrames(const Topology& topology, int faces_per_patch)
    : topology_(topology), patch_of_face_(static_cast<std::size_t>(topology.face_count()), -1)
{
    // Breadth-first discs; the faces left over at the rim of one seed the next.
    std::deque<int> seeds{0};
    while (!seeds.empty()) {
        const int seed = seeds.front();
        seeds.pop_front();
        if (patch_of_face_[static_cast<std::size_t>(seed)] >= 0)
            continue;
        const int patch = patch_count();
        std::vector<int> faces{seed};
        patch_of_face_[static_cast<std::size_t>(seed)] = patch;
        for (std::size_t i = 0; i < faces.size(); ++i)
            for (int h = 3 * faces[i]; h < 3 * faces[i] + 3; ++h) {
                const int opposite = topology.opposite(h);
                if (opposite < 0)
                    continue;
                int& neighbour = patch_of_face_[static_cast<std::size_t>(opposite / 3)];
                if (neighbour >= 0)
                    continue;
                if (static_cast<int>(faces.size()) < faces_per_patch) {
                    neighbour = patch;
                    faces.push_back(opposite / 3);
                } else {
                    seeds.push_back(opposite / 3);
                }
            }
        patches_.push_back(std::move(faces));
    }
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!topology.is_boundary_edge(e) &&
            patch_of_face_[static_cast<std::size_t>(topology.edge_halfedges()(e, 0) / 3)] !=
                patch_of_face_[static_cast<std::size_t>(topology.edge_halfedges()(e, 1) / 3)])
            bridges_.push_back(e);
}

std::vector<Matrix3d> PatchFrames::face_frames(const std::vector<Matrix3d>& transitions,
                                               const Eigen::VectorXd& weights) const
{
    if (transitions.size() != static_cast<std::size_t>(topology_.edge_count()) ||
        weights.size() != topology_.edge_count())
        throw InvalidInput(join("face frames: ", transitions.size(), " transitions and ",
                                weights.size(), " weights for ", topology_.edge_count(), " edges"));
    const auto across = [&](int h) -> Matrix3d {
        const int e = topology_.edge(h);
        const Matrix3d& t = transitions[static_cast<std::size_t>(e)];
        return h == topology_.edge_halfedges()(e, 0) ? t : Matrix3d(t.transpose());
    };

    // Within patches: Prim's tree of the heaviest edges, weights told apart where they differ by
    // a twelfth.
    std::vector<Matrix3d> frames(static_cast<std::size_t>(topology_.face_count()));
    // The lightest edge on the way from the root; -1 before the face has its frame.
    std::vector<double> trust(frames.size(), -1.0);
    parallel_for(patches_.size(), 16, [&](std::size_t begin, std::size_t end) {
        constexpr int levels = 81;
        struct Queue // first in, first out: trees stay shallow
        {
            std::vector<int> halfedges;
            std::size_t next = 0;
        };
        std::array<Queue, levels> front; // by weight
        for (std::size_t p = begin; p < end; ++p) {
            int highest = -1;
            const auto place = [&](int face, const Matrix3d& frame, double weight) {
                frames[static_cast<std::size_t>(face)] = frame;
                trust[static_cast<std::size_t>(face)] = weight;
                for (int h = 3 * face; h < 3 * face + 3; ++h) {
                    const int o = topology_.opposite(h);
                    if (o >= 0 &&
                        patch_of_face_[static_cast<std::size_t>(o / 3)] == static_cast<int>(p) &&
                        trust[static_cast<std::size_t>(o / 3)] < 0.0) {
                        const int level = std::max(
                            0, levels - 1 +
                                   static_cast<int>(
                                       std::floor(8.0 * std::log2(weights[topology_.edge(h)]))));
                        front[static_cast<std::size_t>(level)].halfedges.push_back(h);
                        highest = std::max(highest, level);
                    }
                }
            };
            place(patches_[p].front(), Matrix3d::Identity(), 1.0);
            while (highest >= 0) {
                Queue& heaviest = front[static_cast<std::size_t>(highest)];
                if (heaviest.next == heaviest.halfedges.size()) {
                    heaviest.halfedges.clear();
                    heaviest.next = 0;
                    --highest;
                    continue;
                }
                const int h = heaviest.halfedges[heaviest.next++];
                const int face = topology_.opposite(h) / 3;
                if (trust[static_cast<std::size_t>(face)] < 0.0)
                    place(face, frames[static_cast<std::size_t>(h / 3)] * across(h),
                          std::min(trust[static_cast<std::size_t>(h / 3)],
                                   weights[topology_.edge(h)]));
            }
        }
    });
    if (patches_.size() == 1)
        return frames;

    // Between patches: G_p A = G_q for every bridge, A = L_f T L_g^T.
    const int count = patch_count();
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(bridges_.size() * 9 + static_cast<std::size_t>(3 * count));
    Eigen::VectorXd degree = Eigen::VectorXd::Zero(count);
    for (const int e : bridges_) {
        const int left = topology_.edge_halfedges()(e, 0) / 3;
        const int right = topology_.edge_halfedges()(e, 1) / 3;
        int p = patch_of_face_[static_cast<std::size_t>(left)];
        int q = patch_of_face_[static_cast<std::size_t>(right)];
        // A frame that hangs by an edge of little trust has no say about other patches.
        const double weight = weights[e] * trust[static_cast<std::size_t>(left)] *
                              trust[static_cast<std::size_t>(right)];
        Matrix3d block = -weight * frames[static_cast<std::size_t>(right)] *
                         transitions[static_cast<std::size_t>(e)].transpose() *
                         frames[static_cast<std::size_t>(left)].transpose(); // row q, column p
        degree[p] += weight;
        degree[q] += weight;
        if (p > q) { // only the lower triangle is kept
            std::swap(p, q);
            block.transposeInPlace();
        }
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                entries.emplace_back(3 * q + i, 3 * p + j, block(i, j));
    }
    // Where all loops close the matrix is singular: a shift far below its spectrum's gap.
    const double shift = 1e-9 * degree.mean();
    for (int p = 0; p < count; ++p)
        for (int i = 0; i < 3; ++i)
            entries.emplace_back(3 * p + i, 3 * p + i, degree[p] + shift);
    SparseMatrix laplacian(3 * count, 3 * count);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    const Eigen::MatrixXd vectors = smallest_eigenvectors(laplacian);

    // The vectors are the rows of the matrices G; their common sign is free, a reflection is not.
    std::vector<Matrix3d> patch_frames(static_cast<std::size_t>(count));
    double determinants = 0.0;
    for (int p = 0; p < count; ++p) {
        Matrix3d& g = patch_frames[static_cast<std::size_t>(p)];
        g = std::sqrt(static_cast<double>(count)) * vectors.middleRows(3 * p, 3).transpose();
        determinants += g.determinant();
    }
    parallel_for(patches_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            Matrix3d& g = patch_frames[p];
            if (determinants < 0.0)
                g.row(0) *= -1.0;
            g = nearest_rotation(g);
            for (const int f : patches_[p])
                frames[static_cast<std::size_t>(f)] = g * frames[static_cast<std::size_t>(f)];
        }
    });
    return frames;
}

} // namespace shape
