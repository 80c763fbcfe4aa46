// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/percent.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/embedder.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/label_file.h"
#include "libshape/io/landmark_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/oddities.h"
#include "libshape/model/model_prior.h"
#include "libshape/model/unlike_meshes.h"
#include "libshape/registration/fit_verdict.h"
#include "libshape/registration/landmark_checks.h"
#include "libshape/registration/landmark_units.h"
#include "libshape/registration/prior_fit.h"
#include "libshape/registration/rigid_start.h"
#include "libshape/registration/scan_fit.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/fit_report.h"
#include "tools/output/output_rules.h"
#include "tools/output/shard.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct Arguments
{
    std::string pattern; ///< The template.
    MeshInput scans;
    std::string output;
    std::vector<std::string> landmarks;
    FitOptions fit;
    std::string boundaries;
    std::int64_t rounds = 0;
    bool no_search = false;
    bool keep_failed = false;
    bool resume = false;
    Shard shard;
};

struct AllLandmarks
{
    std::vector<Landmark> marks;
    std::vector<Landmark> missing; ///< As LandmarkFile has them.
    fs::path of_template; ///< The first file that has some of the template; empty if none has.
};

/// The name of a mesh as landmarks have it: without outer blanks, accents composed.
std::string name_in_tables(const fs::path& mesh)
{
    return label_name(mesh.stem().string());
}

/// The landmarks of all files; those without a scan's name belong to the mesh that the file is named
/// after, or to the only scan.
AllLandmarks read_all_landmarks(const Arguments& arguments, const std::vector<fs::path>& scans)
{
    const std::string pattern = name_in_tables(arguments.pattern);
    std::vector<fs::path> files;
    for (const std::string& path : arguments.landmarks) {
        if (!fs::is_directory(path)) {
            files.emplace_back(path);
            continue;
        }
        std::set<fs::path> sorted;
        for (const auto& entry : fs::directory_iterator(path))
            if (is_landmark_file(entry.path()))
                sorted.insert(entry.path());
        if (sorted.empty())
            throw InvalidInput(join(path, ": no file of landmarks (.csv, .fcsv, .mrk.json)"));
        files.insert(files.end(), sorted.begin(), sorted.end());
    }
    std::set<std::string> stems{pattern};
    for (const fs::path& scan : scans)
        stems.insert(name_in_tables(scan));
    AllLandmarks all;
    for (const fs::path& file : files) {
        const std::string file_name = file.filename().string();
        const std::string stem = label_name(file_name.substr(0, file_name.find('.')));
        const auto name_scan = [&](Landmark& landmark) {
            if (!landmark.scan.empty())
                return;
            if (stems.count(stem) > 0)
                landmark.scan = stem;
            else if (scans.size() == 1)
                landmark.scan = name_in_tables(scans.front());
            else
                throw InvalidInput(join(file.string(),
                                        ": says of no landmark which scan it is "
                                        "on; add a column 'scan', or name the "
                                        "file after the scan"));
        };
        LandmarkFile read = read_landmarks(file);
        for (Landmark& landmark : read.landmarks) {
            name_scan(landmark);
            if (all.of_template.empty() && landmark.scan == pattern)
                all.of_template = file;
            all.marks.push_back(std::move(landmark));
        }
        for (Landmark& landmark : read.missing) {
            name_scan(landmark);
            all.missing.push_back(std::move(landmark));
        }
    }
    return all;
}

/// What is fitted: a mesh, or the mean of a model with what the model expects.
struct Pattern
{
    std::string name; ///< As its landmarks have it.
    Topology topology;
    Points points;
    std::optional<ShapeModel> model;
};

Pattern read_pattern(const Arguments& arguments)
{
    const fs::path path = arguments.pattern;
    if (is_collection_file(path)) {
        if (file_kind(path) != FileKind::Model)
            throw InvalidInput(join(path.string(),
                                    ": TEMPLATE is one mesh file, or a model that "
                                    "`shape stats` has made"));
        ShapeModel model = read_model(path);
        if (!std::holds_alternative<EdgeSpace>(model.space))
            throw InvalidInput(join(path.string(),
                                    ": is a model of positions; fitting needs one of edge "
                                    "lengths (`shape stats` without --space procrustes)"));
        const Embedder embedder(model.topology, std::vector<Points>{model.reference_points});
        const ShapePoint mean = std::get<ShapePoint>(
            model_point(model, Eigen::VectorXd::Zero(model.mode_count()), model.mean_size()));
        Points points = embedder.embed(mean).points; // about the origin
        points.rowwise() += model.reference_points.colwise().mean();
        return {name_in_tables(path), model.topology, std::move(points), std::move(model)};
    }
    NamedMesh mesh = read_mesh(path, {.triangulate = arguments.scans.triangulate});
    try {
        Topology topology(mesh.faces, static_cast<int>(mesh.points.rows()));
        return {name_in_tables(path), std::move(topology), std::move(mesh.points), std::nullopt};
    } catch (const InvalidInput& error) {
        throw InvalidInput(join(path.string(), ": ", error.what()));
    }
}

/// Where a landmark is on the template: at the place that its row there gives, or its vertex.
class TemplatePlaces
{
public:
    TemplatePlaces(const AllLandmarks& landmarks, const Pattern& pattern)
        : landmarks_(landmarks), pattern_(pattern)
    {
    }
    /// Nothing if none is given.
    [[nodiscard]] std::optional<Eigen::Vector3d> find(const Landmark& on_scan) const
    {
        if (on_scan.vertex >= 0)
            return at_vertex(on_scan);
        for (const Landmark& mark : landmarks_.marks)
            if (mark.name == on_scan.name && mark.scan == pattern_.name)
                return mark.position;
        for (const Landmark& mark : landmarks_.missing)
            if (mark.name == on_scan.name && mark.scan == pattern_.name && mark.vertex >= 0)
                return at_vertex(mark);
        return std::nullopt;
    }
    /// Its vertex, or -1.
    [[nodiscard]] int vertex_of(const Landmark& on_scan) const
    {
        if (on_scan.vertex >= 0)
            return on_scan.vertex;
        for (const Landmark& mark : landmarks_.missing)
            if (mark.name == on_scan.name && mark.scan == pattern_.name)
                return mark.vertex;
        return -1;
    }
    /// Whether the template's row says that the landmark has no place there.
    [[nodiscard]] bool is_missing(const Landmark& on_scan) const
    {
        return std::ranges::any_of(landmarks_.missing, [&](const Landmark& mark) {
            return mark.name == on_scan.name && mark.scan == pattern_.name;
        });
    }

private:
    [[nodiscard]] Eigen::Vector3d at_vertex(const Landmark& mark) const
    {
        const Points& points = pattern_.points;
        if (mark.vertex >= points.rows())
            throw InvalidInput(join("landmark '", mark.name, "' of ", mark.scan, ": vertex ",
                                    mark.vertex, " is not among the template's ", points.rows(),
                                    ", counted from 0"));
        return points.row(mark.vertex).transpose();
    }

    const AllLandmarks& landmarks_;
    const Pattern& pattern_;
};

/// Those that a scan and the template share, by name.
LandmarkPairs pairs_of(const AllLandmarks& landmarks, const std::string& scan,
                       const Pattern& pattern)
{
    const TemplatePlaces on_template(landmarks, pattern);
    LandmarkPairs pairs;
    std::vector<Eigen::Vector3d> here, there;
    for (const Landmark& mark : landmarks.marks) {
        if (mark.scan != scan || scan == pattern.name)
            continue;
        const std::optional<Eigen::Vector3d> place = on_template.find(mark);
        if (!place && on_template.is_missing(mark))
            continue;
        if (!place)
            throw InvalidInput(join("landmark '", mark.name, "' of ", scan,
                                    " is not on the template: give a row with scan '", pattern.name,
                                    "', or a vertex"));
        if (std::find(pairs.names.begin(), pairs.names.end(), mark.name) != pairs.names.end())
            throw InvalidInput(join("landmark '", mark.name, "' of ", scan, " occurs twice"));
        pairs.names.push_back(mark.name);
        here.push_back(*place);
        there.push_back(mark.position);
    }
    pairs.on_template.resize(std::ssize(here), 3);
    pairs.on_scan.resize(std::ssize(here), 3);
    for (std::size_t i = 0; i < here.size(); ++i) {
        pairs.on_template.row(static_cast<Eigen::Index>(i)) = here[i];
        pairs.on_scan.row(static_cast<Eigen::Index>(i)) = there[i];
    }
    return pairs;
}

/// By how much the best similarity misses landmarks, over their spread.
double missed_by_similarity(const Points& here, const Points& there)
{
    return (landmark_start(here, there)(here) - there).norm() / spread(there);
}

/// Whether vertices that landmarks name are counted from 1, as R counts them: with 1 less, four and more of them miss those of a
/// scan by a third of what they miss as they are, or less.
std::optional<std::string> doubt_of_first_vertex(const AllLandmarks& landmarks,
                                                 const std::string& scan, const Pattern& pattern)
{
    constexpr double least_missed = 0.05, explained = 1.0 / 3.0; // as mistaken_landmarks()
    const TemplatePlaces on_template(landmarks, pattern);
    std::vector<int> vertices;
    std::vector<Eigen::Index> before;
    std::vector<Eigen::Vector3d> places;
    for (const Landmark& mark : landmarks.marks)
        if (const int vertex = on_template.vertex_of(mark);
            mark.scan == scan && vertex > 0 && vertex < pattern.points.rows()) {
            vertices.push_back(vertex);
            before.push_back(vertex - 1);
            places.push_back(mark.position);
        }
    if (places.size() < 4)
        return std::nullopt;
    Points there(std::ssize(places), 3);
    for (std::size_t i = 0; i < places.size(); ++i)
        there.row(static_cast<Eigen::Index>(i)) = places[i];
    const double as_given = missed_by_similarity(pattern.points(vertices, Eigen::all), there);
    const double less = missed_by_similarity(pattern.points(before, Eigen::all), there);
    if (!(as_given >= least_missed && less <= explained * as_given))
        return std::nullopt;
    return join("landmarks: vertices of the template are counted from 0. Those of ", scan,
                " miss by ", percent(as_given), " of their spread as they are, by ", percent(less),
                " with 1 taken from each: do they come from a program that counts from 1 (R)?");
}

/// The scans of all parts of the run, and what of the arguments says how.
struct Task
{
    Arguments arguments;
    std::vector<fs::path> all_scans;
    std::vector<fs::path> scans; ///< Those of this part.
    std::vector<std::string> names;
};

/// Of all parts of the run, whose fits become one collection.
void check_scan_names(const Session& session, const std::vector<fs::path>& scans)
{
    std::vector<std::string> names;
    std::vector<std::string> paths;
    std::set<std::string> taken;
    for (const fs::path& scan : scans) {
        if (is_collection_file(scan))
            throw InvalidInput(join(scan.string(),
                                    ": a collection has its correspondence; SCANS "
                                    "are mesh files"));
        names.push_back(scan.stem().string());
        paths.push_back(scan.string());
        if (!taken.insert(names.back()).second)
            throw InvalidInput(join(scan.string(), ": two scans are named '", names.back(),
                                    "'; rename one of them"));
    }
    if (const auto alike = find_names_alike(names, paths))
        session.warn(alike->message);
}

/// What the arguments mean, their rules checked.
Task task_of(const Session& session, const Arguments& given)
{
    Task task{given, {}, {}, {}};
    Arguments& arguments = task.arguments;
    if (!arguments.boundaries.empty())
        arguments.fit.boundaries = split(arguments.boundaries, ',');
    arguments.fit.search_start = !arguments.no_search;
    if (!arguments.fit.boundaries.empty() && arguments.landmarks.empty())
        throw UsageError("--boundary names landmarks; give --landmarks");
    note_passed_over(notices_of(session), arguments.scans);
    task.all_scans = mesh_files(arguments.scans);
    for (const std::size_t i : arguments.shard.own(task.all_scans.size()))
        task.scans.push_back(task.all_scans[i]);
    if (arguments.shard.is_given()) {
        if (arguments.rounds > 0)
            throw UsageError(
                "--rounds compares all scans with each other: it and --shard or mpirun exclude "
                "each other");
        if (has_ending(arguments.output, ".h5"))
            throw UsageError(
                "--shard and mpirun need a directory as -o; `shape collect` makes a collection of "
                "what `shape merge` has put together");
        if (!arguments.resume)
            check_merged_output(arguments.shard, given.output);
        arguments.output = arguments.shard.directory(arguments.output).string() + "/";
    }
    check_scan_names(session, task.all_scans);
    for (const fs::path& scan : task.scans)
        task.names.push_back(scan.stem().string());
    return task;
}

/// Those that a later run must share to go on with this one.
Json settings_of(const Arguments& arguments, const Topology& topology)
{
    return {{"template", arguments.pattern},
            {"vertices", topology.vertex_count()},
            {"landmarks", arguments.landmarks},
            {"landmark_tolerance", arguments.fit.landmark_tolerance},
            {"smoothness", arguments.fit.smoothness},
            {"growth_smoothness", arguments.fit.growth_smoothness},
            {"boundaries", arguments.fit.boundaries},
            {"search", arguments.fit.search_start},
            {"rounds", arguments.rounds},
            {"keep_failed", arguments.keep_failed}};
}

/// Fits scan after scan, then the group in rounds; each result is written as soon as it is there.
class FitRun
{
public:
    FitRun(const Session& session, const Arguments& given)
        : session_(session),
          task_(task_of(session, given)),
          output_(given.output),
          landmarks_(read_all_landmarks(arguments_, task_.scans)),
          pattern_(read_pattern(arguments_)),
          fits_(task_.scans.size())
    {
        if (pattern_.model && arguments_.rounds > 0)
            throw UsageError(
                "--rounds makes a model of the fits of a template; a model is there already");
        if (pattern_.model)
            prior_ = prior_of(*pattern_.model);
        check_template_landmarks();
        fitter_.emplace(topology_, pattern_.points, arguments_.fit);
        std::vector<fs::path> inputs = task_.scans;
        inputs.emplace_back(arguments_.pattern);
        places_ = fit_places(
            session, arguments_.output,
            {.scans = names_, .scores = pattern_.model.has_value(), .resume = arguments_.resume},
            inputs);
        if (!arguments_.landmarks.empty()) {
            note_missing_landmarks();
            warn_of_scans_without_landmarks();
            warn_of_first_vertex();
        }
        settings_ = settings_of(arguments_, topology_);
        if (arguments_.resume) {
            const Json earlier = earlier_fit_report(places_, settings_);
            earlier_rows_ = earlier["scans"];
            rounds_ = earlier["rounds"];
        }
    }

    /// As ScanFitter::fit() does, which knows no file.
    void check_template_landmarks() const
    {
        std::vector<std::string> names;
        std::vector<Eigen::Vector3d> places;
        for (const Landmark& mark : landmarks_.marks)
            if (mark.scan == pattern_.name) {
                names.push_back(mark.name);
                places.push_back(mark.position);
            }
        Points points(std::ssize(places), 3);
        for (std::size_t i = 0; i < places.size(); ++i)
            points.row(static_cast<Eigen::Index>(i)) = places[i];
        if (points.rows() == 0)
            return;
        const double within = landmark_off * bounding_box_diagonal(pattern_.points);
        try {
            check_not_zero(names, points, pattern_.points, "the template");
            check_not_far(names, points, pattern_.points, "the template");
            if (const auto said = other_unit_of(points, Surface(pattern_.points, topology_.faces()),
                                                within, "the template"))
                throw InvalidInput(*said);
        } catch (const InvalidInput& error) {
            throw InvalidInput(join(landmarks_.of_template.string(), ": ", error.what()));
        }
    }

    /// Those for which no vertex of the template stands.
    void note_missing_landmarks() const
    {
        std::vector<std::string> names;
        for (const Landmark& mark : landmarks_.missing)
            if (mark.scan != pattern_.name || mark.vertex < 0)
                names.push_back(join("'", mark.name, "' of ", mark.scan));
        if (!names.empty())
            session_.message(join(counted(names.size(), "landmark"),
                                  names.size() == 1 ? " has" : " have", " no coordinates and ",
                                  names.size() == 1 ? "is" : "are", " passed over, first ",
                                  names.front()));
    }

    void warn_of_first_vertex() const
    {
        for (const fs::path& scan : task_.scans)
            if (const auto doubt =
                    doubt_of_first_vertex(landmarks_, name_in_tables(scan), pattern_)) {
                session_.warn(*doubt);
                return;
            }
    }

    /// They are fitted all the same, with those names of the table that may be theirs, spelt otherwise.
    void warn_of_scans_without_landmarks() const
    {
        std::set<std::string> marked;
        for (const Landmark& mark : landmarks_.marks)
            marked.insert(mark.scan);
        std::vector<std::size_t> bare;
        for (std::size_t i = 0; i < names_.size(); ++i)
            if (marked.erase(name_in_tables(task_.scans[i])) == 0)
                bare.push_back(i);
        if (bare.empty())
            return;
        marked.erase(pattern_.name);
        const std::vector<std::string> unused(marked.begin(), marked.end());
        std::vector<std::size_t> all(unused.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        session_.warn(
            join(bare.size() == 1 ? "a scan has" : "scans have",
                 " no landmarks: ", list_names(names_, bare),
                 unused.empty() ? "" : join("; landmarks of no scan: ", list_names(unused, all))));
    }

    void run()
    {
        const Progress progress = session_.progress();
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (progress)
                progress("fit", i, names_.size());
            if (!is_done(i))
                fit(i);
        }
        if (progress)
            progress("fit", names_.size(), names_.size());
        if (std::ssize(rounds_) < arguments_.rounds)
            run_rounds();
        write_fit_report(places_, settings_, rows_, rounds_);
        if (pattern_.model)
            write_fit_scores(places_, rows_, pattern_.model->mode_count());
        if (fitted_ > 0)
            draw_fit_sheet(session_, places_, topology_, rows_);
        if (fitted_ > 0 && !places_.collection.empty())
            write_members();
        if (arguments_.shard.is_given())
            write_shard();
        conclude();
    }

private:
    /// Whether an earlier run has fitted this scan; then its row is taken over.
    bool is_done(std::size_t i)
    {
        const auto row =
            std::find_if(earlier_rows_.begin(), earlier_rows_.end(),
                         [&](const Json& each) { return each.value("scan", "") == names_[i]; });
        if (row == earlier_rows_.end())
            return false;
        const bool is_there = fs::exists(places_.mesh(names_[i]));
        if (!is_there && row->value("status", "") != "failed")
            return false;
        fitted_ += is_there ? 1 : 0;
        rows_.push_back(*row);
        return true;
    }

    [[nodiscard]] std::pair<Scan, LandmarkPairs> load(std::size_t i) const
    {
        const NamedMesh raw = read_mesh(task_.scans[i], {.triangulate = true});
        return {clean_scan(raw.points, raw.faces),
                pairs_of(landmarks_, name_in_tables(task_.scans[i]), pattern_)};
    }

    void fit(std::size_t i)
    {
        try {
            ScanFit fit = fit_scan(i);
            if (fit.status != FitStatus::Failed || arguments_.keep_failed) {
                write_fit(places_, names_[i], topology_, fit);
                ++fitted_;
            }
            if (arguments_.rounds > 0) // else nobody asks for it again
                fits_[i] = std::move(fit);
        } catch (const InvalidInput& error) {
            if (task_.all_scans.size() == 1) {
                const std::string said = error.what();
                const std::string path = task_.scans[i].string();
                throw InvalidInput(said.starts_with(path) ? said : join(path, ": ", said));
            }
            rows_.push_back(fit_failure(names_[i], error.what()));
        }
        const Json& row = rows_.back();
        std::string line = join(names_[i], ": ", row["status"].get<std::string>());
        for (const auto& reason : row["reasons"])
            line += "; " + reason.get<std::string>();
        session_.message(line);
        write_fit_report(places_, settings_, rows_, rounds_);
    }

    /// The fit, whose figures become a row.
    ScanFit fit_scan(std::size_t i)
    {
        const auto [scan, marks] = load(i);
        if (!prior_) {
            ScanFit fit = fitter_->fit(scan, marks);
            rows_.push_back(fit_figures(names_[i], fit, scan.ignored));
            return fit;
        }
        PriorFit held = fit_by_prior(*fitter_, topology_, *prior_, scan, marks);
        Json row = fit_figures(names_[i], held.fit, scan.ignored);
        const Eigen::VectorXd scores =
            held.expected.scores.cwiseProduct(pattern_.model->variances.cwiseSqrt());
        row["scores"] = std::vector<double>(scores.begin(), scores.end());
        row["model_size"] = held.expected.point.edge_lengths.sum();
        row["model_residual_rms"] = held.expected.residual;
        rows_.push_back(std::move(row));
        return std::move(held.fit);
    }

    /// Fits the group again until its rounds are over or the fits move no more; writes what came out.
    void run_rounds()
    {
        std::vector<ScanFit> group;
        std::vector<std::size_t> members;
        for (std::size_t i = 0; i < fits_.size(); ++i) {
            if (!fits_[i] && fs::exists(places_.mesh(names_[i])) && rows_[i].contains("scale"))
                fits_[i] = read_fit(places_, rows_[i]);
            if (!fits_[i] || fits_[i]->status == FitStatus::Failed)
                continue;
            members.push_back(i);
            group.push_back(std::move(*fits_[i]));
        }
        const auto member = [&](std::size_t k) { return load(members[k]); };
        rounds_ = Json::array();
        constexpr double settled =
            0.002; // of the mean edge: fits themselves err by thirty times as much
        for (std::int64_t round = 1; round <= arguments_.rounds; ++round) {
            const GroupRound done =
                fit_group_again(*fitter_, topology_, member, group, session_.progress());
            rounds_.push_back(
                {{"fits", done.fits}, {"change", done.change}, {"unexpected", done.unexpected}});
            session_.message(join("round ", round, ": edges of ",
                                  counted(to_size(done.fits), "fit"), " changed by ",
                                  100.0 * done.change, " %, were ", 100.0 * done.unexpected,
                                  " % from what the others expect (RMS)"));
            if (done.change < settled)
                break;
        }
        while (std::ssize(rounds_) < arguments_.rounds) // settled: --resume has nothing left to do
            rounds_.push_back(rounds_.back());
        for (std::size_t k = 0; k < members.size(); ++k) {
            const std::size_t i = members[k];
            rows_[i] = fit_figures(names_[i], group[k], rows_[i]["ignored"]);
            if (group[k].status != FitStatus::Failed || arguments_.keep_failed)
                write_fit(places_, names_[i], topology_, group[k]);
            else
                fs::remove(places_.mesh(names_[i]));
        }
    }

    void write_members() const
    {
        std::vector<NamedMesh> members;
        for (const std::string& scan : names_)
            if (fs::exists(places_.mesh(scan)))
                members.push_back(read_mesh(places_.mesh(scan)));
        write_collection(places_.collection, collect(std::move(members)));
    }

    void write_shard() const
    {
        std::vector<std::string> files;
        for (const std::string& scan : names_)
            if (fs::exists(places_.mesh(scan)))
                files.push_back(places_.mesh(scan).filename().string());
        Json all = settings_;
        for (const fs::path& scan : task_.all_scans)
            all["scans"].push_back(scan.string());
        write_shard_manifest(places_.directory, arguments_.shard, task_.all_scans.size(), all,
                             files);
        merge_shards_of_ranks(session_, output_);
    }

    /// Where the report is, if it is kept: the folder of what goes to standard output is gone when the run is over.
    [[nodiscard]] std::string where_it_says_why() const
    {
        return goes_to_standard_output() ? "no report is kept with `-o -`, name a file for one"
                                         : join(places_.table().string(), " says why");
    }
    [[nodiscard]] bool goes_to_standard_output() const { return session_.readable(output_) == "-"; }

    /// A landmark in the wrong place of the template shows in every scan alike.
    void warn_of_doubted_template_landmarks() const
    {
        constexpr std::size_t least = 3; // one or two may be slips of their own
        std::map<std::string, std::size_t> doubted, of_fits;
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (!rows_[i].contains("doubted_landmarks"))
                continue;
            for (const Json& landmark : rows_[i]["doubted_landmarks"])
                ++doubted[landmark["landmark"].get<std::string>()];
            const std::string scan = name_in_tables(task_.scans[i]);
            for (const Landmark& mark : landmarks_.marks)
                if (mark.scan == scan)
                    ++of_fits[mark.name];
        }
        for (const auto& [name, count] : doubted)
            if (count >= least && 2 * count > of_fits[name])
                session_.warn(join("landmark '", name, "' is doubted in ", count, " of ",
                                   of_fits[name], " scans; is its place on the template, ",
                                   pattern_.name, ", the wrong one?"));
    }

    /// Scans may be in any unit; a model of which size is a part does not see it, though.
    void warn_of_other_sizes() const
    {
        if (!pattern_.model || scale_of(pattern_.model->space) == Scale::Unit)
            return;
        const KnownMeshes known = known_meshes(*pattern_.model);
        std::vector<std::string> names;
        std::vector<double> odd;
        for (const Json& row : rows_)
            if (row.contains("model_size")) {
                names.push_back(row["scan"]);
                odd.push_back(odd_size(known, row["model_size"]));
            }
        RowMatrix marks = RowMatrix::Zero(std::ssize(odd), 2);
        marks.col(1) = Eigen::Map<const Eigen::VectorXd>(odd.data(), std::ssize(odd));
        warn_of_unlike(session_, names, marks,
                       {.others = join("the meshes of ", arguments_.pattern),
                        .mirrored = {},
                        .size = "Size is part of the model's shapes (--scale none), and scores are "
                                "those of the scan brought to the model's size: export all in one "
                                "unit"});
    }

    void conclude() const
    {
        warn_of_other_sizes();
        warn_of_doubted_template_landmarks();
        const auto count = [&](const char* status) {
            return std::count_if(rows_.begin(), rows_.end(),
                                 [&](const Json& row) { return row["status"] == status; });
        };
        session_.message(join(counted(names_.size(), "scan"), ": ", count("good"), " good, ",
                              count("check"), " to check, ", count("failed"), " failed; ",
                              where_it_says_why(),
                              fitted_ > 0 && !goes_to_standard_output()
                                  ? join(", ", places_.sheet().string(), " shows them")
                                  : ""));
        std::vector<std::string> outputs;
        if (fitted_ > 0 && !places_.collection.empty())
            outputs.push_back(places_.collection.string());
        outputs.push_back(places_.directory.string());
        session_.print_figures({{"outputs", outputs},
                                {"good", count("good")},
                                {"check", count("check")},
                                {"failed", count("failed")},
                                {"settings", settings_},
                                {"rounds", rounds_},
                                {"scans", rows_}});
        if (fitted_ == 0)
            throw NumericalError(join("no scan could be fitted; ", where_it_says_why(),
                                      " (--keep-failed writes the meshes all the same)"));
    }

    const Session& session_;
    Task task_;
    std::string output_; ///< Of all parts together.
    const Arguments& arguments_ = task_.arguments;
    const std::vector<std::string>& names_ = task_.names;
    AllLandmarks landmarks_;
    Pattern pattern_;
    const Topology& topology_ = pattern_.topology;
    std::optional<ShapePrior> prior_;
    std::optional<ScanFitter> fitter_;
    FitPlaces places_;
    Json settings_;
    Json earlier_rows_ = Json::array();
    Json rounds_ = Json::array();
    Json rows_ = Json::array();
    std::vector<std::optional<ScanFit>> fits_;
    std::size_t fitted_ = 0;
};

} // namespace

Run set_up_fit(CLI::App& command)
{
    command.description(
        "Fit a template to raw scans of any triangulation: meshes with the template's vertices\n"
        "and faces, each on its scan, in the scan's place and unit; a report and a picture say\n"
        "which to look at. Scans may have holes, noise, several parts, any pose in space.\n"
        "A model in the place of the template gives its scores too (scores.csv), and what a scan\n"
        "does not show as the model expects it.");
    command.footer(
        "Example:\n  shape fit template.ply scans/ -o fitted/ --landmarks marks.csv\n"
        "  shape stats fitted/ -o model.h5");
    const auto arguments = std::make_shared<Arguments>();
    command
        .add_option(
            "TEMPLATE", arguments->pattern,
            "Mesh whose vertices and faces all fits get: one connected surface; or a model (.h5)")
        ->required();
    add_mesh_input(command, arguments->scans, "SCANS");
    command
        .add_option("-o,--output", arguments->output,
                    "Directory for the meshes and the report, or collection (.h5), whose report\n"
                    "goes into the folder NAME_fit beside it")
        ->required();
    command
        .add_option(
            "--landmarks", arguments->landmarks,
            "CSV (scan,name,x,y,z; the template is a scan too, or a column vertex),\n"
            ".mrk.json or .fcsv of 3D Slicer named after the meshes, or a directory of such")
        ->allow_extra_args(false)
        ->option_text("FILE ...");
    add_number(command, "--landmark-tolerance", arguments->fit.landmark_tolerance,
               "How far landmarks may be missed [length of the scan] (default: 0, exactly)");
    command
        .add_option(
            "--boundary", arguments->boundaries,
            "Landmarks, separated by commas, at boundary loops that correspond from end to\n"
            "end (default: loops near each other; the template's longest may end early)")
        ->option_text("NAME,NAME");
    add_number(command, "--smoothness", arguments->fit.smoothness,
               "Weight of dihedral angles beside lengths, > 0 (default: 4)", Sign::Positive);
    add_number(command, "--growth-smoothness", arguments->fit.growth_smoothness,
               "Weight that lets neighbours grow alike, > 0 (default: 50)", Sign::Positive);
    add_integer(command, "--rounds", arguments->rounds,
                "Fit all again so often, each held to what the others' fits expect of it, so that\n"
                "vertices slide less along the surface; four fits at least (default: 0)",
                0, 100);
    command.add_flag("--no-search", arguments->no_search,
                     "The template lies on the scans already: start there");
    command.add_flag("--keep-failed", arguments->keep_failed,
                     "Write meshes of failed fits too, and take them into the collection");
    command.add_flag("--resume", arguments->resume,
                     "Go on with an interrupted run: scans in its report are not fitted again");
    add_shard(command, arguments->shard);
    return [arguments](const Session& session) { FitRun(session, *arguments).run(); };
}

} // namespace shape::tools
