// SPDX-License-Identifier: MIT

#include "libshape/conformal/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/conformal/angle_defect_energy.h"

namespace shape {
namespace {

using Complex = std::complex<double>;

/// Angle of the disc at the source of a boundary half-edge: over the fan left of it.
double boundary_angle(const IntrinsicTriangulation& t, const Eigen::VectorXd& u, int halfedge,
                      int previous_halfedge)
{
    double angle = 0.0;
    for (int h = halfedge;;) {
        const int before = Topology::previous(h);
        const auto opposite_corner = static_cast<std::size_t>(Topology::next(h) % 3);
        angle += triangle_angles(scaled_sides(t, u, Topology::face(h))).angles[opposite_corner];
        if (before == previous_halfedge)
            return angle;
        h = t.opposite(before);
    }
}

void add(Complex& sum, Complex& remainder, Complex term)
{
    // Knuth's two-sum, in both coordinates.
    term += remainder;
    const Complex next = sum + term;
    const Complex virtual_term = next - sum;
    remainder = (sum - (next - virtual_term)) + (term - virtual_term);
    sum = next;
}

void place_boundary(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                    const std::vector<int>& boundary, PlanarLayout& layout)
{
    Complex place = 0.0;
    double direction = 0.0;
    for (std::size_t i = 0; i < boundary.size(); ++i) {
        const int h = boundary[i];
        if (i > 0)
            direction += std::numbers::pi - boundary_angle(t, u, h, boundary[i - 1]);
        layout.positions[t.source(h)] = place;
        place += std::polar(std::exp(t.scaled_log_length(t.edge(h), u)), direction);
    }
}

} // namespace

PlanarLayout lay_out_disc(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                          const std::vector<int>& boundary, const Eigen::VectorXd& edge_weights,
                          const CotangentSystem& system)
{
    const Eigen::Index vertex_count = t.vertex_count();
    PlanarLayout layout{Eigen::VectorXcd::Zero(vertex_count), Eigen::VectorXcd::Zero(vertex_count)};
    place_boundary(t, u, boundary, layout);

    // Iterative refinement. Differences along edges are accurate relative to the edge, so are the
    // residuals, and a few steps make the whole layout so.
    double change = std::numeric_limits<double>::infinity();
    for (int step = 0; step < 10; ++step) {
        Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(vertex_count, 2);
        for (int e = 0; e < t.edge_count(); ++e) {
            const int a = t.source(t.halfedge(e));
            const int b = t.target(t.halfedge(e));
            const Complex pull = edge_weights[e] * layout.difference(a, b);
            residual.row(a) += Eigen::RowVector2d(pull.real(), pull.imag());
            residual.row(b) -= Eigen::RowVector2d(pull.real(), pull.imag());
        }
        const Eigen::MatrixXd correction = system.solve(residual);
        double next_change = 0.0;
        for (int e = 0; e < t.edge_count(); ++e) {
            if (edge_weights[e] == 0.0)
                continue;
            const int a = t.source(t.halfedge(e));
            const int b = t.target(t.halfedge(e));
            next_change = std::max(next_change, (correction.row(b) - correction.row(a)).norm() /
                                                    std::exp(t.scaled_log_length(e, u)));
        }
        if(getenv("CONF_VERBOSE")) printf("  layout change %.3e\n", next_change);
        if (next_change > 0.5 * change && change < 1e-8)
            break;
        for (Eigen::Index v = 0; v < vertex_count; ++v)
            add(layout.positions[v], layout.remainders[v],
                Complex(correction(v, 0), correction(v, 1)));
        change = next_change;
        if (change < 1e-15)
            break;
    }
    return layout;
}

} // namespace shape
