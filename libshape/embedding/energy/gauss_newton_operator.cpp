// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/gauss_newton_operator.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "libshape/base/blocks.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/hinge.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

// The product J^T J v, three loops over the mesh. With q = n . v at the corners of a face:
//
//     faces     bend about each edge, times its length, from q and cotangents            bend_faces()
//     faces     moment = mu / l^2 (own bend + the neighbour's);  how it lifts corners    lift_faces()
//     vertices  sum over edges d (d . (v - v'))  +  sum over faces lift n                gather_forces()
//
// where d is the direction of an edge weighted by phi' (stretch_term.h). In memory every vector, and every
// three numbers of a face (one a corner or edge), fill a register of four floats:
//
//     motion        x y z 0  of vertex 0,   x y z 0  of vertex 1,  ...
//     cotangents    c0 c1 c2 0  of face 0,  c0 c1 c2 0  of face 1, ...    next() is c1 c2 c0, last() c2 c0 c1
//
// It is not the plain loop over edges, which would read the same four vertices again for every hinge and
// add to them, twelve numbers an edge, where the three numbers a face carry all bending, and loops that
// gather, each into what is its own, may be shared among threads with the same bits. Nor are
// eight numbers kept side by side as in eight_lane_energy.cpp: a mesh's faces do not lie in rows, and a
// gather of eight costs more than a register of which a quarter is idle.

/// Faces of a chunk of work: so much that handing it to a thread costs little beside it.
constexpr std::size_t grain = 1024;

/// The sum of a, in all lanes.
[[gnu::always_inline]] inline Lanes sum(const Lanes& a)
{
    const Lanes two = a + __builtin_shufflevector(a, a, 1, 0, 3, 2);
    return two + __builtin_shufflevector(two, two, 2, 3, 0, 1);
}

/// The sums of a, b and c.
[[gnu::always_inline]] inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c)
{
    const Lanes zero{};
    const Lanes ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);    // a0 b0 a1 b1
    const Lanes c0 = __builtin_shufflevector(c, zero, 0, 4, 1, 5); // c0 0 c1 0
    const Lanes last =
        __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 6, 2, 6), c, 0, 1, 6,
                                7); // a2 b2 c2 c3
    return __builtin_shufflevector(ab, c0, 0, 1, 4, 5) +
           __builtin_shufflevector(ab, c0, 2, 3, 6, 7) + last;
}

inline Lanes lanes_of(double scale, double x, double y, double z)
{
    return Lanes{static_cast<float>(scale * x), static_cast<float>(scale * y),
                 static_cast<float>(scale * z), 0.0F};
}

/// What makes the vectors along edges directions_.
SHAPE_VECTORISED void edge_scales(int count, double unit, double stiffness, const double* lengths,
                                  const double* wanted, double* __restrict scales)
{
    for (int i = 0; i < count; ++i) {
        const double weight = stretch_term(stiffness * (lengths[i] / wanted[i] - 1.0)).weight;
        scales[i] = lengths[i] > 0.0 ? std::sqrt(weight) * unit / (lengths[i] * wanted[i]) : 0.0;
    }
}

/// Cotangents of the angles at the corners of faces, and stiffness of the edges 0-1, 1-2, 2-0.
/// @param squares  Of the lengths of these.
/// @param weights  mu of these.
/// @param inverse_areas  1 / twice the areas; 0 where there is none.
SHAPE_VECTORISED void face_shapes(int count, const double* inverse_squares, const Row* squares,
                                  const Row* weights, double* __restrict inverse_areas,
                                  Row* __restrict cotangents, Row* __restrict stiffness)
{
    for (int i = 0; i < count; ++i) {
        const double a = squares[0][i], b = squares[1][i], c = squares[2][i];
        const double inverse = std::sqrt(inverse_squares[i]);
        inverse_areas[i] = inverse;
        cotangents[0][i] = 0.5 * (a + c - b) * inverse;
        cotangents[1][i] = 0.5 * (a + b - c) * inverse;
        cotangents[2][i] = 0.5 * (b + c - a) * inverse;
        stiffness[0][i] = a > 0.0 ? weights[0][i] / a : 0.0;
        stiffness[1][i] = b > 0.0 ? weights[1][i] / b : 0.0;
        stiffness[2][i] = c > 0.0 ? weights[2][i] / c : 0.0;
    }
}

/// What belongs to the next corner or edge of a face, and to the one after that.
[[gnu::always_inline]] inline Lanes next(const Lanes& a)
{
    return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline Lanes last(const Lanes& a)
{
    return __builtin_shufflevector(a, a, 2, 0, 1, 3);
}

/// How faces turn about their three edges, times the lengths of these, as vertices move; q = n . v.
SHAPE_VECTORISED void bend_faces(std::size_t begin, std::size_t end, const int* faces,
                                 const Lanes* normals, const Lanes* cotangents, const Lanes* motion,
                                 Lanes* bends)
{
    for (std::size_t f = begin; f < end; ++f) {
        const int* const corner = faces + 3 * f;
        const Lanes& n = normals[f];
        const Lanes& cot = cotangents[f];
        const Lanes q = sums(n * motion[corner[0]], n * motion[corner[1]], n * motion[corner[2]]);
        bends[f] = bend_by_cotangents(cot, next(cot), q, next(q), last(q));
    }
}

/// Moments about the edges of faces, and how they lift the corners: bend_faces() transposed.
SHAPE_VECTORISED void lift_faces(std::size_t begin, std::size_t end, const int* opposites,
                                 const Lanes* stiffness, const Lanes* cotangents,
                                 const Lanes* bends, Lanes* lifts)
{
    const auto* const of_halfedges = reinterpret_cast<const float*>(bends); // 4 f + corner
    const auto bend = [&](int h) __attribute__((always_inline))
    {
        h = h < 0 ? 0 : h; // the boundary has no stiffness
        return of_halfedges[h + h / 3];
    };
    for (std::size_t f = begin; f < end; ++f) {
        const int* const h = opposites + 3 * f;
        const Lanes moment =
            stiffness[f] * (bends[f] + Lanes{bend(h[0]), bend(h[1]), bend(h[2]), 0.0F});
        const Lanes here = next(cotangents[f]) * moment;
        const Lanes there = cotangents[f] * moment;
        lifts[f] = here + last(there) - next(here + there);
    }
}

/// What lifted corners and stretched edges do to a vertex.
[[gnu::always_inline]] inline Lanes force_at(std::span<const Topology::Spoke> spokes,
                                             const Lanes& here, const Lanes* normals,
                                             const Lanes* lifts, const Lanes* directions,
                                             const Lanes* motion)
{
    const auto* const of_corners = reinterpret_cast<const float*>(lifts); // 4 f + corner
    Lanes bending{};
    Lanes stretching{};
    const auto stretch = [&](const Topology::Spoke& spoke) __attribute__((always_inline))
    {
        const Lanes& d = directions[spoke.edge];
        stretching += sum(d * (here - motion[spoke.vertex])) * d;
    };
    if (spokes.back().halfedge < 0) { // on the boundary
        stretch(spokes.back());
        spokes = spokes.first(spokes.size() - 1);
    }
    for (const Topology::Spoke& spoke : spokes) {
        const auto h = static_cast<unsigned>(spoke.halfedge);
        bending += of_corners[h + h / 3] * normals[h / 3];
        stretch(spoke);
    }
    return bending + stretching;
}

/// Forces at vertices.
/// @return The sum of force . motion.
SHAPE_VECTORISED double gather_forces(std::size_t begin, std::size_t end, const Topology& topology,
                                      const Lanes* normals, const Lanes* lifts,
                                      const Lanes* directions, const float* holds,
                                      const Lanes* motion, Lanes* forces)
{
    double square = 0.0;
    for (std::size_t first = begin; first < end; first += short_sum) {
        Lanes products{};
        for (std::size_t v = first; v < std::min(first + short_sum, end); ++v) {
            const Lanes here = motion[v];
            Lanes force = force_at(topology.spokes(static_cast<int>(v)), here, normals, lifts,
                                   directions, motion);
            if (holds != nullptr)
                force += holds[v] * here;
            forces[v] = force;
            products += here * force;
        }
        square += lane_sum(products);
    }
    return square;
}

} // namespace

GaussNewtonOperator::GaussNewtonOperator(const LengthDihedralEnergy& energy)
    : energy_(energy),
      unit_(energy.target().edge_lengths.mean()),
      normals_(4, energy.topology().face_count()),
      directions_(4, energy.topology().edge_count()),
      cotangents_(4, energy.topology().face_count()),
      stiffness_(4, energy.topology().face_count()),
      bends_(4, energy.topology().face_count()),
      lifts_(4, energy.topology().face_count())
{
}

void GaussNewtonOperator::linearise(const VectorXd& points)
{
    const Topology& t = energy_.topology();
    const VectorXd& lengths = energy_.lengths();
    if (lengths.size() != t.edge_count() || points.size() != 3 * t.vertex_count())
        throw InvalidInput(join("linearise: there are ", points.size(), " coordinates and ",
                                lengths.size(), " evaluated edges, the topology has ",
                                t.vertex_count(), " vertices and ", t.edge_count(), " edges"));
    Lanes* const directions = internal::lanes(directions_);
    for_blocks(t.edge_count(), [&](int first, int count) {
        Row scales{};
        edge_scales(count, unit_, energy_.stiffness(), lengths.data() + first,
                    energy_.target().edge_lengths.data() + first, scales);
        for (int i = 0; i < count; ++i) {
            const double* const from = points.data() + 3 * t.edges()(first + i, 0);
            const double* const to = points.data() + 3 * t.edges()(first + i, 1);
            directions[first + i] =
                lanes_of(scales[i], to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        }
    });
    collapses_ = energy_.collapses();
    holds_ = (unit_ * unit_ * energy_.hold_weights()).cast<float>();
    sums_.clear();
    for (const LengthDihedralEnergy::AngleSum& sum : energy_.held_sums())
        sums_.push_back(slopes_of(sum));
    for (const LengthDihedralEnergy::Gap& gap : energy_.gaps()) {
        if (!(LengthDihedralEnergy::lack(gap, points) > 0.0))
            continue;
        SumSlopes& slopes = sums_.emplace_back();
        slopes.vertices = gap.vertices;
        for (const double factor : gap.factors)
            slopes.slopes.emplace_back(
                (std::sqrt(gap.stiffness) * unit_ * factor * gap.direction).cast<float>());
    }
    Lanes* const normals = internal::lanes(normals_);
    Lanes* const cotangents = internal::lanes(cotangents_);
    Lanes* const stiffness = internal::lanes(stiffness_);
    const double scale = unit_ * unit_;
    const double* const bend_weights = energy_.bend_weights().data();
    for_blocks(t.face_count(), [&](int first, int count) {
        Row squares[3]{};
        Row weights[3]{};
        Row inverse_areas{};
        Row cot[3]{};
        Row stiff[3]{};
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < 3; ++k) {
                const int e = t.face_edges()(first + i, k);
                squares[k][i] = lengths[e] * lengths[e];
                weights[k][i] = scale * bend_weights[e];
            }
        face_shapes(count, energy_.inverse_squares().data() + first, squares, weights,
                    inverse_areas, cot, stiff);
        for (int i = 0; i < count; ++i) {
            const int f = first + i;
            const double* const n = energy_.normals().data() + 3 * f;
            normals[f] = lanes_of(inverse_areas[i], n[0], n[1], n[2]);
            cotangents[f] = lanes_of(1.0, cot[0][i], cot[1][i], cot[2][i]);
            stiffness[f] = lanes_of(1.0, stiff[0][i], stiff[1][i], stiff[2][i]);
        }
    });
}

GaussNewtonOperator::SumSlopes GaussNewtonOperator::slopes_of(
    const LengthDihedralEnergy::AngleSum& sum) const
{
    const Topology& t = energy_.topology();
    const VectorXd& lengths = energy_.lengths();
    SumSlopes result;
    for (std::size_t i = 0; i < sum.edges.size(); ++i)
        for (const int h :
             {t.edge_halfedges()(sum.edges[i], 0), t.edge_halfedges()(sum.edges[i], 1)}) {
            const int before = Topology::previous(h);
            const double length = lengths[sum.edges[i]];
            const double at_a = lengths[t.face_edges()(before / 3, before % 3)];
            const int after = Topology::next(h);
            const double at_b = lengths[t.face_edges()(after / 3, after % 3)];
            const auto shares =
                hinge_shares(length, foot_of(length, length * length, at_a * at_a, at_b * at_b));
            const Eigen::Vector3f normal =
                (std::sqrt(sum.stiffness) * unit_ * sum.factors[i] *
                 energy_.inverse_squares()[h / 3] * energy_.normals().row(h / 3))
                    .cast<float>();
            const auto add = [&](int vertex, double share) {
                result.vertices.push_back(vertex);
                result.slopes.emplace_back(static_cast<float>(share) * normal);
            };
            add(t.source(h), shares.a);
            add(t.target(h), shares.b);
            add(t.source(before), shares.c);
        }
    return result;
}

double GaussNewtonOperator::apply(const LaneVectors& v, LaneVectors& product)
{
    const Topology& t = energy_.topology();
    product.resize(4, v.cols());
    const int* const faces = t.faces().data();
    const Lanes* const motion = internal::lanes(v);
    const Lanes* const normals = internal::lanes(normals_);
    const auto face_count = to_size(t.face_count());
    parallel_for(face_count, grain, [&](std::size_t begin, std::size_t end) {
        bend_faces(begin, end, faces, normals, internal::lanes(cotangents_), motion,
                   internal::lanes(bends_));
    });
    parallel_for(face_count, grain, [&](std::size_t begin, std::size_t end) {
        lift_faces(begin, end, t.opposites().data(), internal::lanes(stiffness_),
                   internal::lanes(cotangents_), internal::lanes(bends_), internal::lanes(lifts_));
    });
    double square =
        parallel_sum(to_size(t.vertex_count()), grain / 2, [&](std::size_t begin, std::size_t end) {
            const float* const holds = holds_.size() > 0 ? holds_.data() : nullptr;
            return gather_forces(begin, end, t, normals, internal::lanes(lifts_),
                                 internal::lanes(directions_), holds, motion,
                                 internal::lanes(product));
        });
    for (const auto& [face, residual, gradients] : collapses_) {
        double change = 0.0;
        for (int k = 0; k < 3; ++k)
            change += unit_ *
                      gradients[to_size(k)].dot(v.col(t.faces()(face, k)).head<3>().cast<double>());
        for (int k = 0; k < 3; ++k)
            product.col(t.faces()(face, k)).head<3>() +=
                (unit_ * change * gradients[to_size(k)]).cast<float>();
        square += change * change;
    }
    for (const auto& [vertices, slopes] : sums_) {
        double change = 0.0;
        for (std::size_t i = 0; i < vertices.size(); ++i)
            change += static_cast<double>(slopes[i].dot(v.col(vertices[i]).head<3>()));
        for (std::size_t i = 0; i < vertices.size(); ++i)
            product.col(vertices[i]).head<3>() += static_cast<float>(change) * slopes[i];
        square += change * change;
    }
    return square;
}

} // namespace shape::internal
