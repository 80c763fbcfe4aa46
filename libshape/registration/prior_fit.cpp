// SPDX-License-Identifier: MIT

#include "libshape/registration/prior_fit.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Edges whose ends both have a counterpart; all, if none has.
std::vector<char> seen_edges(const Topology& topology, const ScanFit& fit)
{
    std::vector<char> edges(to_size(topology.edge_count()));
    bool any = false;
    for (int e = 0; e < topology.edge_count(); ++e) {
        const bool both = fit.seen[to_size(topology.edges()(e, 0))] != 0 &&
                          fit.seen[to_size(topology.edges()(e, 1))] != 0;
        edges[to_size(e)] = both ? 1 : 0;
        any = any || both;
    }
    if (!any)
        edges.assign(edges.size(), 1);
    return edges;
}

ShapePosterior expected_of(const ScanFit& fit, const Topology& topology, const ShapePrior& prior)
{
    return posterior(prior, edge_lengths(topology, fit.points), seen_edges(topology, fit));
}

} // namespace

PriorFit fit_by_prior(const ScanFitter& fitter, const Topology& topology, const ShapePrior& prior,
                      const Scan& scan, const LandmarkPairs& landmarks)
{
    PriorFit result{fitter.fit(scan, landmarks), {}};
    constexpr int rounds = 3; // as docs/experiments/correspondence.md has measured it; not tuned
    for (int round = 0; round < rounds; ++round) {
        result.expected = expected_of(result.fit, topology, prior);
        result.fit =
            fitter.fit_again(scan, landmarks, result.fit, result.expected.point, Sliding::Free);
    }
    result.expected = expected_of(result.fit, topology, prior);
    return result;
}

GroupRound fit_group_again(const ScanFitter& fitter, const Topology& topology,
                           const ScanSource& scans, std::vector<ScanFit>& fits,
                           const Progress& progress)
{
    Collection group{topology, {}, {}, {}};
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < fits.size(); ++i)
        if (fits[i].status != FitStatus::Failed) {
            members.push_back(i);
            group.points.push_back(fits[i].points);
        }
    constexpr std::size_t least_fits =
        4; // what two others span is a line: it would expect little of a third
    if (members.size() < least_fits)
        throw InvalidInput(join("a group needs ", least_fits, " fits, there are ", members.size()));
    const ShapeVectors vectors = shape_vectors(group, Scale::Unit);
    const RowMatrix centred =
        vectors.edge_lengths.rowwise() - vectors.edge_lengths.colwise().mean();
    constexpr double noise_share = 1e-3; // of the variance: the last modes of few fits count less
    const double noise = noise_share * centred.squaredNorm() / static_cast<double>(members.size());
    constexpr double rounding = 1e-24; // of squares
    if (!(centred.squaredNorm() > rounding * vectors.edge_lengths.squaredNorm()))
        throw InvalidInput("a group's fits are all equal");

    GroupRound round;
    round.fits = static_cast<int>(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
        if (progress)
            progress("fit again", k, members.size());
        ScanFit& fit = fits[members[k]];
        const VectorXd lengths = edge_lengths(topology, fit.points);
        const ShapePosterior expected =
            expected_of(fit, topology, prior_of(vectors, static_cast<int>(k), noise));
        const auto [scan, landmarks] = scans(members[k]);
        fit = fitter.fit_again(scan, landmarks, fit, expected.point);
        const double count = static_cast<double>(lengths.size()) * lengths.mean() * lengths.mean();
        round.unexpected += expected.residual * expected.residual / round.fits;
        round.change +=
            (edge_lengths(topology, fit.points) - lengths).squaredNorm() / count / round.fits;
    }
    if (progress)
        progress("fit again", members.size(), members.size());
    round.change = std::sqrt(round.change);
    round.unexpected = std::sqrt(round.unexpected);
    return round;
}

} // namespace shape
