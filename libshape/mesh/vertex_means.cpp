// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_means.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;

Eigen::VectorXd vertex_means(const Topology& topology, const Eigen::VectorXd& edge_values)
{
    if (edge_values.size() != topology.edge_count())
        throw InvalidInput(join("edge_values has ", edge_values.size(), " entries, the topology ",
                                topology.edge_count(), " edges"));
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(topology.vertex_count());
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(topology.vertex_count());
    for (int e = 0; e < topology.edge_count(); ++e)
        for (const int v : topology.edges().row(e)) {
            sums[v] += edge_values[e];
            counts[v] += 1.0;
        }
    return sums.cwiseQuotient(counts); // every vertex of a topology has an edge
}

} // namespace shape
