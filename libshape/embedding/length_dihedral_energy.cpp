// SPDX-License-Identifier: MIT

#include "libshape/embedding/length_dihedral_energy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"

namespace shape {

using Eigen::VectorXd;

namespace {

/// Edges or faces are worked on by blocks, one array a coordinate, which the compiler vectorises and
/// the first cache holds.
constexpr int block = 128;
using Row = double[block];
struct alignas(64) Vectors
{
    Row x, y, z;

    void set(int i, double to_x, double to_y, double to_z)
    {
        x[i] = to_x;
        y[i] = to_y;
        z[i] = to_z;
    }
    void set(int i, const double* from) { set(i, from[0], from[1], from[2]); }
    void get(int i, double* to) const
    {
        to[0] = x[i];
        to[1] = y[i];
        to[2] = z[i];
    }
};

/// Calls work(first, count) for consecutive blocks of [0, total).
template <class Work>
void for_blocks(int total, const Work& work)
{
    parallel_for(static_cast<std::size_t>(total), 16 * block,
                 [&](std::size_t begin, std::size_t end) {
                     for (int i = static_cast<int>(begin); i < static_cast<int>(end); i += block)
                         work(i, std::min(block, static_cast<int>(end) - i));
                 });
}

/// Normals as long as twice the area, and their inverse squares (0 where there is no area).
SHAPE_VECTORISED void normals_of(int count, const Vectors& a, const Vectors& b, const Vectors& c,
                                 Vectors& __restrict normal, double* __restrict inverse_squares)
{
    for (int i = 0; i < count; ++i) {
        const double px = b.x[i] - a.x[i], py = b.y[i] - a.y[i], pz = b.z[i] - a.z[i];
        const double qx = c.x[i] - a.x[i], qy = c.y[i] - a.y[i], qz = c.z[i] - a.z[i];
        const double x = py * qz - pz * qy;
        const double y = pz * qx - px * qz;
        const double z = px * qy - py * qx;
        const double square = x * x + y * y + z * z;
        normal.x[i] = x;
        normal.y[i] = y;
        normal.z[i] = z;
        inverse_squares[i] = square > 0.0 ? 1.0 / square : 0.0;
    }
}

/// Lengths of edges p - q, and a vector in the direction theta - theta*: the bending of the normals
/// on the left and the right, turned back by theta*.
SHAPE_VECTORISED void bends(int count, const Vectors& p, const Vectors& q, const Vectors& left,
                            const Vectors& right, const double* sines, const double* cosines,
                            double* __restrict lengths, double* __restrict bend_sines,
                            double* __restrict bend_cosines)
{
    for (int i = 0; i < count; ++i) {
        const double x = q.x[i] - p.x[i], y = q.y[i] - p.y[i], z = q.z[i] - p.z[i];
        const double length = std::sqrt(x * x + y * y + z * z);
        const double s = x * (left.y[i] * right.z[i] - left.z[i] * right.y[i]) +
                         y * (left.z[i] * right.x[i] - left.x[i] * right.z[i]) +
                         z * (left.x[i] * right.y[i] - left.y[i] * right.x[i]);
        const double c =
            length * (left.x[i] * right.x[i] + left.y[i] * right.y[i] + left.z[i] * right.z[i]);
        lengths[i] = length;
        bend_sines[i] = s * cosines[i] - c * sines[i];
        bend_cosines[i] = c * cosines[i] + s * sines[i];
    }
}

/// What every edge adds to the energy, half of dE/dl / l, and dE/dtheta in the place of
/// theta - theta*.
SHAPE_VECTORISED void edge_terms(int count, double smoothness, const double* lengths,
                                 const double* inverse_lengths, double* __restrict energies,
                                 double* __restrict half_pulls, double* __restrict angles)
{
    for (int i = 0; i < count; ++i) {
        const double strain = lengths[i] * inverse_lengths[i] - 1.0;
        const auto [value, weight] = stretch_term(strain);
        energies[i] = value + smoothness * angles[i] * angles[i];
        half_pulls[i] = lengths[i] > 0.0 ? weight * strain * inverse_lengths[i] / lengths[i] : 0.0;
        angles[i] *= 2.0 * smoothness;
    }
}

/// Corners of faces; of edge quantities x, y, z belong to the edges 0-1, 1-2, 2-0.
struct Corners
{
    Vectors a{}, b{}, c{};
};

/// The gradient that every face adds at its corners.
///
/// Over edge i-j with opposite corner m, d theta / d x_m = -l n / |n|^2, and i and j share the
/// opposite of it in proportion to where the foot of m lies.
SHAPE_VECTORISED void corner_gradients(int count, const Corners& at, const Vectors& normal,
                                       const double* inverse_squares, const Vectors& lengths,
                                       const Vectors& moments, const Vectors& pulls,
                                       Corners& __restrict gradient)
{
    const auto& [p, q, r] = at;
    auto& [gp, gq, gr] = gradient;
    for (int i = 0; i < count; ++i) {
        const double a = lengths.x[i], b = lengths.y[i], c = lengths.z[i];
        const double u = moments.x[i], v = moments.y[i], w = moments.z[i];
        const double aa = a * a, bb = b * b, cc = c * c;
        // From the first corner of each edge to the foot.
        const double foot_a = a > 0.0 ? 0.5 * (aa + cc - bb) / a : 0.0;
        const double foot_b = b > 0.0 ? 0.5 * (bb + aa - cc) / b : 0.0;
        const double foot_c = c > 0.0 ? 0.5 * (cc + bb - aa) / c : 0.0;
        const double mp = inverse_squares[i] * (u * (a - foot_a) - v * b + w * foot_c);
        const double mq = inverse_squares[i] * (v * (b - foot_b) - w * c + u * foot_a);
        const double mr = inverse_squares[i] * (w * (c - foot_c) - u * a + v * foot_b);
        const auto along = [&](double np, const Row& x, const Row& y, const Row& z, Row& gx,
                               Row& gy, Row& gz) {
            const double xy = pulls.x[i] * (x[i] - y[i]);
            const double yz = pulls.y[i] * (y[i] - z[i]);
            const double zx = pulls.z[i] * (z[i] - x[i]);
            gx[i] = mp * np + xy - zx;
            gy[i] = mq * np + yz - xy;
            gz[i] = mr * np + zx - yz;
        };
        along(normal.x[i], p.x, q.x, r.x, gp.x, gq.x, gr.x);
        along(normal.y[i], p.y, q.y, r.y, gp.y, gq.y, gr.y);
        along(normal.z[i], p.z, q.z, r.z, gp.z, gq.z, gr.z);
    }
}

} // namespace

LengthDihedralEnergy::LengthDihedralEnergy(const Topology& topology, const ShapePoint& target,
                                           double smoothness)
    : topology_(topology), target_(target), smoothness_(smoothness)
{
    const int edges = topology.edge_count();
    if (target.edge_lengths.size() != edges || target.dihedral_angles.size() != edges)
        throw InvalidInput(join("target has ", target.edge_lengths.size(), " lengths and ",
                                target.dihedral_angles.size(), " dihedral angles, the topology ",
                                edges, " edges"));
    for (int e = 0; e < edges; ++e)
        if (!(target.edge_lengths[e] > 0.0 && std::isfinite(target.edge_lengths[e]) &&
              std::isfinite(target.dihedral_angles[e])))
            throw InvalidInput(join("target: edge ", e, " (", topology.edges()(e, 0), "-",
                                    topology.edges()(e, 1), ") has length ", target.edge_lengths[e],
                                    " and dihedral angle ", target.dihedral_angles[e],
                                    "; lengths must be > 0, both finite"));
    if (!(smoothness > 0.0 && std::isfinite(smoothness)))
        throw InvalidInput(join("smoothness is ", smoothness, ", must be > 0 and finite"));
    inverse_lengths_ = target.edge_lengths.cwiseInverse();
    sines_.resize(edges);
    cosines_.resize(edges);
    sines_cosines(target.dihedral_angles.data(), static_cast<std::size_t>(edges), sines_.data(),
                  cosines_.data());
    for (int e = 0; e < edges; ++e)
        if (topology.is_boundary_edge(e)) {
            sines_[e] = 0.0;
            cosines_[e] = 1.0;
        }
}

double LengthDihedralEnergy::evaluate(const VectorXd& points, VectorXd& gradient)
{
    const Topology& t = topology_;
    const int* const faces = t.faces().data();
    const int* const face_edges = t.face_edges().data();
    const auto gather_corners = [&](int first, int count, Corners& at) {
        for (int i = 0; i < count; ++i) {
            const int* const face = faces + 3 * (first + i);
            at.a.set(i, points.data() + 3 * face[0]);
            at.b.set(i, points.data() + 3 * face[1]);
            at.c.set(i, points.data() + 3 * face[2]);
        }
    };

    normals_.resize(t.face_count(), 3);
    inverse_squares_.resize(t.face_count());
    for_blocks(t.face_count(), [&](int first, int count) {
        Corners at;
        gather_corners(first, count, at);
        Vectors normal{};
        normals_of(count, at.a, at.b, at.c, normal, inverse_squares_.data() + first);
        for (int i = 0; i < count; ++i)
            normal.get(i, normals_.data() + 3 * (first + i));
    });

    for (VectorXd* const of_edges : {&lengths_, &energies_, &half_pulls_, &moments_})
        of_edges->resize(t.edge_count());
    for_blocks(t.edge_count(), [&](int first, int count) {
        Vectors p{}, q{}, left{}, right{};
        for (int i = 0; i < count; ++i) {
            const int* const ends = t.edges().data() + 2 * (first + i);
            const int* const halfedges = t.edge_halfedges().data() + 2 * (first + i);
            const int other = halfedges[halfedges[1] < 0 ? 0 : 1]; // the boundary is flat
            p.set(i, points.data() + 3 * ends[0]);
            q.set(i, points.data() + 3 * ends[1]);
            left.set(i, normals_.data() + 3 * (halfedges[0] / 3));
            right.set(i, normals_.data() + 3 * (other / 3));
        }
        Row sines, cosines;
        bends(count, p, q, left, right, sines_.data() + first, cosines_.data() + first,
              lengths_.data() + first, sines, cosines);
        double* const angles = moments_.data() + first;
        vector_angles(sines, cosines, static_cast<std::size_t>(count), angles);
        edge_terms(count, smoothness_, lengths_.data() + first, inverse_lengths_.data() + first,
                   energies_.data() + first, half_pulls_.data() + first, angles);
        for (int e = first; e < first + count; ++e)
            if (t.is_boundary_edge(e))
                half_pulls_[e] *= 2.0; // it has one face
    });

    at_corners_.resize(t.halfedge_count(), 3);
    for_blocks(t.face_count(), [&](int first, int count) {
        Corners at, sum;
        Vectors normal{}, length{}, moment{}, pull{};
        gather_corners(first, count, at);
        for (int i = 0; i < count; ++i) {
            const int* const e = face_edges + 3 * (first + i);
            normal.set(i, normals_.data() + 3 * (first + i));
            length.set(i, lengths_[e[0]], lengths_[e[1]], lengths_[e[2]]);
            moment.set(i, moments_[e[0]], moments_[e[1]], moments_[e[2]]);
            pull.set(i, half_pulls_[e[0]], half_pulls_[e[1]], half_pulls_[e[2]]);
        }
        corner_gradients(count, at, normal, inverse_squares_.data() + first, length, moment, pull,
                         sum);
        for (int i = 0; i < count; ++i) {
            double* const corners = at_corners_.data() + 9 * (first + i);
            sum.a.get(i, corners);
            sum.b.get(i, corners + 3);
            sum.c.get(i, corners + 6);
        }
    });

    gradient.resize(points.size());
    parallel_for(static_cast<std::size_t>(t.vertex_count()), 2048,
                 [&](std::size_t begin, std::size_t end) {
                     for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                         Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                         for (const int h : t.outgoing(v))
                             sum += at_corners_.row(h);
                         gradient.segment<3>(3 * v) = sum.transpose();
                     }
                 });
    return parallel_sum(static_cast<std::size_t>(t.edge_count()), 16 * block,
                        [&](std::size_t begin, std::size_t end) {
                            return std::accumulate(energies_.data() + begin, energies_.data() + end,
                                                   0.0);
                        });
}

} // namespace shape
