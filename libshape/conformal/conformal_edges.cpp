// SPDX-License-Identifier: MIT

#include "libshape/conformal/conformal_edges.h"

#include <algorithm>
#include <cmath>

namespace shape::internal {

ConformalEdges measure_conformal_edges(const Topology& topology, const Eigen::VectorXd& lengths,
                                       const Eigen::VectorXd& factors,
                                       const IntrinsicTriangulation& t,
                                       const std::function<double(int, int)>& distance)
{
    ConformalEdges result;
    result.residuals.resize(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int a = topology.edges()(e, 0);
        const int b = topology.edges()(e, 1);
        result.residuals[e] =
            std::log(distance(a, b) / lengths[e]) - 0.5 * (factors[a] + factors[b]);
        const int h = t.halfedge(e);
        if (std::minmax(t.source(h), t.target(h)) != std::pair<const int&, const int&>(a, b))
            result.flipped.push_back(e);
        else
            result.worst = std::max(result.worst, std::abs(result.residuals[e]));
    }
    return result;
}

} // namespace shape::internal
