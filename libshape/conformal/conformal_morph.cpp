// SPDX-License-Identifier: MIT

#include "libshape/conformal/conformal_morph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// What repaired faces keep of the triangle inequality, a <= (1 - margin) (b + c): their heights are then
/// 1e-3 of their sides, so that dihedral angles have digits, and lengths change by 1e-6 at most for it.
constexpr double margin = 1e-6;

/// Bending angles on the sphere; differences keep what points of tiny faces lose to rounding.
Eigen::VectorXd sphere_dihedral_angles(const Topology& topology, const SpherePoints& sphere)
{
    Eigen::VectorXd angles(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int h = topology.edge_halfedges()(e, 0);
        const int o = topology.edge_halfedges()(e, 1);
        const int a = topology.source(h);
        const auto seen = [&](int v) -> Eigen::Vector3d {
            return sphere.difference(a, v).transpose();
        };
        // Scaled to the edge: the areas of the smallest faces would underflow a tolerance.
        const double scale = 1.0 / seen(topology.target(h)).norm();
        angles[e] = dihedral_angle(Eigen::Vector3d::Zero(), scale * seen(topology.target(h)),
                                   scale * seen(topology.source(Topology::previous(h))),
                                   scale * seen(topology.source(Topology::previous(o))));
    }
    return angles;
}

/// One inequality in x = l / l*: x[longest] <= sum_k share[k] x[other[k]].
struct Constraint
{
    int face;
    int longest;
    std::array<int, 2> others;
    std::array<double, 2> shares; ///< (1 - margin) times the ratio of the lengths l*.
    double multiplier = 0.0;

    [[nodiscard]] double violation(const Eigen::VectorXd& x) const
    {
        return x[longest] - shares[0] * x[others[0]] - shares[1] * x[others[1]];
    }
};

/// Projects x, relative lengths of about 1, onto the inequalities with Hildreth's method: one at a
/// time, until a sweep moves none by more than 1e-14, some units of the last place. There is always a
/// solution (all lengths alike), but no bound on how fast it is approached: the limit of sweeps only
/// makes sure of an end.
void project(Eigen::VectorXd& x, std::vector<Constraint>& constraints)
{
    for (int sweep = 0; sweep < 100000; ++sweep) {
        double worst = 0.0;
        for (Constraint& c : constraints) {
            const double norm = 1.0 + c.shares[0] * c.shares[0] + c.shares[1] * c.shares[1];
            const double step = std::max(c.violation(x) / norm, -c.multiplier);
            worst = std::max(worst, std::abs(step));
            c.multiplier += step;
            x[c.longest] -= step;
            x[c.others[0]] += step * c.shares[0];
            x[c.others[1]] += step * c.shares[1];
        }
        if (worst <= 1e-14)
            return;
    }
    throw NumericalError("the lengths of a morph frame cannot be repaired");
}

/// The inequalities that x breaks and that are not among those known.
std::vector<Constraint> find_broken(const Topology& topology, const Eigen::VectorXd& lengths,
                                    const Eigen::VectorXd& x, const std::vector<Constraint>& known)
{
    std::vector<Constraint> found;
    for (int f = 0; f < topology.face_count(); ++f)
        for (int c = 0; c < 3; ++c) {
            const int e = topology.face_edges()(f, c);
            const int a = topology.face_edges()(f, (c + 1) % 3);
            const int b = topology.face_edges()(f, (c + 2) % 3);
            const Constraint constraint{f,
                                        e,
                                        {a, b},
                                        {(1.0 - margin) * lengths[a] / lengths[e],
                                         (1.0 - margin) * lengths[b] / lengths[e]}};
            const bool is_known = std::any_of(known.begin(), known.end(), [&](const Constraint& k) {
                return k.face == f && k.longest == e;
            });
            // What the projection leaves, summed over the faces around, is far below 1e-12.
            if (constraint.violation(x) > 1e-12 && !is_known)
                found.push_back(constraint);
        }
    return found;
}

} // namespace

ConformalMorph make_conformal_morph(const Topology& topology, const Points& points,
                                    const SphereMap& map)
{
    if (map.factors.size() != topology.vertex_count() ||
        map.edges.residuals.size() != topology.edge_count())
        throw InvalidInput(join("map is that of a mesh with ", map.factors.size(),
                                " vertices, the topology has ", topology.vertex_count()));
    if (map.certificate == ConformalCertificate::Unsolved)
        throw InvalidInput("map is unsolved: there is no sphere to morph to");
    ConformalMorph morph{topology, edge_lengths(topology, points).array().log(),
                         Eigen::VectorXd(topology.edge_count()),
                         RowMatrix(2, topology.edge_count())};
    for (int e = 0; e < topology.edge_count(); ++e)
        morph.log_ratios[e] =
            0.5 * (map.factors[topology.edges()(e, 0)] + map.factors[topology.edges()(e, 1)]);
    for (const int e : map.edges.flipped)
        morph.log_ratios[e] += map.edges.residuals[e];
    morph.dihedral_angles.row(0) = dihedral_angles(topology, points).transpose();
    morph.dihedral_angles.row(1) = sphere_dihedral_angles(topology, map.sphere).transpose();
    morph.dihedral_angles = unify_branches(std::move(morph.dihedral_angles));
    return morph;
}

MorphFrame morph_frame(const ConformalMorph& morph, double k)
{
    if (!(k >= 0.0 && k <= 1.0))
        throw InvalidInput(join("k is ", k, ", must be in [0, 1]"));
    const Eigen::VectorXd lengths = (morph.log_lengths + k * morph.log_ratios).array().exp();
    Eigen::VectorXd x = Eigen::VectorXd::Ones(lengths.size());
    std::vector<Constraint> constraints = find_broken(morph.topology, lengths, x, {});
    MorphFrame frame;
    for (const Constraint& c : constraints)
        frame.corrected_faces.push_back(c.face);
    for (std::vector<Constraint> more = constraints; !more.empty();) {
        project(x, constraints);
        more = find_broken(morph.topology, lengths, x, constraints);
        constraints.insert(constraints.end(), more.begin(), more.end());
    }
    frame.largest_correction = (x.array() - 1.0).abs().maxCoeff();
    frame.point.edge_lengths = lengths.cwiseProduct(x);
    frame.point.dihedral_angles =
        ((1.0 - k) * morph.dihedral_angles.row(0) + k * morph.dihedral_angles.row(1)).transpose();
    return frame;
}

double morph_parameter(double s)
{
    return std::sin(0.5 * std::numbers::pi * s);
}

double inverse_morph_parameter(double k)
{
    return 2.0 / std::numbers::pi * std::asin(k);
}

} // namespace shape
