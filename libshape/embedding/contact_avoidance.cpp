// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact_avoidance.h"

#include <utility>

#include "libshape/embedding/contact/contact_separation.h"
#include "libshape/embedding/report.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {

ContactAvoidance::Result ContactAvoidance::apart(const Points& points, const ShapePoint& target)
{
    const int before = crossings_.count(points).in_no_reference;
    if (before == 0)
        return {points, before};
    std::call_once(made_, [this] {
        Eigen::VectorXd lengths = Eigen::VectorXd::Zero(topology_.edge_count());
        for (const Points& reference : references_)
            lengths += edge_lengths(topology_, reference);
        laplacian_.emplace(topology_, lengths / static_cast<double>(references_.size()));
    });
    ContactSeparationOptions options;
    options.smoothness = smoothness_;
    const auto inverted = [&](const Points& mesh) {
        return measure_embedding(topology_, mesh, target).inverted_faces;
    };
    const int inverted_before = inverted(points);
    ContactSeparation separation = separate_contacts(
        topology_, crossings_.faces(), crossings_.known(), laplacian_->single_precision(), points,
        [&](const Points& mesh) { return inverted(mesh) <= inverted_before; }, options);
    return {std::move(separation.points), before};
}

} // namespace shape::internal
