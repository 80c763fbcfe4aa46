// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/eight_lane_energy.h"

#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/embedding/energy/stretch_term.h"

namespace shape::internal {
namespace {

// The same sums as in gauss_newton_operator.cpp and length_dihedral_energy.cpp,
//
//     E_e = phi(s) + mu (theta - theta*)^2,     J^T r,     J^T J v,
//
// for eight positions of one small region at once. In memory each number of the region is eight floats
// side by side, one a position, which is one register with AVX2:
//
//     points    x: p0 p1 .. p7   y: p0 .. p7   z: p0 .. p7   of vertex 0,   the same of vertex 1,  ...
//     hinges    1 / h: p0 .. p7   f / (l h): p0 .. p7   of edge 0 of face 0,  of edge 1,  ...
//
// Eight plain loops would each read the indices anew and work on one float at a time: a region's faces
// do not lie in rows, but eight positions of a face do, so that no lane is ever idle. Lanes may not
// branch: what divides is kept from 0 instead.

/// Unit normals (0 without area); and of moving faces the slopes of the angle at each edge (hinge.h).
SHAPE_VECTORISED void face_terms(int count, int moving, const int* corners,
                                 const EightLanePoint* points, EightLanePoint* __restrict normals,
                                 HingeSlopes<EightLanes>* __restrict hinges)
{
    for (int f = 0; f < count; ++f) {
        const EightLanePoint& a = points[corners[3 * f]];
        const EightLanePoint& b = points[corners[3 * f + 1]];
        const EightLanePoint& c = points[corners[3 * f + 2]];
        const EightLanePoint ab = b - a, bc = c - b, ca = a - c;
        const EightLanePoint normal = cross(ca, ab);
        const EightLanes square = dot(normal, normal);
        const EightLanes inverse = sqrt(square) / (square + least_square);
        normals[f] = inverse * normal;
        if (f >= moving)
            continue;
        hinges[3 * f] = hinge_slopes(ab, ca, dot(ab, ab) + least_square, inverse);
        hinges[3 * f + 1] = hinge_slopes(bc, ab, dot(bc, bc) + least_square, inverse);
        hinges[3 * f + 2] = hinge_slopes(ca, bc, dot(ca, ca) + least_square, inverse);
    }
}

/// Of every edge: the residual of its strain, how it changes, and a vector in the direction
/// theta - theta*; and phi(strain).
SHAPE_VECTORISED void edge_terms(int count, const int* ends, const int* sides,
                                 const EightLanePoint* points, const EightLanePoint* normals,
                                 const float* inverse_lengths, const float* sines,
                                 const float* cosines, EightLanePoint* __restrict directions,
                                 EightLanes* __restrict strains, EightLanes* __restrict bend_sines,
                                 EightLanes* __restrict bend_cosines,
                                 EightLanes* __restrict energies)
{
    for (int e = 0; e < count; ++e) {
        const EightLanePoint along = points[ends[2 * e + 1]] - points[ends[2 * e]];
        const EightLanes length2 = dot(along, along);
        const EightLanes length = sqrt(length2);
        const EightLanes strain = inverse_lengths[e] * length - 1.0F;
        const StretchTerm<EightLanes> stretch = stretch_term(strain);
        energies[e] = stretch.value;
        const EightLanes root = sqrt(stretch.weight);
        strains[e] = root * strain;
        directions[e] = (inverse_lengths[e] * root * length / (length2 + least_square)) * along;
        const AngleVector<EightLanes> bend = turned_back(
            hinge_angle(along, length, normals[sides[2 * e] / 3], normals[sides[2 * e + 1] / 3]),
            sines[e], cosines[e]);
        bend_sines[e] = bend.sine;
        bend_cosines[e] = bend.cosine;
    }
}

/// Adds squares of bends, weighted, to the energies of edges, and sums those; weights the bends.
SHAPE_VECTORISED void bend_terms(int count, const float* weights, EightLanes* __restrict bends,
                                 EightLanes* __restrict energies, EightLanes* __restrict total)
{
    EightLanes sum{};
    for (int e = 0; e < count; ++e) {
        const EightLanes weighted = weights[e] * bends[e];
        energies[e] = energies[e] + weighted * bends[e];
        bends[e] = weighted;
        sum = sum + energies[e];
    }
    *total = sum;
}

/// How moving faces bend at their three edges.
SHAPE_VECTORISED void bend_faces(int moving, const int* corners, const EightLanePoint* v,
                                 const EightLanePoint* normals,
                                 const HingeSlopes<EightLanes>* hinges,
                                 EightLanes* __restrict bends)
{
    for (int f = 0; f < moving; ++f) {
        const EightLanes a = dot(normals[f], v[corners[3 * f]]);
        const EightLanes b = dot(normals[f], v[corners[3 * f + 1]]);
        const EightLanes c = dot(normals[f], v[corners[3 * f + 2]]);
        bends[3 * f] = bend_by_slopes(hinges[3 * f], a, b, c);
        bends[3 * f + 1] = bend_by_slopes(hinges[3 * f + 1], b, c, a);
        bends[3 * f + 2] = bend_by_slopes(hinges[3 * f + 2], c, a, b);
    }
}

SHAPE_VECTORISED void couple_edges(int count, const int* ends, const int* sides,
                                   const float* bend_weights, const EightLanePoint* v,
                                   const EightLanePoint* directions, const EightLanes* bends,
                                   EightLanes* __restrict tensions, EightLanes* __restrict moments)
{
    for (int e = 0; e < count; ++e) {
        tensions[e] = dot(directions[e], v[ends[2 * e + 1]] - v[ends[2 * e]]);
        moments[e] = bend_weights[e] * (bends[sides[2 * e]] + bends[sides[2 * e + 1]]);
    }
}

/// The transposes of bend_faces() and couple_edges().
SHAPE_VECTORISED void lift_corners(int moving, const int* face_edges,
                                   const HingeSlopes<EightLanes>* hinges, const EightLanes* moments,
                                   EightLanes* __restrict lifts)
{
    for (int f = 0; f < moving; ++f) {
        const HingeSlopes<EightLanes>* const hinge = hinges + 3 * f;
        const EightLanes& u = moments[face_edges[3 * f]];
        const EightLanes& v = moments[face_edges[3 * f + 1]];
        const EightLanes& w = moments[face_edges[3 * f + 2]];
        const EightLanes ab = hinge[0].height * u, bc = hinge[1].height * v,
                         ca = hinge[2].height * w;
        const EightLanes b = hinge[0].foot * u, c = hinge[1].foot * v, a = hinge[2].foot * w;
        lifts[3 * f] = ab - b + a - bc;
        lifts[3 * f + 1] = bc - c + b - ca;
        lifts[3 * f + 2] = ca - a + c - ab;
    }
}

SHAPE_VECTORISED void gather(int moving, const int* halfedge_begins, const int* halfedges,
                             const int* edge_begins, const int* edges,
                             const EightLanePoint* normals, const EightLanes* lifts,
                             const EightLanePoint* directions, const EightLanes* tensions,
                             EightLanePoint* __restrict forces)
{
    for (int v = 0; v < moving; ++v) {
        EightLanePoint sum{};
        for (int i = halfedge_begins[v]; i < halfedge_begins[v + 1]; ++i)
            sum = sum + lifts[halfedges[i]] * normals[halfedges[i] / 3];
        for (int i = edge_begins[v]; i < edge_begins[v + 1]; ++i) {
            const int e = edges[i] < 0 ? ~edges[i] : edges[i];
            const float sign = edges[i] < 0 ? -1.0F : 1.0F;
            sum = sum + (sign * tensions[e]) * directions[e];
        }
        forces[v] = sum;
    }
}

} // namespace

EightLaneEnergy::EightLaneEnergy(const LengthDihedralEnergy& energy, const RegionMesh& region)
    : region_(region),
      unit_(energy.target().edge_lengths(region.edges).mean()),
      normals_(to_size(region.face_count())),
      hinges_(3 * to_size(region.moving_faces)),
      directions_(region.edges.size()),
      strains_(region.edges.size()),
      bends_(region.edges.size()),
      energies_(region.edges.size()),
      tensions_(region.edges.size()),
      moments_(region.edges.size()),
      halfedge_terms_(region.corners.size())
{
    for (const int e : region.edges) {
        inverse_lengths_.push_back(static_cast<float>(unit_ / energy.target().edge_lengths[e]));
        sines_.push_back(static_cast<float>(energy.sines()[e]));
        cosines_.push_back(static_cast<float>(energy.cosines()[e]));
        bend_weights_.push_back(static_cast<float>(energy.bend_weights()[e]));
    }
}

std::array<float, EightLanes::lanes> EightLaneEnergy::linearise(const EightLanePoints& points)
{
    const RegionMesh& r = region_;
    EightLanes total;
    face_terms(r.face_count(), r.moving_faces, r.corners.data(), points.data(), normals_.data(),
               hinges_.data());
    edge_terms(r.edge_count(), r.ends.data(), r.sides.data(), points.data(), normals_.data(),
               inverse_lengths_.data(), sines_.data(), cosines_.data(), directions_.data(),
               strains_.data(), tensions_.data(), moments_.data(), energies_.data());
    vector_angles(tensions_.data()->of, moments_.data()->of, EightLanes::lanes * bends_.size(),
                  bends_.data()->of);
    bend_terms(r.edge_count(), bend_weights_.data(), bends_.data(), energies_.data(), &total);
    return std::to_array(total.of);
}

void EightLaneEnergy::transpose(const std::vector<EightLanes>& tensions,
                                const std::vector<EightLanes>& moments, EightLanePoints& forces)
{
    const RegionMesh& r = region_;
    forces.resize(to_size(r.moving_vertices));
    lift_corners(r.moving_faces, r.face_edges.data(), hinges_.data(), moments.data(),
                 halfedge_terms_.data());
    gather(r.moving_vertices, r.halfedge_begins.data(), r.halfedges.data(), r.edge_begins.data(),
           r.incident_edges.data(), normals_.data(), halfedge_terms_.data(), directions_.data(),
           tensions.data(), forces.data());
}

void EightLaneEnergy::gradient(EightLanePoints& forces)
{
    transpose(strains_, bends_, forces);
}

void EightLaneEnergy::apply(const EightLanePoints& v, EightLanePoints& product)
{
    const RegionMesh& r = region_;
    bend_faces(r.moving_faces, r.corners.data(), v.data(), normals_.data(), hinges_.data(),
               halfedge_terms_.data());
    couple_edges(r.edge_count(), r.ends.data(), r.sides.data(), bend_weights_.data(), v.data(),
                 directions_.data(), halfedge_terms_.data(), tensions_.data(), moments_.data());
    transpose(tensions_, moments_, product);
}

} // namespace shape::internal
