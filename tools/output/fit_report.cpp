// SPDX-License-Identifier: MIT

#include "tools/output/fit_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/collection.h"
#include "libshape/registration/fit_verdict.h"
#include "libshape/report/picture.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

const char* status_name(FitStatus status)
{
    return status == FitStatus::Good ? "good" : status == FitStatus::Check ? "check" : "failed";
}

/// One row a scan; cells that a scan without a fit has no figure for are empty.
Table fit_table(const Json& scans)
{
    Table table{{"scan",
                 "status",
                 "reason",
                 "scan_to_fit_mean",
                 "scan_to_fit_p95",
                 "scan_to_fit_max",
                 "fit_to_scan_mean",
                 "fit_to_scan_p95",
                 "fit_to_scan_max",
                 "diagonal",
                 "landmark_mean",
                 "landmark_max",
                 "strain_rms",
                 "growth_low",
                 "growth_high",
                 "folded_faces",
                 "crossing_pairs",
                 "unseen_vertices",
                 "unclaimed_share",
                 "contested_vertices",
                 "scale",
                 "ignored"},
                {}};
    const auto sentence = [](const Json& scan, const char* key) {
        std::string text;
        if (scan.contains(key))
            for (const auto& part : scan[key])
                text += (text.empty() ? "" : "; ") + part.get<std::string>();
        return text;
    };
    for (const Json& scan : scans) {
        std::vector<std::string> row{scan["scan"].get<std::string>(),
                                     scan["status"].get<std::string>(), sentence(scan, "reasons")};
        const auto add = [&](const Json* value) {
            row.push_back(value != nullptr ? print_number(value->get<double>()) : "");
        };
        const auto find = [](const Json& in, const char* key) {
            return in.contains(key) ? &in[key] : nullptr;
        };
        for (const char* way : {"scan_to_fit", "fit_to_scan"})
            for (const char* figure : {"mean", "p95", "max"})
                add(find(scan, way) != nullptr ? find(scan[way], figure) : nullptr);
        for (const char* key :
             {"diagonal", "landmark_mean", "landmark_max", "strain_rms", "growth_low",
              "growth_high", "folded_faces", "crossing_pairs", "unseen_vertices", "unclaimed_share",
              "contested_vertices", "scale"})
            add(find(scan, key));
        row.push_back(sentence(scan, "ignored"));
        table.rows.push_back(std::move(row));
    }
    return table;
}

} // namespace

Json fit_figures(const std::string& scan, const ScanFit& fit, const Json& ignored)
{
    const auto summary = [](const DistanceSummary& d) {
        return Json{{"mean", d.mean}, {"p95", d.p95}, {"max", d.max}};
    };
    const Eigen::VectorXd& errors = fit.landmark_errors;
    Json notes = ignored;
    const std::string turned = join(counted(fit.turned_faces, "face"), " turned to face outwards");
    if (fit.turned_faces > 0 && std::find(notes.begin(), notes.end(), turned) == notes.end())
        notes.push_back(turned);
    Json doubted = Json::array();
    for (const DoubtedLandmark& landmark : fit.doubted_landmarks)
        doubted.push_back({{"landmark", landmark.name}, {"off", landmark.off}});
    return {{"scan", scan},
            {"status", status_name(fit.status)},
            {"reasons", fit.reasons},
            {"ignored", notes},
            {"scan_to_fit", summary(fit.scan_to_fit)},
            {"fit_to_scan", summary(fit.fit_to_scan)},
            {"diagonal", fit.diagonal},
            {"landmarks", errors.size()},
            {"landmark_mean", errors.size() > 0 ? errors.mean() : 0.0},
            {"landmark_max", errors.size() > 0 ? errors.maxCoeff() : 0.0},
            {"doubted_landmarks", doubted},
            {"strain_rms", fit.strain_rms},
            {"growth_low", fit.growth_low},
            {"growth_high", fit.growth_high},
            {"folded_faces", fit.folded_faces},
            {"crossing_pairs", fit.crossing_pairs},
            {"unseen_vertices", fit.unseen_vertices},
            {"unclaimed_share", fit.unclaimed_share},
            {"contested_vertices", fit.contested_vertices},
            {"scale", fit.scale}};
}

Json fit_failure(const std::string& scan, const std::string& reason)
{
    return {{"scan", scan}, {"status", "failed"}, {"reasons", {reason}}};
}

FitPlaces fit_places(const Session& session, const std::string& given, const FitFiles& files,
                     const std::vector<fs::path>& inputs)
{
    FitPlaces places;
    const fs::path output = given;
    const auto check = [&](const fs::path& path) {
        if (files.resume)
            check_not_protected(path);
        else
            check_output(session, path, inputs);
    };
    if (has_ending(output, ".h5")) {
        places.collection = output;
        places.directory = output.parent_path() / (output.stem().string() + "_fit");
        check(output);
    } else {
        places.directory = output;
        if (names_a_file(output))
            refuse_file(join("-o is '", given, "', must be a directory or a collection (.h5)"));
    }
    std::error_code error;
    fs::create_directories(places.directory, error);
    if (error)
        throw FileError(join(places.directory.string(), ": ", error.message()));
    for (const fs::path& path : {places.report(), places.table(), places.sheet()})
        check(path);
    if (files.scores)
        check(places.scores());
    if (!files.resume) // else those that are there are taken over; write_fit() asks about the rest
        for (const std::string& scan : files.scans)
            check(places.mesh(scan));
    return places;
}

Json earlier_fit_report(const FitPlaces& places, const Json& settings)
{
    if (!fs::exists(places.report()))
        return {{"scans", Json::array()}, {"rounds", Json::array()}};
    const std::string path = places.report().string();
    Json report;
    try {
        report = Json::parse(read_file(places.report(), std::uint64_t{256} << 20));
        if (report.at("settings") != settings)
            throw InvalidInput(join(path,
                                    ": was made with other settings; remove it, or run "
                                    "without --resume"));
        return {{"scans", report.at("scans")}, {"rounds", report.at("rounds")}};
    } catch (const Json::exception&) {
        throw InvalidInput(join(path,
                                ": is not the report of a run; remove it, or run without "
                                "--resume"));
    }
}

void write_fit_report(const FitPlaces& places, const Json& settings, const Json& scans,
                      const Json& rounds)
{
    write_file_atomically(places.report(),
                          Json{{"settings", settings}, {"scans", scans}, {"rounds", rounds}}.dump(
                              1, ' ', false, Json::error_handler_t::replace) +
                              "\n");
    write_table(places.table(), fit_table(scans));
}

void write_fit(const FitPlaces& places, const std::string& scan, const Topology& topology,
               const ScanFit& fit)
{
    const Eigen::VectorXd seen =
        Eigen::Matrix<char, Eigen::Dynamic, 1>::Map(fit.seen.data(), std::ssize(fit.seen))
            .cast<double>();
    check_not_protected(places.mesh(scan)); // which is not asked about before a run is resumed
    write_vertex_scalars(places.mesh(scan), fit.points, topology.faces(),
                         {{"distance", fit.distance}, {"growth", fit.growth}, {"seen", seen}});
}

ScanFit read_fit(const FitPlaces& places, const Json& row)
{
    const fs::path path = places.mesh(row["scan"].get<std::string>());
    ScanFit fit;
    fit.points = read_mesh(path).points;
    for (const double seen : read_vertex_scalar(path, "seen"))
        fit.seen.push_back(seen != 0.0 ? 1 : 0);
    fit.scale = row["scale"].get<double>();
    for (const Json& reason : row["reasons"])
        if (is_start_doubt(reason.get<std::string>()))
            fit.start_doubt = reason.get<std::string>();
    for (const Json& doubted : row.value("doubted_landmarks", Json::array()))
        fit.doubted_landmarks.push_back(
            {doubted["landmark"].get<std::string>(), doubted["off"].get<double>()});
    fit.status = row["status"] == "good"    ? FitStatus::Good
                 : row["status"] == "check" ? FitStatus::Check
                                            : FitStatus::Failed;
    return fit;
}

void write_fit_scores(const FitPlaces& places, const Json& rows, int modes)
{
    Table table{{"mesh", "size", "residual_rms"}, {}};
    for (int k = 1; k <= modes; ++k)
        table.columns.push_back(join("pc", k));
    for (const Json& row : rows) {
        if (!row.contains("scores"))
            continue;
        std::vector<std::string> cells{row["scan"].get<std::string>(),
                                       print_number(row["model_size"].get<double>()),
                                       print_number(row["model_residual_rms"].get<double>())};
        for (const Json& score : row["scores"])
            cells.push_back(print_number(score.get<double>()));
        table.rows.push_back(std::move(cells));
    }
    write_table(places.scores(), table);
}

void draw_fit_sheet(const Session& session, const FitPlaces& places, const Topology& topology,
                    const Json& scans)
{
    struct Entry
    {
        double mean;
        std::string scan, caption;
    };
    std::vector<Entry> entries;
    for (const Json& scan : scans) {
        const auto of = scan["scan"].get<std::string>();
        const auto status = scan["status"].get<std::string>();
        if (!scan.contains("scan_to_fit") || !fs::exists(places.mesh(of)))
            continue;
        entries.push_back(
            {scan["scan_to_fit"]["mean"].get<double>() / scan["diagonal"].get<double>(), of,
             status == "good" ? of : join(of, " (", status, ")")});
    }
    if (entries.empty())
        return;
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.mean > b.mean; });
    Collection collection{topology, {}, {}, {}};
    PictureOptions options;
    for (const Entry& entry : entries) {
        const fs::path path = places.mesh(entry.scan);
        collection.names.push_back(entry.caption);
        collection.points.push_back(read_mesh(path).points);
        options.values.emplace_back(100.0 / bounding_box_diagonal(collection.points.back()) *
                                    read_vertex_scalar(path, "distance"));
    }
    options.value_high = 1.0;
    options.value_name = "distance to the scan, % of the diagonal";
    write_file_atomically(places.sheet(),
                          picture_svg(draw_collection(collection, options, session.progress())));
}

} // namespace shape::tools
