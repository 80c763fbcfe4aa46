// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libshape/mesh/topology.h"
#include "libshape/registration/scan_fit.h"
#include "tools/program/session.h"

namespace shape::tools {

/// Where things go: a directory of meshes, or a collection and a folder of reports beside it.
struct FitPlaces
{
    std::filesystem::path collection; ///< Empty: none.
    std::filesystem::path directory;

    [[nodiscard]] std::filesystem::path mesh(const std::string& scan) const
    {
        return directory / (scan + ".ply");
    }
    [[nodiscard]] std::filesystem::path report() const { return directory / "fit.json"; }
    [[nodiscard]] std::filesystem::path table() const { return directory / "fit.csv"; }
    [[nodiscard]] std::filesystem::path sheet() const { return directory / "fit.svg"; }
    [[nodiscard]] std::filesystem::path scores() const { return directory / "scores.csv"; }
};

/// What a run writes.
struct FitFiles
{
    std::vector<std::string> scans; ///< Their names.
    bool scores = false;            ///< There are some: a model is fitted.
    bool resume = false;            ///< An earlier run goes on.
};

/// Makes the directory and asks check_output() about all files; if an earlier run goes on, check_not_protected() about
/// those that are written anew.
/// @param given  A directory, or a collection (.h5): then NAME_fit beside it is the directory.
/// @throws UsageError if it is neither, or as check_output().
/// @throws FileError as check_output(), or if the directory cannot be made.
[[nodiscard]] FitPlaces fit_places(const Session& session, const std::string& given,
                                   const FitFiles& files,
                                   const std::vector<std::filesystem::path>& inputs);

/// A scan's row of the report (docs/json.md).
/// @param ignored  Scan::ignored.
[[nodiscard]] Json fit_figures(const std::string& scan, const ScanFit& fit, const Json& ignored);

/// The row of a scan that could not be fitted.
[[nodiscard]] Json fit_failure(const std::string& scan, const std::string& reason);

/// The report of an earlier run with the same settings: its `scans` and `rounds`, both empty if there is none.
/// @throws InvalidInput if it was made with other settings, or is not a report.
[[nodiscard]] Json earlier_fit_report(const FitPlaces& places, const Json& settings);

/// fit.json, and fit.csv with a row a scan.
void write_fit_report(const FitPlaces& places, const Json& settings, const Json& scans,
                      const Json& rounds);

/// The mesh of a fit, with distance, growth and seen at its vertices.
/// @throws FileError as check_not_protected() and write_vertex_scalars().
void write_fit(const FitPlaces& places, const std::string& scan, const Topology& topology,
               const ScanFit& fit);

/// What later rounds need of a fit that an earlier run has written.
/// @param row  The scan's in the report.
[[nodiscard]] ScanFit read_fit(const FitPlaces& places, const Json& row);

/// Scores of a model's fits as `shape generate --scores-file` takes them.
void write_fit_scores(const FitPlaces& places, const Json& rows, int modes);

/// All fits side by side, coloured by their distance to the scan, the worst first.
void draw_fit_sheet(const Session& session, const FitPlaces& places, const Topology& topology,
                    const Json& scans);

} // namespace shape::tools
