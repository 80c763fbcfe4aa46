// SPDX-License-Identifier: MIT

#include "libshape/embedding/report.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libshape/base/order_statistics.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/finished_embedding.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;

EmbeddingReport measure_embedding(const Topology& topology, const Points& points,
                                  const ShapePoint& target)
{
    return measure_embedding(topology, points, target, edge_residuals(topology, points, target));
}

EmbeddingReport measure_embedding(const Topology& topology, const Points& points,
                                  const ShapePoint& target, const EdgeResiduals& residuals)
{
    return report_of(topology, points, edge_lengths(topology, points), target, residuals);
}

EmbeddingReport internal::report_of(const Topology& topology, const Points& points,
                                    const Eigen::VectorXd& lengths, const ShapePoint& target,
                                    const EdgeResiduals& residuals)
{
    constexpr double fold = 150.0;       // [deg]
    constexpr double exact_limit = 1e-6; // [1]
    EmbeddingReport report;
    report.edge_rms = std::sqrt((lengths - target.edge_lengths).array().square().mean()) /
                      target.edge_lengths.mean();
    std::vector<double> relative(residuals.edge_error.begin(), residuals.edge_error.end());
    std::vector<double> drift;
    drift.reserve(to_size(topology.edge_count()));
    std::vector<char> inverted(to_size(topology.face_count()), 0);
    double drift_squares = 0.0;
    for (int e = 0; e < topology.edge_count(); ++e) {
        if (topology.is_boundary_edge(e))
            continue;
        drift.push_back(residuals.dihedral_drift[e]);
        drift_squares += drift.back() * drift.back();
        if (drift.back() > fold)
            for (const int h : {topology.edge_halfedges()(e, 0), topology.edge_halfedges()(e, 1)})
                inverted[to_size(h / 3)] = 1;
    }
    for (const Defect& defect :
         find_degenerate_geometry(topology.faces(), points, topology.face_count()))
        if (defect.face >= 0)
            inverted[to_size(defect.face)] = 1;
    report.inverted_faces = static_cast<int>(std::count(inverted.begin(), inverted.end(), 1));
    report.edge_max = *std::max_element(relative.begin(), relative.end());
    const std::vector<double> quantiles = quantiles_of(std::move(relative), {0.99, 0.999});
    report.edge_p99 = quantiles[0];
    report.edge_p999 = quantiles[1];
    if (!drift.empty()) {
        report.dihedral_rms_deg = std::sqrt(drift_squares / static_cast<double>(drift.size()));
        report.dihedral_max_deg = *std::max_element(drift.begin(), drift.end());
        report.dihedral_p99_deg = quantile_of(std::move(drift), 0.99);
    }
    const Admissibility admissibility = check_admissibility(topology, target.edge_lengths);
    report.reason = describe(admissibility, topology, target.edge_lengths);
    report.status = !admissibility.admissible()      ? EmbeddingStatus::Infeasible
                    : report.edge_max <= exact_limit ? EmbeddingStatus::Exact
                                                     : EmbeddingStatus::Approximate;
    return report;
}

const char* name(EmbeddingStatus status)
{
    switch (status) {
        case EmbeddingStatus::Exact:
            return "exact";
        case EmbeddingStatus::Approximate:
            return "approximate";
        case EmbeddingStatus::Infeasible:
            return "infeasible";
    }
    return "";
}

} // namespace shape
