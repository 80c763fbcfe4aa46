// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/rigid_filling.h"

#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

// As-rigid-as-possible filling of eight problems at once (layout: eight_lane_energy.cpp): in turns
//
//     R_v = nearest rotation to  sum_w (x_w - x_v) (u_w - u_v)^T / |u_w - u_v|^2,     u: the reference,
//     L x = sum over edges (R_a + R_b) (u_b - u_a) / 2 / (l |u_b - u_a|),              L: the Laplacian, kept.
//
// The nearest rotation by a singular value decomposition, the plain way, branches on its values and
// iterates until each has converged: eight lanes would wait for the last. A few steps about the axis of the
// torque have no branch, and start from the rotation of the sweep before, which is near.

/// By columns: matrix * u = u.x * x + u.y * y + u.z * z.
struct EightLaneMatrix
{
    EightLanePoint x, y, z;
};

inline EightLanePoint operator*(const EightLaneMatrix& m, const EightLanePoint& u)
{
    return u.x * m.x + u.y * m.y + u.z * m.z;
}

/// m + scale a b^T.
inline EightLaneMatrix plus_outer(const EightLaneMatrix& m, const EightLanes& scale,
                                  const EightLanePoint& a, const EightLanePoint& b)
{
    return {m.x + (scale * b.x) * a, m.y + (scale * b.y) * a, m.z + (scale * b.z) * a};
}

/// Steps from a rotation towards the one that maximises trace(R^T m): about the axis of the torque
/// that pulls the columns together (Mueller et al. 2016).
inline EightLaneMatrix turned_towards(const EightLaneMatrix& start, const EightLaneMatrix& m,
                                      int steps)
{
    EightLaneMatrix r = start;
    for (int step = 0; step < steps; ++step) {
        const EightLanes trace = dot(r.x, m.x) + dot(r.y, m.y) + dot(r.z, m.z);
        const EightLanes bound = sqrt(trace * trace) + EightLanes::all(least_square);
        const EightLanePoint half =
            (EightLanes::all(0.5F) / bound) * (cross(r.x, m.x) + cross(r.y, m.y) + cross(r.z, m.z));
        const EightLanes scale = EightLanes::all(2.0F) / (EightLanes::all(1.0F) + dot(half, half));
        const auto turn = [&](const EightLanePoint& column) {
            const EightLanePoint swept = cross(half, column);
            return column + scale * (swept + cross(half, swept));
        };
        r = {turn(r.x), turn(r.y), turn(r.z)};
    }
    return r;
}

inline EightLanePoint unit(const EightLanePoint& a)
{
    return (EightLanes::all(1.0F) / sqrt(dot(a, a) + EightLanes::all(least_square))) * a;
}

/// Rotations of rim vertices from the identity to where the faces outside lie.
SHAPE_VECTORISED void turn_rim(const RegionMesh& region, const EightLanePoint* references,
                               const EightLanePoint* points, EightLaneMatrix* __restrict rotations)
{
    const int* const corners = region.corners.data();
    for (int v = region.moving_vertices; v < region.moving_vertices + region.rim_vertices; ++v) {
        EightLaneMatrix covariance{};
        for (int i = region.halfedge_begins.data()[v]; i < region.halfedge_begins.data()[v + 1];
             ++i) {
            const int h = region.halfedges.data()[i];
            if (h / 3 < region.moving_faces)
                continue;
            const int a = corners[h % 3 == 2 ? h - 2 : h + 1];
            const int b = corners[h % 3 == 0 ? h + 2 : h - 1];
            const EightLanePoint ua = references[a] - references[v];
            const EightLanePoint ub = references[b] - references[v];
            const EightLanePoint xa = points[a] - points[v];
            const EightLanePoint xb = points[b] - points[v];
            covariance = plus_outer(covariance, EightLanes::all(1.0F), unit(xa), unit(ua));
            covariance = plus_outer(covariance, EightLanes::all(1.0F), unit(xb), unit(ub));
            covariance = plus_outer(covariance, EightLanes::all(1.0F), unit(cross(xa, xb)),
                                    unit(cross(ua, ub)));
        }
        constexpr int steps =
            10; // from the identity, though the rim may have turned by half a turn
        rotations[v] = turned_towards(rotations[v], covariance, steps);
    }
}

/// Rotations of moving vertices from those of the sweep before.
SHAPE_VECTORISED void turn_moving(const RegionMesh& region, const EightLanePoint* references,
                                  const EightLanePoint* points,
                                  EightLaneMatrix* __restrict rotations)
{
    const int* const corners = region.corners.data();
    const int* const begins = region.halfedge_begins.data();
    const int* const halfedges = region.halfedges.data();
    for (int v = 0; v < region.moving_vertices; ++v) {
        EightLaneMatrix covariance{};
        for (int i = begins[v]; i < begins[v + 1]; ++i) {
            const int h = halfedges[i];
            const int a = corners[h % 3 == 2 ? h - 2 : h + 1];
            const EightLanePoint u = references[a] - references[v];
            covariance = plus_outer(
                covariance, EightLanes::all(1.0F) / (dot(u, u) + EightLanes::all(least_square)),
                points[a] - points[v], u);
        }
        constexpr int steps = 2; // from the sweep before; the sweeps go on anyway
        rotations[v] = turned_towards(rotations[v], covariance, steps);
    }
}

SHAPE_VECTORISED void nearest_rotations(int count, const EightLanePoint* x, const EightLanePoint* y,
                                        const EightLanePoint* z,
                                        EightLaneMatrix* __restrict rotations)
{
    constexpr int steps = 8; // from the identity, like the rim
    for (int v = 0; v < count; ++v)
        rotations[v] = turned_towards(rotations[v], {x[v], y[v], z[v]}, steps);
}

/// What every edge a-b wants of x_b - x_a, times its weight 1 / length^2.
SHAPE_VECTORISED void edge_pulls(int count, const int* ends, const float* lengths,
                                 const EightLanePoint* references, const EightLaneMatrix* rotations,
                                 EightLanePoint* __restrict pulls)
{
    for (int e = 0; e < count; ++e) {
        const int a = ends[2 * e];
        const int b = ends[2 * e + 1];
        const EightLanePoint along = unit(references[b] - references[a]);
        pulls[e] = (0.5F / lengths[e]) * (rotations[a] * along + rotations[b] * along);
    }
}

/// Right-hand sides: what edges pull at moving vertices, and what holds them at the rim.
SHAPE_VECTORISED void gather(const RegionMesh& region, const EightLanePoint* pulls,
                             const EightLanePoint* held, EightLanePoint* __restrict sums)
{
    const int* const begins = region.edge_begins.data();
    const int* const edges = region.incident_edges.data();
    for (int v = 0; v < region.moving_vertices; ++v) {
        EightLanePoint sum = held[v];
        for (int i = begins[v]; i < begins[v + 1]; ++i) {
            const int e = edges[i] < 0 ? ~edges[i] : edges[i];
            const float sign = edges[i] < 0 ? -1.0F : 1.0F;
            sum = sum + sign * pulls[e];
        }
        sums[v] = sum;
    }
}

/// Sum over the rim vertices that moving ones are joined to: value / length^2.
template <class Value>
EightLanePoints pull_of_rim(const RegionMesh& region, const std::vector<float>& lengths,
                            const Value& value)
{
    EightLanePoints sums(to_size(region.moving_vertices));
    for (std::size_t e = 0; e < lengths.size(); ++e) {
        const int a = region.ends[2 * e];
        const int b = region.ends[2 * e + 1];
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
            if (from < region.moving_vertices && to >= region.moving_vertices) {
                EightLanePoint& sum = sums[to_size(from)];
                sum = sum + (1.0F / (lengths[e] * lengths[e])) * value(to_size(to));
            }
    }
    return sums;
}

} // namespace

void fill_rigidly(const RegionMesh& region, const std::vector<float>& lengths,
                  const EightLaneSolve& laplacian, const EightLanePoints& references, int sweeps,
                  EightLanePoints& points)
{
    const EightLanes one = EightLanes::all(1.0F);
    std::vector<EightLaneMatrix> rotations(to_size(region.moving_vertices + region.rim_vertices),
                                           {{one, {}, {}}, {{}, one, {}}, {{}, {}, one}});
    turn_rim(region, references.data(), points.data(), rotations.data());

    // Blended inwards by columns.
    const auto blended = [&](EightLanePoint EightLaneMatrix::*column) {
        EightLanePoints sums = pull_of_rim(
            region, lengths,
            [&](std::size_t v) -> const EightLanePoint& { return rotations[v].*column; });
        laplacian.solve(sums);
        return sums;
    };
    const EightLanePoints x = blended(&EightLaneMatrix::x);
    const EightLanePoints y = blended(&EightLaneMatrix::y);
    const EightLanePoints z = blended(&EightLaneMatrix::z);
    nearest_rotations(region.moving_vertices, x.data(), y.data(), z.data(), rotations.data());

    const EightLanePoints held = pull_of_rim(
        region, lengths, [&](std::size_t v) -> const EightLanePoint& { return points[v]; });
    EightLanePoints pulls(lengths.size());
    EightLanePoints sums(held.size());
    for (int sweep = 0; sweep <= sweeps; ++sweep) {
        if (sweep > 0)
            turn_moving(region, references.data(), points.data(), rotations.data());
        edge_pulls(region.edge_count(), region.ends.data(), lengths.data(), references.data(),
                   rotations.data(), pulls.data());
        gather(region, pulls.data(), held.data(), sums.data());
        laplacian.solve(sums);
        std::copy(sums.begin(), sums.end(), points.begin());
    }
}

} // namespace shape::internal
