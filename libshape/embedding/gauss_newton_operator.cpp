// SPDX-License-Identifier: MIT

#include "libshape/embedding/gauss_newton_operator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "libshape/base/threads.h"
#include "libshape/base/vectorised.h"

namespace shape {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t grain = 4096;

using Order = int __attribute__((vector_size(16)));

/// The sum of a, in all lanes.
[[gnu::always_inline]] inline Lanes sum(const Lanes& a)
{
    const Lanes two = a + __builtin_shuffle(a, Order{1, 0, 3, 2});
    return two + __builtin_shuffle(two, Order{2, 3, 0, 1});
}

/// The sums of a, b and c.
[[gnu::always_inline]] inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c)
{
    const Lanes zero{};
    const Lanes ab = __builtin_shuffle(a, b, Order{0, 4, 1, 5});    // a0 b0 a1 b1
    const Lanes c0 = __builtin_shuffle(c, zero, Order{0, 4, 1, 5}); // c0 0 c1 0
    const Lanes last = __builtin_shuffle(__builtin_shuffle(a, b, Order{2, 6, 2, 6}), c,
                                         Order{0, 1, 6, 7}); // a2 b2 c2 c3
    return __builtin_shuffle(ab, c0, Order{0, 1, 4, 5}) +
           __builtin_shuffle(ab, c0, Order{2, 3, 6, 7}) + last;
}

inline Lanes lanes_of(const Vector3d& v)
{
    return Lanes{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
                 0.0F};
}

/// What belongs to the next corner or edge of a face, and to the one after that.
[[gnu::always_inline]] inline Lanes next(const Lanes& a)
{
    return __builtin_shuffle(a, Order{1, 2, 0, 3});
}
[[gnu::always_inline]] inline Lanes last(const Lanes& a)
{
    return __builtin_shuffle(a, Order{2, 0, 1, 3});
}

/// How faces turn about their three edges, times the lengths of these, as vertices move. With q = n . v,
/// edge i-j and opposite corner m: cot_j (q_i - q_m) + cot_i (q_j - q_m).
SHAPE_VECTORISED void bend_faces(std::size_t begin, std::size_t end, const int* faces,
                                 const Lanes* normals, const Lanes* cotangents, const Lanes* motion,
                                 Lanes* bends)
{
    for (std::size_t f = begin; f < end; ++f) {
        const int* const corner = faces + 3 * f;
        const Lanes& n = normals[f];
        const Lanes& cot = cotangents[f];
        const Lanes q = sums(n * motion[corner[0]], n * motion[corner[1]], n * motion[corner[2]]);
        bends[f] = next(cot) * (q - last(q)) + cot * (next(q) - last(q));
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
                                      const Lanes* directions, const Lanes* motion, Lanes* forces)
{
    double square = 0.0;
    for (std::size_t first = begin; first < end; first += short_sum) {
        Lanes products{};
        for (std::size_t v = first; v < std::min(first + short_sum, end); ++v) {
            const Lanes here = motion[v];
            const Lanes force = force_at(topology.spokes(static_cast<int>(v)), here, normals, lifts,
                                         directions, motion);
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
    const auto point = [&](int v) -> Vector3d { return points.segment<3>(3 * v); };
    const VectorXd& wanted = energy_.target().edge_lengths;
    Lanes* const normals = shape::lanes(normals_);
    Lanes* const directions = shape::lanes(directions_);
    parallel_for(static_cast<std::size_t>(t.edge_count()), grain,
                 [&](std::size_t begin, std::size_t end) {
                     for (auto e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
                         const Vector3d along = point(t.edges()(e, 1)) - point(t.edges()(e, 0));
                         const double length = along.norm();
                         const double weight = stretch_term(length / wanted[e] - 1.0).weight;
                         const double scale =
                             length > 0.0 ? std::sqrt(weight) * unit_ / (length * wanted[e]) : 0.0;
                         directions[e] = lanes_of(scale * along);
                     }
                 });
    const double scale = energy_.smoothness() * unit_ * unit_;
    Lanes* const cotangents = shape::lanes(cotangents_);
    Lanes* const stiffness = shape::lanes(stiffness_);
    parallel_for(
        static_cast<std::size_t>(t.face_count()), grain, [&](std::size_t begin, std::size_t end) {
            for (auto f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                const Vector3d p = point(t.faces()(f, 0));
                const Vector3d q = point(t.faces()(f, 1));
                const Vector3d r = point(t.faces()(f, 2));
                const Vector3d a = q - p, b = r - q, c = p - r;
                const Vector3d normal = b.cross(c);
                const double area2 = normal.norm();
                const double inverse = area2 > 0.0 ? 1.0 / area2 : 0.0;
                normals[f] = lanes_of(inverse * normal);
                cotangents[f] = lanes_of(-inverse * Vector3d(c.dot(a), a.dot(b), b.dot(c)));
                const auto stiff = [&](int e, double square) {
                    return square > 0.0 && !t.is_boundary_edge(t.face_edges()(f, e))
                               ? scale / square
                               : 0.0;
                };
                stiffness[f] = lanes_of({stiff(0, a.squaredNorm()), stiff(1, b.squaredNorm()),
                                         stiff(2, c.squaredNorm())});
            }
        });
}

double GaussNewtonOperator::apply(const LaneVectors& v, LaneVectors& product)
{
    const Topology& t = energy_.topology();
    product.resize(4, v.cols());
    const int* const faces = t.faces().data();
    const Lanes* const motion = shape::lanes(v);
    const Lanes* const normals = shape::lanes(normals_);
    const auto face_count = static_cast<std::size_t>(t.face_count());
    parallel_for(face_count, grain, [&](std::size_t begin, std::size_t end) {
        bend_faces(begin, end, faces, normals, shape::lanes(cotangents_), motion,
                   shape::lanes(bends_));
    });
    parallel_for(face_count, grain, [&](std::size_t begin, std::size_t end) {
        lift_faces(begin, end, t.opposites().data(), shape::lanes(stiffness_),
                   shape::lanes(cotangents_), shape::lanes(bends_), shape::lanes(lifts_));
    });
    return parallel_sum(static_cast<std::size_t>(t.vertex_count()), grain / 2,
                        [&](std::size_t begin, std::size_t end) {
                            return gather_forces(begin, end, t, normals, shape::lanes(lifts_),
                                                 shape::lanes(directions_), motion,
                                                 shape::lanes(product));
                        });
}

} // namespace shape
