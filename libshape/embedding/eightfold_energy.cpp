// SPDX-License-Identifier: MIT

#include "libshape/embedding/eightfold_energy.h"

#include <cmath>

#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"

namespace shape {
namespace {

constexpr float nothing = 1e-18F; // keeps 0 / 0 out: a length or area squared

/// Unit normals (0 without area); and of moving faces, for each edge i-j with opposite corner m at
/// height h over the foot: 1 / h, and that in proportion to where the foot lies from i to j.
SHAPE_VECTORISED void face_terms(int count, int moving, const int* corners,
                                 const EightfoldPoint* points, EightfoldPoint* __restrict normals,
                                 Eightfold* __restrict hinges)
{
    for (int f = 0; f < count; ++f) {
        const EightfoldPoint& a = points[corners[3 * f]];
        const EightfoldPoint& b = points[corners[3 * f + 1]];
        const EightfoldPoint& c = points[corners[3 * f + 2]];
        const EightfoldPoint ab = b - a, bc = c - b, ca = a - c;
        const EightfoldPoint normal = cross(ca, ab);
        const Eightfold square = dot(normal, normal);
        const Eightfold inverse = sqrt(square) / (square + Eightfold::all(nothing));
        normals[f] = inverse * normal;
        if (f >= moving)
            continue;
        const auto hinge = [&](int j, const EightfoldPoint& side, const EightfoldPoint& before) {
            const Eightfold length2 = dot(side, side) + Eightfold::all(nothing);
            const Eightfold inverse_height = sqrt(length2) * inverse;
            hinges[6 * f + 2 * j] = inverse_height;
            hinges[6 * f + 2 * j + 1] =
                inverse_height * (Eightfold::all(0.0F) - dot(side, before)) / length2;
        };
        hinge(0, ab, ca);
        hinge(1, bc, ab);
        hinge(2, ca, bc);
    }
}

/// Of every edge: the residual of its strain, how it changes, and a vector in the direction
/// theta - theta*; and phi(strain).
SHAPE_VECTORISED void edge_terms(int count, const int* ends, const int* sides,
                                 const EightfoldPoint* points, const EightfoldPoint* normals,
                                 const float* inverse_lengths, const float* sines,
                                 const float* cosines, EightfoldPoint* __restrict directions,
                                 Eightfold* __restrict strains, Eightfold* __restrict bend_sines,
                                 Eightfold* __restrict bend_cosines, Eightfold* __restrict energies)
{
    constexpr auto onset = static_cast<float>(stretch_onset * stretch_onset);
    for (int e = 0; e < count; ++e) {
        const EightfoldPoint along = points[ends[2 * e + 1]] - points[ends[2 * e]];
        const Eightfold length2 = dot(along, along);
        const Eightfold length = sqrt(length2);
        const Eightfold strain = inverse_lengths[e] * length - Eightfold::all(1.0F);
        const Eightfold square = strain * strain;
        const Eightfold scale = Eightfold::all(onset) + 0.125F * square;
        energies[e] = square + square * square / scale;
        const Eightfold weight =
            Eightfold::all(1.0F) +
            square * (Eightfold::all(2.0F * onset) + 0.125F * square) / (scale * scale);
        const Eightfold root = sqrt(weight);
        strains[e] = root * strain;
        directions[e] =
            (inverse_lengths[e] * root * length / (length2 + Eightfold::all(nothing))) * along;
        const EightfoldPoint& left = normals[sides[2 * e] / 3];
        const EightfoldPoint& right = normals[sides[2 * e + 1] / 3];
        const Eightfold s = dot(along, cross(left, right));
        const Eightfold c = length * dot(left, right);
        bend_sines[e] = cosines[e] * s - sines[e] * c;
        bend_cosines[e] = cosines[e] * c + sines[e] * s;
    }
}

/// Adds squares of bends, weighted, to the energies of edges, and sums those; weights the bends.
SHAPE_VECTORISED void bend_terms(int count, const float* weights, Eightfold* __restrict bends,
                                 Eightfold* __restrict energies, Eightfold* __restrict total)
{
    Eightfold sum{};
    for (int e = 0; e < count; ++e) {
        const Eightfold weighted = weights[e] * bends[e];
        energies[e] = energies[e] + weighted * bends[e];
        bends[e] = weighted;
        sum = sum + energies[e];
    }
    *total = sum;
}

/// How moving faces bend at their three edges.
SHAPE_VECTORISED void bend_faces(int moving, const int* corners, const EightfoldPoint* v,
                                 const EightfoldPoint* normals, const Eightfold* hinges,
                                 Eightfold* __restrict bends)
{
    for (int f = 0; f < moving; ++f) {
        const Eightfold a = dot(normals[f], v[corners[3 * f]]);
        const Eightfold b = dot(normals[f], v[corners[3 * f + 1]]);
        const Eightfold c = dot(normals[f], v[corners[3 * f + 2]]);
        const Eightfold* const hinge = hinges + 6 * f;
        bends[3 * f] = hinge[0] * (a - c) + hinge[1] * (b - a);
        bends[3 * f + 1] = hinge[2] * (b - a) + hinge[3] * (c - b);
        bends[3 * f + 2] = hinge[4] * (c - b) + hinge[5] * (a - c);
    }
}

SHAPE_VECTORISED void couple_edges(int count, const int* ends, const int* sides,
                                   const float* bend_weights, const EightfoldPoint* v,
                                   const EightfoldPoint* directions, const Eightfold* bends,
                                   Eightfold* __restrict tensions, Eightfold* __restrict moments)
{
    for (int e = 0; e < count; ++e) {
        tensions[e] = dot(directions[e], v[ends[2 * e + 1]] - v[ends[2 * e]]);
        moments[e] = bend_weights[e] * (bends[sides[2 * e]] + bends[sides[2 * e + 1]]);
    }
}

/// The transposes of bend_faces() and couple_edges().
SHAPE_VECTORISED void lift_corners(int moving, const int* face_edges, const Eightfold* hinges,
                                   const Eightfold* moments, Eightfold* __restrict lifts)
{
    for (int f = 0; f < moving; ++f) {
        const Eightfold* const hinge = hinges + 6 * f;
        const Eightfold& u = moments[face_edges[3 * f]];
        const Eightfold& v = moments[face_edges[3 * f + 1]];
        const Eightfold& w = moments[face_edges[3 * f + 2]];
        const Eightfold ab = hinge[0] * u, bc = hinge[2] * v, ca = hinge[4] * w;
        const Eightfold b = hinge[1] * u, c = hinge[3] * v, a = hinge[5] * w;
        lifts[3 * f] = ab - b + a - bc;
        lifts[3 * f + 1] = bc - c + b - ca;
        lifts[3 * f + 2] = ca - a + c - ab;
    }
}

SHAPE_VECTORISED void gather(int moving, const int* halfedge_begins, const int* halfedges,
                             const int* edge_begins, const int* edges,
                             const EightfoldPoint* normals, const Eightfold* lifts,
                             const EightfoldPoint* directions, const Eightfold* tensions,
                             EightfoldPoint* __restrict forces)
{
    for (int v = 0; v < moving; ++v) {
        EightfoldPoint sum{};
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

EightfoldEnergy::EightfoldEnergy(const LengthDihedralEnergy& energy, const RegionMesh& region)
    : region_(region),
      unit_(energy.target().edge_lengths(region.edges).mean()),
      normals_(static_cast<std::size_t>(region.face_count())),
      hinges_(6 * static_cast<std::size_t>(region.moving_faces)),
      directions_(region.edges.size()),
      strains_(region.edges.size()),
      bends_(region.edges.size()),
      energies_(region.edges.size()),
      tensions_(region.edges.size()),
      moments_(region.edges.size()),
      halfedge_terms_(region.corners.size())
{
    for (const int e : region.edges) {
        const bool inner = !energy.topology().is_boundary_edge(e);
        const double angle = inner ? energy.target().dihedral_angles[e] : 0.0;
        inverse_lengths_.push_back(static_cast<float>(unit_ / energy.target().edge_lengths[e]));
        sines_.push_back(static_cast<float>(std::sin(angle)));
        cosines_.push_back(static_cast<float>(std::cos(angle)));
        bend_weights_.push_back(static_cast<float>(energy.bend_weights()[e]));
    }
}

std::array<float, Eightfold::lanes> EightfoldEnergy::linearise(const EightfoldPoints& points)
{
    const RegionMesh& r = region_;
    Eightfold total;
    face_terms(r.face_count(), r.moving_faces, r.corners.data(), points.data(), normals_.data(),
               hinges_.data());
    edge_terms(r.edge_count(), r.ends.data(), r.sides.data(), points.data(), normals_.data(),
               inverse_lengths_.data(), sines_.data(), cosines_.data(), directions_.data(),
               strains_.data(), tensions_.data(), moments_.data(), energies_.data());
    vector_angles(tensions_.data()->of, moments_.data()->of, Eightfold::lanes * bends_.size(),
                  bends_.data()->of);
    bend_terms(r.edge_count(), bend_weights_.data(), bends_.data(), energies_.data(), &total);
    return std::to_array(total.of);
}

void EightfoldEnergy::transpose(const std::vector<Eightfold>& tensions,
                                const std::vector<Eightfold>& moments, EightfoldPoints& forces)
{
    const RegionMesh& r = region_;
    forces.resize(static_cast<std::size_t>(r.moving_vertices));
    lift_corners(r.moving_faces, r.face_edges.data(), hinges_.data(), moments.data(),
                 halfedge_terms_.data());
    gather(r.moving_vertices, r.halfedge_begins.data(), r.halfedges.data(), r.edge_begins.data(),
           r.incident_edges.data(), normals_.data(), halfedge_terms_.data(), directions_.data(),
           tensions.data(), forces.data());
}

void EightfoldEnergy::gradient(EightfoldPoints& forces)
{
    transpose(strains_, bends_, forces);
}

void EightfoldEnergy::apply(const EightfoldPoints& v, EightfoldPoints& product)
{
    const RegionMesh& r = region_;
    bend_faces(r.moving_faces, r.corners.data(), v.data(), normals_.data(), hinges_.data(),
               halfedge_terms_.data());
    couple_edges(r.edge_count(), r.ends.data(), r.sides.data(), bend_weights_.data(), v.data(),
                 directions_.data(), halfedge_terms_.data(), tensions_.data(), moments_.data());
    transpose(tensions_, moments_, product);
}

} // namespace shape
