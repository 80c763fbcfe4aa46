// SPDX-License-Identifier: MIT

#include "libshape/conformal/angle_defect_energy.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using std::numbers::pi;
constexpr double two_pi_remainder = 2.4492935982947064e-16; // 2 pi minus 2.0 * pi

/// zeta(2), zeta(4), ..., zeta(36).
constexpr std::array<double, 18> even_zeta{
    1.6449340668482264365, 1.0823232337111381915, 1.0173430619844491397, 1.0040773561979443394,
    1.0009945751278180853, 1.0002460865533080483, 1.0000612481350587048, 1.0000152822594086519,
    1.0000038172932649998, 1.0000009539620338728, 1.0000002384505027277, 1.0000000596081890513,
    1.0000000149015548284, 1.0000000037253340248, 1.0000000009313274324, 1.0000000002328311834,
    1.0000000000582077209, 1.0000000000145519219};

/// Clausen's integral Cl2 on [0, pi], by its power series about 0 and about pi.
double clausen(double x)
{
    if (x == 0.0)
        return 0.0;
    const double y = pi - x;
    const bool near_zero = x <= 2.0 * pi / 3.0;
    const double ratio = near_zero ? x * x / (4.0 * pi * pi) : y * y / (pi * pi);
    double power = 1.0;
    double quarter_power = 1.0;
    double sum = 0.0;
    for (std::size_t k = 1; k <= even_zeta.size(); ++k) {
        power *= ratio;
        quarter_power *= 0.25;
        const double term = even_zeta[k - 1] * power / static_cast<double>(k * (2 * k + 1));
        sum += near_zero ? term : -(1.0 - quarter_power) * term;
    }
    return near_zero ? x * (1.0 - std::log(x) + sum) : y * (std::numbers::ln2 + sum);
}

/// Instead of the 0 of a broken face: without curvature steps would run wild (1000 and more instead
/// of 15 from lengths that break most faces). About a third of that of an equilateral face.
constexpr double broken_weight = 0.1;

bool has_vertex(const IntrinsicTriangulation& t, int face, int vertex)
{
    return t.source(3 * face) == vertex || t.source(3 * face + 1) == vertex ||
           t.source(3 * face + 2) == vertex;
}

} // namespace

double lobachevsky(double x)
{
    // L(x) = Cl2(2 x) / 2, reduced to 2 x in [-pi, pi].
    const double reduced = 2.0 * std::remainder(x, pi);
    return std::copysign(0.5 * clausen(std::abs(reduced)), reduced);
}

TriangleAngles triangle_angles(const std::array<double, 3>& log_lengths)
{
    const double longest = std::max({log_lengths[0], log_lengths[1], log_lengths[2]});
    std::array<double, 3> l{};
    for (std::size_t k = 0; k < 3; ++k)
        l[k] = std::exp(log_lengths[k] - longest);
    // t[k] = sum of the other sides minus side k; half-angle formula tan^2(a_k / 2) =
    // t_i t_j / (t_k (l_0 + l_1 + l_2)). The longest side is 1: subtracting it first is exact for
    // a second side of at least 1/2, so flat triangles lose nothing.
    std::array<double, 3> t{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double high = std::max(l[(k + 1) % 3], l[(k + 2) % 3]);
        const double low = std::min(l[(k + 1) % 3], l[(k + 2) % 3]);
        t[k] = (high - l[k]) + low;
    }
    TriangleAngles result;
    for (std::size_t k = 0; k < 3; ++k)
        if (t[k] <= 0.0) {
            result.angles[k] = pi;
            result.broken = true;
            return result;
        }
    const double perimeter = l[0] + l[1] + l[2];
    const double root = std::sqrt(t[0] * t[1] * t[2] * perimeter); // 4 times the area
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3;
        const std::size_t j = (k + 2) % 3;
        const double numerator = t[i] * t[j];
        result.angles[k] = 2.0 * std::atan2(numerator, root);
        // cot a = (1 - tan^2) / (2 tan) at the half angle.
        result.weights[k] = 0.25 * (t[k] * perimeter - numerator) / root;
    }
    return result;
}

std::array<double, 3> scaled_sides(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                                   int face)
{
    std::array<double, 3> sides{};
    for (int c = 0; c < 3; ++c) {
        const int h = 3 * face + c;
        sides[to_size(c)] = t.log_lengths()[t.edge(h)] + 0.5 * (u[t.source(h)] + u[t.target(h)]);
    }
    return sides;
}

double angle_defect_energy(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                           int removed_vertex)
{
    const auto face_count = to_size(t.face_count());
    const double of_faces = parallel_sum(face_count, 4096, [&](std::size_t begin, std::size_t end) {
        double sum = 0.0;
        for (auto f = static_cast<int>(begin); f < static_cast<int>(end); ++f) {
            if (has_vertex(t, f, removed_vertex))
                continue;
            const std::array<double, 3> x = scaled_sides(t, u, f);
            const std::array<double, 3> alpha = triangle_angles(x).angles;
            for (std::size_t k = 0; k < 3; ++k)
                sum += (2.0 * alpha[k] - pi) * x[k] + 2.0 * lobachevsky(alpha[k]);
        }
        return sum;
    });
    double of_vertices = 0.0;
    for (int v = 0; v < t.vertex_count(); ++v)
        if (v != removed_vertex)
            of_vertices += u[v];
    return of_faces + 2.0 * pi * of_vertices;
}

AngleDefects measure_angle_defects(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                                   int removed_vertex)
{
    std::vector<TriangleAngles> faces(to_size(t.face_count()));
    parallel_for(faces.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f)
            if (!has_vertex(t, static_cast<int>(f), removed_vertex))
                faces[f] = triangle_angles(scaled_sides(t, u, static_cast<int>(f)));
    });
    AngleDefects result{Eigen::VectorXd::Constant(t.vertex_count(), 2.0 * pi),
                        Eigen::VectorXd::Zero(t.edge_count()),
                        {}};
    for (int f = 0; f < t.face_count(); ++f) {
        const TriangleAngles& face = faces[to_size(f)];
        for (int c = 0; c < 3; ++c) {
            // The corner opposite half-edge c is the source of the one before it.
            const int h = 3 * f + c;
            result.defects[t.source(Topology::previous(h))] -= face.angles[to_size(c)];
            result.edge_weights[t.edge(h)] +=
                face.broken ? broken_weight : face.weights[to_size(c)];
        }
        if (face.broken)
            result.broken_faces.push_back(f);
    }
    // 2 pi is larger than the double: over many vertices that adds up to a cone.
    result.defects.array() += two_pi_remainder;
    if (removed_vertex >= 0)
        result.defects[removed_vertex] = 0.0;
    return result;
}

} // namespace shape::internal
