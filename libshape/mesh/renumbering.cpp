// SPDX-License-Identifier: MIT

#include "libshape/mesh/renumbering.h"

#include <algorithm>
#include <numeric>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Calls work(now, then) for every number and what it was before.
template <class Work>
void for_entries(const std::vector<int>& before, const Work& work)
{
    parallel_for(before.size(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            work(static_cast<Eigen::Index>(i), before[i]);
    });
}

} // namespace

Renumbering renumber_for_locality(const Topology& topology)
{
    std::vector<int> order{0}; // of vertices
    order.reserve(to_size(topology.vertex_count()));
    std::vector<int> number(to_size(topology.vertex_count()), -1);
    number[0] = 0;
    const auto visit = [&](int v) {
        int& place = number[to_size(v)];
        if (place < 0) {
            place = static_cast<int>(order.size());
            order.push_back(v);
        }
    };
    for (std::size_t i = 0; i < order.size(); ++i) // it grows on the way
        for (const int h : topology.outgoing(order[i])) {
            visit(topology.target(h));
            visit(topology.source(Topology::previous(h)));
        }

    Faces faces(topology.face_count(), 3);
    for (Eigen::Index k = 0; k < faces.size(); ++k)
        faces.data()[k] = number[to_size(topology.faces().data()[k])];
    std::vector<int> face_order(to_size(faces.rows()));
    std::iota(face_order.begin(), face_order.end(), 0);
    std::sort(face_order.begin(), face_order.end(), [&](int a, int b) {
        return std::pair(faces.row(a).minCoeff(), a) < std::pair(faces.row(b).minCoeff(), b);
    });
    const Faces sorted = faces(face_order, Eigen::all);

    Renumbering result{Topology(sorted, topology.vertex_count()), std::move(order), {}};
    result.edges.reserve(to_size(topology.edge_count()));
    for (int e = 0; e < topology.edge_count(); ++e) {
        const auto before = [&](int end) {
            return result.vertices[to_size(result.topology.edges()(e, end))];
        };
        result.edges.push_back(topology.find_edge(before(0), before(1)));
    }
    return result;
}

Points renumbered(const Renumbering& renumbering, const Points& points)
{
    return points(renumbering.vertices, Eigen::all);
}

Points restored(const Renumbering& renumbering, const Eigen::Ref<const Points>& points)
{
    Points before(points.rows(), 3);
    for_entries(renumbering.vertices,
                [&](Eigen::Index now, Eigen::Index then) { before.row(then) = points.row(now); });
    return before;
}

Eigen::VectorXd renumbered(const Renumbering& renumbering, const Eigen::VectorXd& values)
{
    Eigen::VectorXd now_values(values.size());
    for_entries(renumbering.edges,
                [&](Eigen::Index now, Eigen::Index then) { now_values[now] = values[then]; });
    return now_values;
}

} // namespace shape::internal
