// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/closure.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/embedding/start/face_layout.h"

namespace shape::internal {
namespace {

// For every interior vertex the product of its walk and the derivatives by its bending angles,
//
//     R_v = Z_0 X_0 ... Z_k X_k,     E_v = |R_v - I|^2,     dE_v / dd_i = -4 a_i . s,
//
// where a turn about z mixes the columns x and y of the product so far, one about x the columns y and z.
// In memory the walks of a block of two vertices of equal degree lie side by side, a row for each step:
//
//     corner_cosine_   | v w |  step 0      step_edge_   | e f |     slot_derivative_   | e f |
//                      | v w |  step 1                   | e f |                        | e f |
//
// so that both products are one sequence of operations on SSE2 registers of two doubles, nine of them for
// the columns: with four vertices those spill. The plain loop, a matrix a vertex, computes
// products of 3 by 3 of which a third of the entries are 0 or 1, and the derivative by formula (8) needs all
// partial products from both ends. Derivatives go to slots of their own and are added edge by edge after that,
// for two vertices share an edge and threads must not.

constexpr std::size_t edge_grain = 4096; // so much that handing it over costs little
constexpr std::size_t block_grain = 128; // the same

/// Interior vertices by falling degree; those of equal degree keep their order, which keeps
/// neighbours in memory close.
std::vector<int> by_degree(const Topology& topology)
{
    std::vector<int> order;
    for (int v = 0; v < topology.vertex_count(); ++v)
        if (!topology.is_boundary_vertex(v))
            order.push_back(v);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
        return topology.outgoing(a).size() > topology.outgoing(b).size();
    });
    return order;
}

} // namespace

ClosureEnergy::ClosureEnergy(const Topology& topology, const Points& corner_angles)
{
    if (corner_angles.rows() != topology.face_count())
        throw InvalidInput(join("corner_angles has ", corner_angles.rows(), " rows, the topology ",
                                topology.face_count(), " faces"));
    const int edge_count = topology.edge_count();
    const std::vector<int> vertices = by_degree(topology);
    std::size_t rows = 0;
    for (std::size_t i = 0; i < vertices.size(); i += lanes) {
        blocks_.push_back({rows, topology.outgoing(vertices[i]).size()});
        rows += blocks_.back().steps;
    }
    corner_cosine_.assign(rows, Row::Ones());
    corner_sine_.assign(rows, Row::Zero());
    step_edge_.assign(rows, Eigen::Array<int, lanes, 1>::Constant(edge_count));
    edge_slots_.setConstant(edge_count, 2, static_cast<int>(rows * lanes));
    Points sines(corner_angles.rows(), 3), cosines(corner_angles.rows(), 3);
    sines_cosines(corner_angles.data(), to_size(corner_angles.size()), sines.data(),
                  cosines.data());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const auto ring = topology.outgoing(vertices[i]);
        const auto lane = static_cast<Eigen::Index>(i % lanes);
        for (std::size_t step = 0; step < ring.size(); ++step) {
            // Step i crosses the face left of half-edge i and turns at half-edge i + 1.
            const int h = ring[step];
            const int turn = ring[(step + 1) % ring.size()];
            const std::size_t row = blocks_[i / lanes].first + step;
            corner_cosine_[row][lane] = cosines(h / 3, h % 3);
            corner_sine_[row][lane] = sines(h / 3, h % 3);
            const int edge = topology.edge(turn);
            step_edge_[row][lane] = edge;
            const bool at_lower_end = topology.edges()(edge, 0) == vertices[i];
            edge_slots_(edge, at_lower_end ? 0 : 1) =
                static_cast<int>(row * lanes) + static_cast<int>(lane);
        }
    }
    cosine_.assign(to_size(edge_count) + 1, 1.0);
    sine_.assign(to_size(edge_count) + 1, 0.0);
    slot_derivative_.assign(rows * lanes + 1, 0.0);
}

double ClosureEnergy::evaluate(const Eigen::Ref<const Eigen::VectorXd>& dihedral_angles,
                               Eigen::Ref<Eigen::VectorXd> gradient)
{
    if (dihedral_angles.size() != edge_count() || gradient.size() != edge_count())
        throw InvalidInput(join("dihedral_angles has ", dihedral_angles.size(),
                                " entries and gradient ", gradient.size(), ", the topology ",
                                edge_count(), " edges"));
    const auto edges = to_size(edge_count());
    parallel_for(edges, edge_grain, [&](std::size_t begin, std::size_t end) {
        sines_cosines(dihedral_angles.data() + begin, end - begin, sine_.data() + begin,
                      cosine_.data() + begin);
        for (std::size_t e = begin; e < end; ++e)
            sine_[e] = -sine_[e]; // the walk turns by -theta
    });
    const double energy =
        parallel_sum(blocks_.size(), block_grain, [&](std::size_t begin, std::size_t end) {
            Rows scratch(3 * blocks_[begin].steps); // the first block has the highest degree
            double sum = 0.0;
            for (std::size_t b = begin; b < end; ++b)
                sum += walk(blocks_[b], scratch);
            return sum;
        });
    parallel_for(edges, edge_grain, [&](std::size_t begin, std::size_t end) {
        for (auto e = static_cast<Eigen::Index>(begin); e < static_cast<Eigen::Index>(end); ++e)
            gradient[e] = slot_derivative_[to_size(edge_slots_(e, 0))] +
                          slot_derivative_[to_size(edge_slots_(e, 1))];
    });
    return energy;
}

/// Walks the vertices of a block; writes the derivatives by their edges, returns the sum of E_v.
double ClosureEnergy::walk(const Block& block, Rows& scratch)
{
    // Columns x, y, z of the product so far.
    Row x0 = Row::Ones(), x1 = Row::Zero(), x2 = Row::Zero();
    Row y0 = Row::Zero(), y1 = Row::Ones(), y2 = Row::Zero();
    Row z0 = Row::Zero(), z1 = Row::Zero(), z2 = Row::Ones();
    const auto turn = [](const Row& c, const Row& s, Row& a, Row& b) {
        const Row turned = c * a + s * b;
        b = c * b - s * a;
        a = turned;
    };
    for (std::size_t step = 0; step < block.steps; ++step) {
        const std::size_t row = block.first + step;
        const Row& zc = corner_cosine_[row];
        const Row& zs = corner_sine_[row];
        turn(zc, zs, x0, y0);
        turn(zc, zs, x1, y1);
        turn(zc, zs, x2, y2);
        scratch[3 * step] = x0;
        scratch[3 * step + 1] = x1;
        scratch[3 * step + 2] = x2;
        Row xc, xs;
        for (int lane = 0; lane < lanes; ++lane) {
            const auto e = to_size(step_edge_[row][lane]);
            xc[lane] = cosine_[e];
            xs[lane] = sine_[e];
        }
        turn(xc, xs, y0, z0);
        turn(xc, xs, y1, z1);
        turn(xc, xs, y2, z2);
    }
    // -4 s: the bending angle counts against the turn, hence the sign.
    const Row s0 = -2.0 * (y2 - z1);
    const Row s1 = -2.0 * (z0 - x2);
    const Row s2 = -2.0 * (x1 - y0);
    for (std::size_t step = 0; step < block.steps; ++step) {
        Eigen::Map<Row> derivative(slot_derivative_.data() + (block.first + step) * lanes);
        derivative =
            scratch[3 * step] * s0 + scratch[3 * step + 1] * s1 + scratch[3 * step + 2] * s2;
    }
    x0 -= 1.0;
    y1 -= 1.0;
    z2 -= 1.0;
    const Row energy =
        x0 * x0 + x1 * x1 + x2 * x2 + y0 * y0 + y1 * y1 + y2 * y2 + z0 * z0 + z1 * z1 + z2 * z2;
    return energy.sum();
}

double closure_energy(const Topology& topology, const Eigen::VectorXd& lengths,
                      const Eigen::VectorXd& dihedral_angles)
{
    const FaceLayout layout = lay_out_faces(topology, lengths, dihedral_angles);
    return (4.0 * (1.0 - closure_angles(topology, layout.transitions).array().cos())).sum();
}

} // namespace shape::internal
