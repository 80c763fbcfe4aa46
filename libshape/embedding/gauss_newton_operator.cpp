// SPDX-License-Identifier: MIT

#include "libshape/embedding/gauss_newton_operator.h"

#include <Eigen/Geometry>
#include <cmath>

#include "libshape/base/threads.h"

namespace shape {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t grain = 4096;

inline float sum(const Lanes& a)
{
    return a[0] + a[1] + a[2];
}

/// The sums of a, b and c.
inline Lanes sums(const Lanes& a, const Lanes& b, const Lanes& c)
{
    using Order = int __attribute__((vector_size(16)));
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

inline const Lanes& lanes(const Eigen::Vector4f& v)
{
    return *reinterpret_cast<const Lanes*>(v.data());
}

} // namespace

GaussNewtonOperator::GaussNewtonOperator(const LengthDihedralEnergy& energy)
    : energy_(energy),
      unit_(energy.target().edge_lengths.mean()),
      normals_(4, energy.topology().face_count()),
      directions_(4, energy.topology().edge_count()),
      hinges_(static_cast<std::size_t>(energy.topology().face_count())),
      bends_(4, energy.topology().face_count()),
      moments_(energy.topology().edge_count()),
      tensions_(energy.topology().edge_count())
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
    // Over edge i-j with opposite corner m at height h: d theta / d x_m = -n / h, and i and j share
    // the opposite of it in proportion to where the foot of m lies.
    const double root = std::sqrt(energy_.smoothness());
    parallel_for(
        static_cast<std::size_t>(t.face_count()), grain, [&](std::size_t begin, std::size_t end) {
            for (auto f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
                const std::array<Vector3d, 3> corner = {
                    point(t.faces()(f, 0)), point(t.faces()(f, 1)), point(t.faces()(f, 2))};
                const Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
                const double area2 = normal.norm();
                auto& hinge = hinges_[static_cast<std::size_t>(f)];
                hinge.fill(Eigen::Vector4f::Zero());
                normals[f] = Lanes{};
                if (!(area2 > 0.0))
                    continue;
                normals[f] = lanes_of(normal / area2);
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::size_t j = (i + 1) % 3;
                    const std::size_t m = (i + 2) % 3;
                    const Vector3d side = corner[j] - corner[i];
                    const double foot = (corner[m] - corner[i]).dot(side) / side.squaredNorm();
                    const double inverse_height = root * unit_ * side.norm() / area2;
                    const auto edge = static_cast<Eigen::Index>(i);
                    hinge[i][edge] = static_cast<float>((1.0 - foot) * inverse_height);
                    hinge[j][edge] = static_cast<float>(foot * inverse_height);
                    hinge[m][edge] = static_cast<float>(-inverse_height);
                }
            }
        });
}

void GaussNewtonOperator::apply(const LaneVectors& v, LaneVectors& product)
{
    const Topology& t = energy_.topology();
    const int* const faces = t.faces().data();
    const int* const face_edges = t.face_edges().data();
    const int* const edges = t.edges().data();
    const Lanes* const motion = shape::lanes(v);
    const Lanes* const normals = shape::lanes(normals_);
    const Lanes* const directions = shape::lanes(directions_);
    Lanes* const bends = shape::lanes(bends_);
    product.resize(4, v.cols());
    Lanes* const forces = shape::lanes(product);

    parallel_for(
        static_cast<std::size_t>(t.face_count()), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const int* const corner = faces + 3 * f;
                const Lanes& n = normals[f];
                const Lanes rise =
                    sums(n * motion[corner[0]], n * motion[corner[1]], n * motion[corner[2]]);
                bends[f] = rise[0] * lanes(hinges_[f][0]) + rise[1] * lanes(hinges_[f][1]) +
                           rise[2] * lanes(hinges_[f][2]);
            }
        });
    parallel_for(static_cast<std::size_t>(t.edge_count()), grain,
                 [&](std::size_t begin, std::size_t end) {
                     const float* const of_halfedges = bends_.data(); // 4 f + corner
                     const auto bend = [&](int h) { return of_halfedges[h + h / 3]; };
                     for (auto e = static_cast<Eigen::Index>(begin);
                          e < static_cast<Eigen::Index>(end); ++e) {
                         tensions_[e] =
                             sum(directions[e] * (motion[edges[2 * e + 1]] - motion[edges[2 * e]]));
                         const int left = t.edge_halfedges()(e, 0);
                         const int right = t.edge_halfedges()(e, 1);
                         moments_[e] = right < 0 ? 0.0F : bend(left) + bend(right);
                     }
                 });
    parallel_for(
        static_cast<std::size_t>(t.face_count()), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const int* const e = face_edges + 3 * f;
                const Lanes moment{moments_[e[0]], moments_[e[1]], moments_[e[2]], 0.0F};
                bends[f] = sums(moment * lanes(hinges_[f][0]), moment * lanes(hinges_[f][1]),
                                moment * lanes(hinges_[f][2]));
            }
        });
    parallel_for(static_cast<std::size_t>(t.vertex_count()), grain / 2,
                 [&](std::size_t begin, std::size_t end) {
                     const float* const lifts = bends_.data();
                     for (auto v0 = static_cast<int>(begin); v0 < static_cast<int>(end); ++v0) {
                         Lanes bending{};
                         Lanes stretching{};
                         const auto pull = [&](int e) { // a branch would be a coin's toss
                             const auto sign = static_cast<float>(2 * (edges[2 * e + 1] == v0) - 1);
                             stretching += sign * tensions_[e] * directions[e];
                         };
                         const auto outgoing = t.outgoing(v0);
                         for (const int h : outgoing) {
                             bending += lifts[h + h / 3] * normals[h / 3];
                             pull(face_edges[h]);
                         }
                         if (t.is_boundary_vertex(v0)) // the other edge of the boundary comes in
                             pull(face_edges[Topology::previous(outgoing.back())]);
                         forces[v0] = bending + stretching;
                     }
                 });
}

} // namespace shape
