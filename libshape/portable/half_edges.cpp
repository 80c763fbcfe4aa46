// SPDX-License-Identifier: MIT

#include "libshape/mesh/half_edges.h"
#include "libshape/base/to_size.h"

#include <algorithm>
#include <array>
#include <vector>

namespace shape::internal {

HalfEdges half_edges(const Faces& faces, int vertex_count)
{
    struct Side
    {
        std::array<int, 2> ends; ///< Lower, higher.
        bool against;            ///< Runs from the higher end to the lower one.
        int halfedge;
    };
    std::vector<Side> sides;
    sides.reserve(to_size(faces.size()));
    for (int h = 0; h < faces.size(); ++h) {
        const int from = faces(h / 3, h % 3);
        const int to = faces(h / 3, (h + 1) % 3);
        sides.push_back({{std::min(from, to), std::max(from, to)}, from > to, h});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return a.ends != b.ends ? a.ends < b.ends : a.against < b.against;
    });

    HalfEdges result;
    result.edges.resize(faces.size(), 2);
    result.sides.resize(faces.size(), 2);
    std::vector<int> along_boundary(to_size(vertex_count), -1);
    int edge = 0;
    for (std::size_t i = 0; i < sides.size(); ++i, ++edge) {
        const bool two = i + 1 < sides.size() && sides[i + 1].ends == sides[i].ends;
        result.edges.row(edge) << sides[i].ends[0], sides[i].ends[1];
        result.sides.row(edge) << sides[i].halfedge, two ? sides[i + 1].halfedge : -1;
        if (two)
            ++i;
        else // each boundary vertex has one such half-edge: bow ties are defects
            along_boundary[to_size(sides[i].ends[sides[i].against ? 1 : 0])] =
                sides[i].ends[sides[i].against ? 0 : 1];
    }
    result.edges.conservativeResize(edge, 2);
    result.sides.conservativeResize(edge, 2);
    for (int& start : along_boundary)
        if (start >= 0) {
            ++result.boundary_loop_count;
            for (int* at = &start; *at >= 0;) {
                const int next = *at;
                *at = -1;
                at = &along_boundary[to_size(next)];
            }
        }
    return result;
}

} // namespace shape::internal
