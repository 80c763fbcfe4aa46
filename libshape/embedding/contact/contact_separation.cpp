// SPDX-License-Identifier: MIT

#include "libshape/embedding/contact/contact_separation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "libshape/base/require.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/energy/descent.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {

using Eigen::VectorXd;

void check(const ContactSeparationOptions& options)
{
    require_positive(options.smoothness, "ContactSeparationOptions.smoothness");
    check(options.gaps);
    require_at_least(0, options.rounds, "ContactSeparationOptions.rounds");
    require_at_least(0, options.refinements, "ContactSeparationOptions.refinements");
    require_at_least(2, options.linear_steps, "ContactSeparationOptions.linear_steps");
    require(options.growth >= 1.0 && std::isfinite(options.growth),
            "ContactSeparationOptions.growth", options.growth, ">= 1 and finite");
    require_positive(options.stretch, "ContactSeparationOptions.stretch");
}

ContactSeparation separate_contacts(const Topology& topology, const FaceTree& faces,
                                    const std::vector<FacePair>& allowed,
                                    const SinglePrecisionSolve& factor, const Points& points,
                                    const std::function<bool(const Points&)>& is_acceptable,
                                    const ContactSeparationOptions& options)
{
    check(options);
    const VectorXd lengths = positive_lengths(edge_lengths(topology, points));
    LengthDihedralEnergy energy(topology, {lengths, dihedral_angles(topology, points)},
                                options.smoothness);
    energy.keep_areas();
    Descender descender(energy, factor);

    const auto mesh = [&](const VectorXd& at) { return Points::Map(at.data(), points.rows(), 3); };
    const auto crossing_in = [&](const VectorXd& at) { return faces.crossings(mesh(at)); };
    const auto is_stretched = [&](const VectorXd& at) {
        const VectorXd now = edge_lengths(topology, mesh(at));
        return !(((now - lengths).array().abs() <= options.stretch * lengths.array()).all());
    };
    const auto not_allowed = [&](const std::vector<FacePair>& pairs) {
        std::vector<FacePair> rest;
        std::set_difference(pairs.begin(), pairs.end(), allowed.begin(), allowed.end(),
                            std::back_inserter(rest));
        return rest;
    };

    VectorXd here = points.reshaped<Eigen::RowMajor>();
    const std::vector<FacePair> at_start = crossing_in(here);
    std::vector<FacePair> met = not_allowed(at_start); // in any round
    const auto pairs_before = static_cast<int>(met.size());
    ContactSeparation best{points, pairs_before};
    double least = 0.0; // E of the best
    ContactGapOptions gaps = options.gaps;
    int refinements = 0;
    for (int round = 0; round < options.rounds; ++round) {
        if (best.pairs == 0 && refinements++ == options.refinements)
            break;
        energy.keep_apart(contact_gaps(topology, here, met, gaps));
        constexpr double tolerance = 1e-3; // gaps change from round to round anyway
        here = descender
                   .descend(std::move(here), {.max_linear_steps = options.linear_steps,
                                              .first_linear_steps = options.linear_steps / 2 + 1,
                                              .decrease_tolerance = tolerance})
                   .points;
        const std::vector<FacePair> found = crossing_in(here);
        const std::vector<FacePair> pairs = not_allowed(found);
        energy.keep_apart({});
        VectorXd gradient;
        const double bent = energy.evaluate(here, gradient);
        const auto count = static_cast<int>(pairs.size());
        const bool is_better = count < best.pairs || (count == best.pairs && bent < least);
        if (is_better && found.size() <= at_start.size() && !is_stretched(here) &&
            is_acceptable(mesh(here))) {
            best = {mesh(here), count};
            least = bent;
        }
        std::vector<FacePair> all;
        std::set_union(met.begin(), met.end(), pairs.begin(), pairs.end(), std::back_inserter(all));
        met.swap(all);
        gaps.stiffness *= options.growth;
    }
    // A mesh that costs edges and hardly helps is not better.
    if (2 * best.pairs > pairs_before)
        return {points, pairs_before};
    return best;
}

} // namespace shape::internal
