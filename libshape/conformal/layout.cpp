// SPDX-License-Identifier: MIT

#include "libshape/conformal/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

#include "libshape/base/to_size.h"
#include "libshape/conformal/angle_defect_energy.h"

namespace shape::internal {
namespace {

using Complex = std::complex<double>;

/// Angle of the disc at the source of a boundary half-edge: over the fan left of it.
double boundary_angle(const IntrinsicTriangulation& t, const Eigen::VectorXd& u, int halfedge,
                      int previous_halfedge)
{
    double angle = 0.0;
    for (int h = halfedge;;) {
        const int before = Topology::previous(h);
        const auto opposite_corner = to_size(Topology::next(h) % 3);
        angle += triangle_angles(scaled_sides(t, u, Topology::face(h))).angles[opposite_corner];
        if (before == previous_halfedge)
            return angle;
        h = t.opposite(before);
    }
}

/// Adds to the position of a vertex by Knuth's two-sum, in both coordinates.
void add(PlanarLayout& layout, Eigen::Index vertex, Complex term)
{
    Complex& position = layout.positions[vertex];
    Complex& remainder = layout.remainders[vertex];
    const auto two_sum = [](Complex a, Complex b) {
        const Complex sum = a + b;
        const Complex virtual_b = sum - a;
        return std::pair(sum, (a - (sum - virtual_b)) + (b - virtual_b));
    };
    const auto [sum, error] = two_sum(position, term);
    std::tie(position, remainder) = two_sum(sum, error + remainder);
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

/// Iterative refinement of Laplace's equation. Differences along edges are accurate relative to the
/// edge, so are the residuals; a few steps make the whole layout so.
void refine(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
            const Eigen::VectorXd& edge_weights, const CotangentSystem& system,
            PlanarLayout& layout)
{
    const auto ends = [&](int e) {
        return std::pair(t.source(t.halfedge(e)), t.target(t.halfedge(e)));
    };
    // Changes fall from step to step until they are the rounding of the solve, where they no longer
    // halve; below 1e-15 of an edge there is nothing left to change. Ten steps only end what would go on for ever.
    double change = std::numeric_limits<double>::infinity();
    for (int step = 0; step < 10 && change > 1e-15; ++step) {
        Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(t.vertex_count(), 2);
        for (int e = 0; e < t.edge_count(); ++e) {
            const auto [a, b] = ends(e);
            const Complex pull = edge_weights[e] * layout.difference(a, b);
            residual.row(a) += Eigen::RowVector2d(pull.real(), pull.imag());
            residual.row(b) -= Eigen::RowVector2d(pull.real(), pull.imag());
        }
        const Eigen::MatrixXd correction = system.solve(residual);
        double next_change = 0.0; // relative to the edge
        for (int e = 0; e < t.edge_count(); ++e) {
            const auto [a, b] = ends(e);
            if (edge_weights[e] != 0.0)
                next_change = std::max(next_change, (correction.row(b) - correction.row(a)).norm() /
                                                        std::exp(t.scaled_log_length(e, u)));
        }
        if (change < 1e-8 && next_change > 0.5 * change)
            return;
        for (Eigen::Index v = 0; v < correction.rows(); ++v)
            add(layout, v, {correction(v, 0), correction(v, 1)});
        change = next_change;
    }
}

/// The vertex nearest to the median of both coordinates: most vertices are crowded about it.
Eigen::Index middle_vertex(const Eigen::VectorXcd& positions)
{
    const auto median = [](Eigen::VectorXd values) {
        const Eigen::Index middle = values.size() / 2;
        std::nth_element(values.begin(), values.begin() + middle, values.end());
        return values[middle];
    };
    const Complex centre(median(positions.real()), median(positions.imag()));
    Eigen::Index vertex = 0;
    (positions.array() - centre).abs2().minCoeff(&vertex);
    return vertex;
}

} // namespace

PlanarLayout lay_out_disc(const IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                          const std::vector<int>& boundary, const Eigen::VectorXd& edge_weights,
                          const CotangentSystem& system)
{
    PlanarLayout layout{Eigen::VectorXcd::Zero(t.vertex_count()),
                        Eigen::VectorXcd::Zero(t.vertex_count())};
    place_boundary(t, u, boundary, layout);
    refine(t, u, edge_weights, system, layout);

    // Positions are most precise about 0: that is where the crowd should be.
    const Eigen::Index middle = middle_vertex(layout.positions);
    const Complex shift = layout.positions[middle];
    const Complex shift_remainder = layout.remainders[middle];
    for (Eigen::Index v = 0; v < t.vertex_count(); ++v) {
        add(layout, v, -shift);
        add(layout, v, -shift_remainder);
    }
    refine(t, u, edge_weights, system, layout);
    return layout;
}

} // namespace shape::internal
