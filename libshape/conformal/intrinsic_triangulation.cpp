// SPDX-License-Identifier: MIT

#include "libshape/conformal/intrinsic_triangulation.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

IntrinsicTriangulation::IntrinsicTriangulation(const Topology& topology,
                                               const Eigen::VectorXd& lengths)
    : vertex_count_(topology.vertex_count()),
      faces_(topology.faces()),
      edges_(topology.face_edges())
{
    if (lengths.size() != topology.edge_count())
        throw InvalidInput(join("lengths has ", lengths.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!(lengths[e] > 0.0) || !std::isfinite(lengths[e]))
            throw InvalidInput(join("lengths[", e, "] (edge ", topology.edges()(e, 0), "-",
                                    topology.edges()(e, 1), ") is ", lengths[e],
                                    ", must be finite and > 0"));
    log_lengths_ = lengths.array().log();
    halfedge_.resize(to_size(topology.edge_count()));
    for (int e = 0; e < topology.edge_count(); ++e)
        halfedge_[to_size(e)] = topology.edge_halfedges()(e, 0);
    opposite_.resize(to_size(topology.halfedge_count()));
    for (int h = 0; h < topology.halfedge_count(); ++h)
        opposite_[to_size(h)] = topology.opposite(h);
}

std::vector<int> IntrinsicTriangulation::ring(int start) const
{
    // Clockwise first, to the boundary if there is one.
    int first = start;
    while (opposite(first) >= 0) {
        first = Topology::next(opposite(first));
        if (first == start)
            break;
    }
    std::vector<int> ring;
    int h = first;
    do {
        ring.push_back(h);
        h = opposite(Topology::previous(h));
    } while (h >= 0 && h != first);
    return ring;
}

std::vector<int> IntrinsicTriangulation::first_halfedges() const
{
    std::vector<int> first(to_size(vertex_count_), -1);
    for (int h = 3 * face_count() - 1; h >= 0; --h)
        first[to_size(source(h))] = h;
    return first;
}

bool IntrinsicTriangulation::is_flippable(int edge) const
{
    const int h = halfedge(edge);
    return opposite(h) >= 0 && Topology::face(h) != Topology::face(opposite(h));
}

double IntrinsicTriangulation::flipped_log_length(int edge) const
{
    const int h = halfedge(edge);
    const int o = opposite(h);
    const auto side = [&](int halfedge) { return log_lengths_[this->edge(halfedge)]; };
    const double x = side(Topology::next(h)) + side(Topology::next(o));
    const double y = side(Topology::previous(h)) + side(Topology::previous(o));
    return std::max(x, y) + std::log1p(std::exp(-std::abs(x - y))) - log_lengths_[edge];
}

void IntrinsicTriangulation::set_halfedge(int halfedge, int source, int edge, int opposite)
{
    faces_(halfedge / 3, halfedge % 3) = source;
    edges_(halfedge / 3, halfedge % 3) = edge;
    halfedge_[to_size(edge)] = halfedge;
    opposite_[to_size(halfedge)] = opposite;
    if (opposite >= 0)
        opposite_[to_size(opposite)] = halfedge;
}

void IntrinsicTriangulation::flip(int e)
{
    log_lengths_[e] = flipped_log_length(e);
    // Faces (a, b, c) and (b, a, d) become (d, b, c) and (c, a, d).
    const int h0 = halfedge(e);
    const int h1 = Topology::next(h0);
    const int h2 = Topology::next(h1);
    const int o0 = opposite(h0);
    const int o1 = Topology::next(o0);
    const int o2 = Topology::next(o1);
    const int c = source(h2);
    const int d = source(o2);
    const int edge_ca = edge(h2);
    const int edge_db = edge(o2);
    const int opposite_ca = opposite(h2);
    const int opposite_db = opposite(o2);
    const int opposite_bc = opposite(h1);
    const int opposite_ad = opposite(o1);
    // Sides of the quadrilateral that are glued to each other keep pointing at each other.
    const auto moved = [&](int halfedge) {
        return halfedge == h2 ? o0 : halfedge == o2 ? h0 : halfedge;
    };
    const int b = source(h1);
    const int a = source(o1);
    set_halfedge(h1, b, edge(h1), moved(opposite_bc));
    set_halfedge(o1, a, edge(o1), moved(opposite_ad));
    set_halfedge(h0, d, edge_db, moved(opposite_db));
    set_halfedge(o0, c, edge_ca, moved(opposite_ca));
    set_halfedge(h2, c, e, o2);
    set_halfedge(o2, d, e, h2);
}

} // namespace shape::internal
