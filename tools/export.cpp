// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/resized.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/statismo_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/model/linearised_model.h"
#include "tools/commands.h"
#include "tools/output/embedding_run.h"
#include "tools/output/frame_store.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

enum class Client
{
    Statismo,
    ShapeWorks,
    SlicerMorph,
    Csv,
};

struct Arguments
{
    std::string model;
    std::string output;
    Client client = Client::Statismo;
    std::int64_t modes = 0;
};

/// What goes to other programs: the model as linear in positions, and its meshes.
struct Exported
{
    const ShapeModel& model;
    LinearisedModel linear;
    std::vector<Points> meshes; ///< N, laid onto the mean.
};

/// A mesh from the scores of each of the model's meshes.
std::vector<Points> make_meshes(const Session& session, const ShapeModel& model, const Points& mean)
{
    const Embedder embedder(model.topology, {model.reference_points}, {});
    const Progress progress = session.progress();
    const bool is_scaled = scale_of(model.space) == Scale::Unit;
    std::vector<Points> meshes;
    for (std::size_t i = 0; i < model.names.size(); ++i) {
        progress("embedding", i, model.names.size());
        const auto row = static_cast<Eigen::Index>(i);
        const DecodedShape shape =
            model_point(model, model.scores.row(row), model.mean_size()); // as `generate`
        const Points points = resized(embedder.embed(shape), model.topology, shape,
                                      is_scaled ? model.sizes[row] / model.mean_size() : 1.0)
                                  .points;
        meshes.push_back(best_rigid_motion(points, mean)(points));
    }
    progress("embedding", model.names.size(), model.names.size());
    return meshes;
}

/// Names as file names take them.
std::string file_stem(std::size_t index)
{
    return numbered_name("mesh", index);
}

Table score_table(const Exported& exported, const std::string& first, const std::string& prefix)
{
    Table table{{first}, {}};
    for (Eigen::Index k = 0; k < exported.linear.scores.cols(); ++k)
        table.columns.push_back(join(prefix, k + 1));
    for (std::size_t i = 0; i < exported.model.names.size(); ++i) {
        std::vector<std::string> row{exported.model.names[i]};
        for (const double score : exported.linear.scores.row(static_cast<Eigen::Index>(i)))
            row.push_back(print_number(score));
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// One row a vertex of each mesh: what R makes an array of p x k x n from.
void write_csv(const fs::path& folder, const Exported& exported)
{
    Table landmarks{{"mesh", "vertex", "x", "y", "z"}, {}};
    for (std::size_t i = 0; i < exported.meshes.size(); ++i)
        for (Eigen::Index v = 0; v < exported.meshes[i].rows(); ++v) {
            const auto point = exported.meshes[i].row(v);
            landmarks.rows.push_back({exported.model.names[i], join(v + 1), print_number(point[0]),
                                      print_number(point[1]), print_number(point[2])});
        }
    write_table(folder / "landmarks.csv", landmarks);
    Table faces{{"a", "b", "c"}, {}};
    for (const auto& face : exported.model.topology.faces().rowwise())
        faces.rows.push_back({join(face[0] + 1), join(face[1] + 1), join(face[2] + 1)});
    write_table(folder / "faces.csv", faces);
    Table labels{{"mesh", "size"}, {}};
    for (const LabelColumn& column : exported.model.labels)
        labels.columns.push_back(column.name);
    check_columns(labels);
    for (std::size_t i = 0; i < exported.model.names.size(); ++i) {
        std::vector<std::string> row{
            exported.model.names[i],
            print_number(exported.model.sizes[static_cast<Eigen::Index>(i)])};
        for (const LabelColumn& column : exported.model.labels)
            row.push_back(column.values[i]);
        labels.rows.push_back(std::move(row));
    }
    write_table(folder / "labels.csv", labels);
    write_table(folder / "scores.csv", score_table(exported, "mesh", "pc"));
    write_file_atomically(
        folder / "read.R",
        "# Reads what `shape export --to csv` wrote, from the folder that it lies in:\n"
        "# A, p x k x n, as geomorph (gpagen, procD.lm) and Morpho (procSym) take it; faces, "
        "counted\n"
        "# from 1, as mesh3d$it takes them, transposed; labels and position_scores (of --to csv, "
        "not those\n"
        "# of `shape project`), one row per mesh.\n"
        "landmarks <- read.csv(\"landmarks.csv\", colClasses = c(mesh = \"character\"), na.strings "
        "= \"\")\n"
        "n <- unique(landmarks$mesh)\n"
        "p <- max(landmarks$vertex)\n"
        "A <- aperm(array(t(as.matrix(landmarks[, c(\"x\", \"y\", \"z\")])), c(3, p, length(n))),\n"
        "           c(2, 1, 3))\n"
        "dimnames(A) <- list(NULL, c(\"x\", \"y\", \"z\"), n)\n"
        "faces <- as.matrix(read.csv(\"faces.csv\"))\n"
        "labels <- read.csv(\"labels.csv\", colClasses = \"character\", na.strings = \"\")\n"
        "for (column in names(labels)[-1])  # numbers are numbers, all else text, what is missing "
        "NA\n"
        "  if (!anyNA(suppressWarnings(as.numeric(na.omit(labels[[column]])))))\n"
        "    labels[[column]] <- as.numeric(labels[[column]])\n"
        "position_scores <- read.csv(\"scores.csv\", colClasses = c(mesh = \"character\"),\n"
        "                            na.strings = \"\")\n");
}

/// A project of ShapeWorks Studio: the vertices of each mesh are its particles.
void write_shapeworks(const fs::path& folder, const Exported& exported)
{
    Json subjects = Json::array();
    for (const char* part : {"meshes", "particles"})
        fs::create_directory(folder / part);
    for (std::size_t i = 0; i < exported.meshes.size(); ++i) {
        const Points& points = exported.meshes[i];
        const std::string mesh = join("meshes/", file_stem(i), ".vtk");
        const std::string particles = join("particles/", file_stem(i), ".particles");
        write_mesh(folder / mesh, points, exported.model.topology.faces(), MeshFormat::Vtk);
        std::string text;
        for (const auto& point : points.rowwise())
            text += print_number(point[0]) + " " + print_number(point[1]) + " " +
                    print_number(point[2]) + "\n";
        write_file_atomically(folder / particles, text);
        Json subject{{"name", exported.model.names[i]},
                     {"shape_1", mesh},
                     {"groomed_1", mesh},
                     {"alignment_1", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"},
                     {"local_particles_1", particles},
                     {"world_particles_1", particles}};
        for (const LabelColumn& label : exported.model.labels)
            subject["group_" + label.name] = label.values[i];
        subjects.push_back(std::move(subject));
    }
    const Json project{{"data", subjects}, {"project", {{"version", "2"}}}};
    write_file_atomically(folder / "model.swproj", project.dump(4) + "\n");
}

/// The tables of SlicerMorph's generalised Procrustes analysis.
void write_slicermorph(const fs::path& folder, const Exported& exported)
{
    const Points& mean = exported.linear.mean;
    const auto landmark_columns = [&](Table& table) {
        for (Eigen::Index v = 0; v < mean.rows(); ++v)
            for (const char axis : {'X', 'Y', 'Z'})
                table.columns.push_back(join("LM ", v + 1, "_", axis));
    };
    write_table(folder / "pcScores.csv", score_table(exported, "Sample_name", "PC "));
    Table data{{"Sample_name", "proc_dist", "centroid"}, {}};
    landmark_columns(data);
    const bool is_scaled = scale_of(exported.model.space) == Scale::Unit;
    for (std::size_t i = 0; i < exported.meshes.size(); ++i) {
        const double size = (exported.meshes[i].rowwise() - centroid(exported.meshes[i])).norm();
        const double factor = is_scaled ? exported.model.mean_size() /
                                              exported.model.sizes[static_cast<Eigen::Index>(i)]
                                        : 1.0;
        Points points = factor * exported.meshes[i];
        if (is_scaled) // it lay on the mean as it was
            points = best_rigid_motion(points, mean)(points);
        std::vector<std::string> row{exported.model.names[i], print_number((points - mean).norm()),
                                     print_number(size)};
        for (const double value : points.reshaped<Eigen::RowMajor>())
            row.push_back(print_number(value));
        data.rows.push_back(std::move(row));
    }
    write_table(folder / "outputData.csv", data);
    // Tables whose first column has no name, or whose columns have none, which write_table() refuses.
    std::string shape = ",X,Y,Z\n";
    for (Eigen::Index v = 0; v < mean.rows(); ++v)
        shape += join("LM ", v + 1, ",", print_number(mean(v, 0)), ",", print_number(mean(v, 1)),
                      ",", print_number(mean(v, 2)), "\n");
    write_file_atomically(folder / "meanShape.csv", shape);
    std::string vectors;
    std::string values;
    for (Eigen::Index k = 0; k < exported.linear.variances.size(); ++k) {
        vectors += join(",PC ", k + 1);
        values += join("PC ", k + 1, ",", print_number(exported.linear.variances[k]), "\n");
    }
    vectors += "\n";
    for (Eigen::Index row = 0; row < exported.linear.basis.rows(); ++row) {
        vectors += join("LM ", row / 3 + 1, "_", "XYZ"[row % 3]);
        for (const double value : exported.linear.basis.row(row))
            vectors += "," + print_number(value);
        vectors += "\n";
    }
    write_file_atomically(folder / "eigenvector.csv", vectors);
    write_file_atomically(folder / "eigenvalues.csv", values);

    const Json log{{"InputPath", "."},
                   {"OutputPath", "."},
                   {"Files", exported.model.names},
                   {"LMFormat", ".mrk.json"},
                   {"NumberLM", mean.rows()},
                   {"ExcludedLM", Json::array()},
                   {"Boas", !is_scaled}, // whether sizes are kept
                   {"MeanShape", "meanShape.csv"},
                   {"Eigenvalues", "eigenvalues.csv"},
                   {"Eigenvectors", "eigenvector.csv"},
                   {"OutputData", "outputData.csv"},
                   {"PCScores", "pcScores.csv"},
                   {"SemiLandmarks", Json::array()},
                   {"Covariates", ""},
                   {"Note", join("made by libshape: the landmarks are all vertices",
                                 exported.linear.is_exact
                                     ? ""
                                     : "; scores, eigenvalues and eigenvectors are of positions "
                                       "linearised at the mean of a model of edge lengths")}};
    write_file_atomically(folder / "analysis.json", Json{{"GPALog", {log}}}.dump(4) + "\n");
}

/// Writes a new folder, which appears as a whole, or into a folder that is there, where files replace those of
/// the same names and nothing else is touched.
void write_folder(const Session& session, const fs::path& folder, const fs::path& model,
                  const std::function<void(const fs::path&)>& write)
{
    const bool is_new = !fs::exists(folder) || FreePlaces::contain(folder);
    fs::path staging = is_new ? folder : folder / "export";
    staging += ".unfinished";
    const DirectoryLock lock(staging); // of two runs that write one folder, one
    for (const fs::directory_entry& left : fs::directory_iterator(staging))
        fs::remove_all(left.path());
    try {
        write(staging);
        throw_if_stop_requested();
        if (is_new) {
            move_into_place(staging, folder);
            return;
        }
        const auto all_files = fs::recursive_directory_iterator(staging);
        std::vector<fs::path> files;
        for (const fs::directory_entry& entry : all_files)
            if (entry.is_regular_file())
                files.push_back(entry.path().lexically_relative(staging));
        std::ranges::sort(files);
        for (const fs::path& file : files) {
            const fs::path target = folder / file;
            if (fs::is_directory(target.parent_path()))
                check_output(session, target, {model});
            else if (!session.force)
                session.free_places->add(target);
        }
        for (const fs::path& file : files) {
            fs::create_directories((folder / file).parent_path());
            move_into_place(staging / file, folder / file);
        }
        fs::remove_all(staging);
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(staging, ignored);
        throw;
    }
}

/// @return The folder, without a slash at its end.
fs::path check_folder(const Session& session, const fs::path& output)
{
    if (has_ending(output, ".h5")) // what `-` stands for too
        refuse_file(join("-o: '", output.string(),
                         "' is a file; all but --to statismo write a folder: name that"));
    fs::path folder = output.has_filename() ? output : output.parent_path();
    if (!fs::is_directory(folder)) {
        if (fs::exists(fs::symlink_status(folder)))
            throw FileError(join(folder.string(), ": exists and is not a folder; name another"));
        check_output(session, folder, {});
        return folder;
    }
    if (!session.force && !fs::is_empty(folder))
        throw FileError(join(folder.string(),
                             ": exists and is not empty; --force writes into it, over files of the "
                             "same names"));
    check_output(session, folder / "export.unfinished.txt", {}); // whether files can be made there
    return folder;
}

void run(const Session& session, const Arguments& arguments)
{
    const bool is_file = arguments.client == Client::Statismo;
    fs::path folder;
    if (is_file) {
        check_ending("-o", arguments.output, ".h5");
        check_output(session, arguments.output, {arguments.model});
    } else {
        folder = check_folder(session, arguments.output);
    }
    const ShapeModel model = read_model(arguments.model);
    if (arguments.modes > model.mode_count())
        throw InvalidInput(join("--modes: ", arguments.modes, " is out of range, ", arguments.model,
                                " has ", counted(model.mode_count(), "mode")));
    Exported exported{
        model, linearise(model, static_cast<int>(arguments.modes), {}, session.progress()), {}};
    if (is_file) {
        write_statismo(arguments.output, model.topology, exported.linear, model.names);
    } else {
        exported.meshes = make_meshes(session, model, exported.linear.mean);
        write_folder(session, folder, arguments.model, [&](const fs::path& staging) {
            if (arguments.client == Client::Csv)
                write_csv(staging, exported);
            else if (arguments.client == Client::ShapeWorks)
                write_shapeworks(staging, exported);
            else
                write_slicermorph(staging, exported);
        });
    }
    const bool is_linear = exported.linear.is_exact;
    session.message(join(arguments.output, ": ", model.names.size(), " meshes, ",
                         counted(exported.linear.variances.size(), "mode"),
                         is_linear ? ""
                                   : " of positions linearised at the mean: near it they are "
                                     "those of the model, far from it they are not"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"meshes", model.names.size()},
                           {"modes", exported.linear.variances.size()},
                           {"linearised", !is_linear}});
}

} // namespace

Run set_up_export(CLI::App& command)
{
    command.description(
        "Write a model for other programs: Statismo and Scalismo, ShapeWorks, SlicerMorph, or as\n"
        "tables for R. They know models that are linear in positions; modes of edge lengths are\n"
        "linearised at the mean for them. docs/ecosystem.md says what each file holds.");
    command.footer(
        "Examples:\n  shape export model.h5 --to statismo -o statismo.h5\n"
        "  shape export model.h5 --to csv -o tables/");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_choice(command, "--to", arguments->client,
               "statismo: HDF5 of Statismo 0.9, for Scalismo too; shapeworks: a project\n"
               "(.swproj), its meshes and particles; slicermorph: pcScores, outputData, meanShape\n"
               "and analysis.json; csv: landmarks.csv and the lines of R that read it (read.R)",
               {{"statismo", Client::Statismo},
                {"shapeworks", Client::ShapeWorks},
                {"slicermorph", Client::SlicerMorph},
                {"csv", Client::Csv}})
        ->required();
    command
        .add_option(
            "-o,--output", arguments->output,
            "File (.h5) for statismo, else a folder; where it is not there its parent must be")
        ->required()
        ->option_text("PATH REQUIRED");
    add_integer(command, "--modes", arguments->modes,
                "Number of leading modes, [1, number of modes] (default: all)", 1,
                std::numeric_limits<int>::max());
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
