// SPDX-License-Identifier: MIT

#include "libshape/conformal/disc_map.h"

#include <complex>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/conformal/conformal_edges.h"
#include "libshape/conformal/flat_metric.h"
#include "libshape/conformal/layout.h"

namespace shape {
using namespace internal;
namespace {

ConformalCertificate certify(const DiscMap& map, const FlatMetric& flat)
{
    // Negated, so that NaN fails.
    if (!flat.broken_faces.empty() || !(map.angle_residual <= 1e-9) || !(map.edges.worst <= 1e-9))
        return ConformalCertificate::Unsolved;
    if (flat.all_released)
        return ConformalCertificate::Refined;
    return map.edges.flipped.empty() ? ConformalCertificate::Exact : ConformalCertificate::Repaired;
}

} // namespace

void check(const DiscMapOptions& options)
{
    for (Eigen::Index v = 0; v < options.boundary_factors.size(); ++v)
        require(std::isfinite(options.boundary_factors[v]),
                join("DiscMapOptions.boundary_factors[", v, "]"), options.boundary_factors[v],
                "finite");
}

DiscMap map_to_plane(const Topology& topology, const Eigen::VectorXd& lengths,
                     const DiscMapOptions& options)
{
    check(options);
    if (topology.boundary_loop_count() != 1 || topology.genus() != 0)
        throw InvalidInput(join("the mesh has ", topology.boundary_loop_count(),
                                " boundary loops and genus ", topology.genus(),
                                ", a disc has 1 and 0; cut the mesh open or fill its holes"));
    const FlatMetric flat = flatten_disc(IntrinsicTriangulation(topology, lengths),
                                         options.boundary_factors.size() != 0
                                             ? options.boundary_factors
                                             : Eigen::VectorXd::Zero(topology.vertex_count()));
    DiscMap map;
    map.factors = flat.u;
    map.layout = flat.layout;
    map.edges = measure_conformal_edges(
        topology, lengths, flat.u, flat.triangulation,
        [&](int a, int b) { return std::abs(flat.layout.difference(a, b)); });
    map.angle_residual = flat.angle_residual;
    map.newton_steps = flat.newton_steps;
    map.repair_rounds = flat.rounds;
    map.certificate = certify(map, flat);
    return map;
}

} // namespace shape
