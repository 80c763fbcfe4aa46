// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_prior.h"
#include "libshape/registration/scan_fit.h"

namespace shape {

/// A fit, and what a prior makes of it.
struct PriorFit
{
    ScanFit fit;
    ShapePosterior expected; ///< Of the edges that have a counterpart.
};

/// Fits a scan, then again three times, each time held to the posterior of a prior given the last fit: what the scan
/// does not show comes out as the prior expects it, what it shows stays on the scan.
/// @param fitter  Of a template of this topology, best the prior's mean.
/// @throws InvalidInput as ScanFitter::fit(), or if the prior is of another triangulation.
[[nodiscard]] PriorFit fit_by_prior(const ScanFitter& fitter, const Topology& topology,
                                    const ShapePrior& prior, const Scan& scan,
                                    const LandmarkPairs& landmarks = {});

/// A scan and its landmarks, by its number.
using ScanSource = std::function<std::pair<Scan, LandmarkPairs>(std::size_t)>;

/// What a round has done to a group of fits.
struct GroupRound
{
    int fits = 0;            ///< That took part.
    double change = 0.0;     ///< RMS change of edge lengths in this round, over their mean.
    double unexpected = 0.0; ///< RMS of edge lengths before it, against what the other fits expect.
};

/// Fits a group of scans again: each is held to what the fits of all others expect of it (shape_prior.h; its own
/// edges that have a counterpart say which), in place of the template's lengths and angles.
/// What each fit has for itself alone, how its vertices slid along the surface, gives way to what they share.
/// @param fits  Failed ones take no part and stay as they are; at least 4 others.
/// @param scans  Called once for each fit, in order.
/// @throws InvalidInput if there are fewer than 4 fits, or all have the same lengths.
/// Cost: N times ScanFitter::fit_again(), and O(N^2 #E) for each. Does not depend on the order but for rounding.
GroupRound fit_group_again(const ScanFitter& fitter, const Topology& topology,
                           const ScanSource& scans, std::vector<ScanFit>& fits,
                           const Progress& progress = {});

} // namespace shape
