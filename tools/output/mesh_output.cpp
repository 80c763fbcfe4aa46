// SPDX-License-Identifier: MIT

#include "tools/output/mesh_output.h"

#include <unistd.h>

#include <algorithm>
#include <set>

#include "libshape/base/clean_up.h"
#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/report/colour_map.h"
#include "tools/output/frame_store.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

MeshFormat format_of(const fs::path& path)
{
    try {
        return mesh_format(path);
    } catch (const InvalidInput& error) {
        refuse_file(join("-o: ", error.what()));
    }
}

/// What a file system takes, of at most this many bytes: a long name is cut and ends in a hash of all
/// of it.
std::string shortened(const std::string& name, std::size_t most)
{
    if (name.size() <= most)
        return name;
    const std::string hash = hash_text(name.data(), name.size());
    return name.substr(0, most - 1 - hash.size()) + "-" + hash;
}

/// Names of files, one for each mesh: what a file name may not hold becomes '_', and names that are
/// the same then but for their case get a number.
std::vector<std::string> file_names(const std::vector<std::string>& names)
{
    constexpr std::size_t longest = 200;
    std::set<std::string> given;
    std::set<std::string> taken;
    std::vector<std::string> result;
    for (const std::string& name : names) {
        if (!given.insert(name).second)
            throw InvalidInput(join("the mesh name '", name,
                                    "' occurs twice; every output needs "
                                    "a name of its own"));
        std::string file = name;
        std::replace_if(
            file.begin(), file.end(),
            [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '/' || c == '\\'; }, '_');
        if (file.empty() || file.front() == '.')
            file.insert(file.begin(), '_');
        file = shortened(file, longest);
        const std::string stem = file;
        for (int number = 2; !taken.insert(lower_case(file)).second; ++number)
            file = join(stem, "_", number);
        result.push_back(file);
    }
    return result;
}

/// Dark blue to yellow; blue to red, with grey at 0, if there are both signs.
VertexColours vertex_colours(const Eigen::VectorXd& values)
{
    double low = values.minCoeff();
    double high = values.maxCoeff();
    const bool has_both_signs = low < 0.0 && high > 0.0;
    if (has_both_signs) {
        high = std::max(-low, high);
        low = -high;
    }
    VertexColours colours(values.size(), 3);
    for (Eigen::Index v = 0; v < values.size(); ++v) {
        const Colour colour =
            map_colour(has_both_signs ? ColourMap::Diverging : ColourMap::Sequential,
                       high > low ? (values[v] - low) / (high - low) : 0.0);
        colours.row(v) << colour.red, colour.green, colour.blue;
    }
    return colours;
}

/// A hidden name that no other process uses.
std::string staging_name(const std::string& name)
{
    return join(".", shortened(name, 200), ".", getpid(), ".tmp");
}

} // namespace

void add_mesh_format(CLI::App& command, MeshOutputArguments& arguments)
{
    command
        .add_option("--format", arguments.format,
                    "Format of the files in a directory (default: ply, binary with doubles)")
        ->check(CLI::IsMember({"obj", "ply", "off", "stl", "vtk", "vtp", "glb"}))
        ->option_text("obj|ply|off|stl|vtk|vtp|glb");
    command
        .add_flag("--ascii", arguments.ascii,
                  "Numbers as text in .ply, .stl, .vtk and .vtp; .obj and .off always are")
        ->group("Mesh files");
    command
        .add_flag("--float", arguments.single_precision,
                  "Single precision (float32) in .ply, .vtk and .vtp; .stl and .glb always are")
        ->group("Mesh files");
    command
        .add_option("--template", arguments.template_file,
                    "OBJ file of the same faces whose texture coordinates, materials and polygons\n"
                    ".obj meshes are written with; normals are computed anew where it has some")
        ->option_text("FILE.obj")
        ->group("Mesh files");
    command
        .add_flag("--colors{first}", arguments.colours,
                  "Colour meshes with values at their vertices (--residuals, --effects), as red,\n"
                  "green and blue, by the first of them or by NAME")
        ->option_text("[=NAME]")
        ->group("Mesh files");
}

CLI::Option* add_mesh_output(CLI::App& command, MeshOutputArguments& arguments)
{
    add_mesh_format(command, arguments);
    return command
        .add_option(
            "-o,--output", arguments.path,
            "One mesh: a file (.obj .ply .off .stl .vtk .vtp .glb) or a directory; several:\n"
            "a directory, or a .glb file for one animation.\n"
            "A missing directory is made, its parent must exist")
        ->required()
        ->option_text("PATH REQUIRED");
}

void add_animation_options(CLI::App& command, MeshOutputArguments& arguments)
{
    const GlbAnimationOptions standard;
    add_number(command, "--fps", arguments.frames_per_second,
               join("Frames per second of an animation (-o FILE.glb), in [1e-6, 1e6] (default: ",
                    standard.frames_per_second, ")"),
               Sign::Positive);
    add_number(command, "--glb-tolerance", arguments.glb_tolerance,
               join("Largest error of a coordinate of an animation, > 0, as a fraction of the\n"
                    "diagonal of the first frame's bounding box (default: ",
                    standard.tolerance,
                    "). Frames that linear\ninterpolation gives back that well are left out"),
               Sign::Positive);
}

MeshOutput::MeshOutput(const Session& session, const MeshOutputArguments& arguments,
                       const std::vector<std::string>& names, const std::vector<fs::path>& inputs,
                       const std::vector<std::string>& further_files)
    : session_(session),
      inputs_(inputs),
      write_options_{.ascii = arguments.ascii, .single_precision = arguments.single_precision},
      colours_(arguments.colours),
      mesh_count_(names.size())
{
    const fs::path path = arguments.path;
    if (!arguments.template_file.empty())
        inputs_.emplace_back(arguments.template_file);
    if (names_a_file(path)) {
        format_ = format_of(path);
        is_animation_ = format_ == MeshFormat::Glb && names.size() > 1;
        if ((names.size() > 1 && !is_animation_) || !further_files.empty())
            refuse_file(join("-o: ", names.size() + further_files.size(), " files come out; '",
                             path.string(), "' names one file, give a directory"));
        if (!arguments.format.empty() && mesh_format("x." + arguments.format) != format_)
            throw UsageError(join("--format ", arguments.format, " contradicts the ending of '",
                                  path.string(), "'"));
        prepare_animation(arguments, names.size());
        check_output(session, path, inputs_);
        paths_ = {path};
        prepare_writing(arguments, path.parent_path());
        return;
    }
    prepare_animation(arguments, names.size());
    format_ = arguments.format.empty() ? MeshFormat::Ply : mesh_format("x." + arguments.format);
    takes_directory_ = true;
    directory_ = path.has_filename() ? path : path.parent_path();
    prepare_writing(arguments, directory_);
    for (const std::string& name : file_names(names))
        paths_.push_back(directory_ / (name + file_ending(format_)));
    for (const std::string& file : further_files)
        paths_.push_back(directory_ / file);
    if (fs::is_directory(directory_)) {
        check_paths(0);
        staging_ = directory_ / staging_name("shape");
    } else {
        check_output(session, directory_, inputs_);
        makes_directory_ = true;
        staging_ = directory_.parent_path() / staging_name(directory_.filename().string());
    }
}

MeshOutput::~MeshOutput()
{
    clean_up([&] {
        std::error_code ignored; // The run has failed already; its error is the one to report.
        if (!staging_.empty())
            fs::remove_all(staging_, ignored);
    });
}

void MeshOutput::check_paths(std::size_t first) const
{
    for (std::size_t i = first; i < paths_.size(); ++i)
        check_output(session_, paths_[i], inputs_);
}

void MeshOutput::prepare_animation(const MeshOutputArguments& arguments, std::size_t meshes)
{
    if (is_animation_)
        frames_.reserve(meshes);
    else if (arguments.frames_per_second || arguments.glb_tolerance)
        throw UsageError(
            "--fps and --glb-tolerance are for an animation: several meshes and a "
            ".glb file as -o");
    const double rate = arguments.frames_per_second.value_or(25.0);
    if (rate < 1e-6 || rate > 1e6)
        throw UsageError(join("--fps: ", rate, " is out of range [1e-6, 1e6]"));
    const GlbAnimationOptions standard;
    animation_options_ = {
        .tolerance = arguments.glb_tolerance.value_or(standard.tolerance),
        .frames_per_second = arguments.frames_per_second.value_or(standard.frames_per_second)};
}

void MeshOutput::prepare_writing(const MeshOutputArguments& arguments, const fs::path& folder)
{
    const bool is_text = format_ == MeshFormat::Obj || format_ == MeshFormat::Off;
    const bool is_glb = format_ == MeshFormat::Glb;
    if (arguments.ascii && is_glb)
        throw UsageError("--ascii is for .ply, .stl, .vtk and .vtp; .obj and .off are text always");
    if (arguments.single_precision && is_text)
        throw UsageError("--float is for .ply, .vtk and .vtp; .stl and .glb are so always");
    if (arguments.template_file.empty())
        return;
    if (format_ != MeshFormat::Obj)
        throw UsageError("--template is for .obj meshes; add --format obj, or let -o end in .obj");
    write_options_.obj_template =
        std::make_shared<const ObjTemplate>(read_obj_template(arguments.template_file, folder));
}

std::string MeshOutput::scalar_ending() const
{
    const bool holds_scalars = format_ == MeshFormat::Vtk || format_ == MeshFormat::Vtp;
    return file_ending(holds_scalars ? format_ : MeshFormat::Ply);
}

void write_with_colours(const fs::path& path, const Points& points, const Faces& faces,
                        std::vector<VertexScalar> scalars, const std::string& colours,
                        MeshWriteOptions options)
{
    std::size_t chosen = 0;
    if (!colours.empty() && colours != "first") {
        const auto found = std::ranges::find(scalars, colours, &VertexScalar::name);
        if (found == scalars.end()) {
            std::string names;
            for (const VertexScalar& scalar : scalars)
                names += " " + scalar.name;
            throw UsageError(join("--colors: no value '", colours, "' in ",
                                  path.filename().string(), "; there are:", names));
        }
        chosen = to_size(found - scalars.begin());
    }
    const MeshFormat format = mesh_format(path);
    if (format == MeshFormat::Ply)
        options.quality = scalars[chosen].name;
    if (!colours.empty())
        options.colours = vertex_colours(scalars[chosen].values);
    options.scalars = std::move(scalars);
    write_mesh(path, points, faces, format, options);
}

void MeshOutput::write_scalars(const fs::path& path, const Points& points, const Faces& faces,
                               std::vector<VertexScalar> scalars) const
{
    MeshWriteOptions options = write_options_;
    options.obj_template = nullptr; // never an OBJ file
    write_with_colours(path, points, faces, std::move(scalars), colours_, options);
}

void MeshOutput::add_companions(const std::string& folder, const std::string& suffix)
{
    if (is_animation_)
        throw UsageError(join("no file *", suffix,
                              " can stand beside the meshes of an animation; "
                              "give a directory as -o"));
    if (staging_.empty()) { // one mesh as a file
        directory_ = paths_.front().has_parent_path() ? paths_.front().parent_path() : ".";
        staging_ = directory_ / staging_name("shape");
    }
    first_companion_ = paths_.size();
    for (std::size_t i = 0; i < mesh_count_; ++i)
        paths_.push_back(directory_ / folder / (paths_[i].stem().string() + suffix));
    if (fs::is_directory(directory_ / folder))
        check_paths(first_companion_);
    else if (fs::exists(fs::symlink_status(directory_ / folder)))
        throw FileError(join((directory_ / folder).string(), ": exists and is not a directory"));
    else if (!session_.force)
        for (std::size_t i = first_companion_; i < paths_.size(); ++i)
            session_.free_places->add(paths_[i]);
}

void MeshOutput::write(std::size_t index, const Points& points, const Faces& faces)
{
    if (is_animation_) {
        frames_.push_back(points);
        faces_ = faces;
        return;
    }
    if (!staging_.empty())
        fs::create_directory(staging_);
    const fs::path path = paths_.at(index);
    write_mesh(staging_.empty() ? path : staging_ / path.filename(), points, faces, format_,
               write_options_);
}

fs::path MeshOutput::staged(const std::string& further_file) const
{
    return staging_ / further_file;
}

fs::path MeshOutput::staged_companion(std::size_t index) const
{
    const fs::path& path = paths_.at(first_companion_ + index);
    const fs::path folder = staging_ / path.parent_path().filename();
    fs::create_directories(folder);
    return folder / path.filename();
}

void MeshOutput::commit()
{
    if (is_animation_)
        animation_ = write_glb_animation(paths_.front(), frames_, faces_, animation_options_);
    if (!colours_.empty() && first_companion_ == 0)
        session_.warn("--colors: these meshes have no values at their vertices; add --residuals");
    if (staging_.empty())
        return;
    // Where another run has made the directory meanwhile, this one may write into it with --force alone.
    if (fs::is_directory(directory_) && (!makes_directory_ || session_.force)) {
        for (std::size_t i = 0; i < paths_.size(); ++i) {
            const fs::path& path = paths_[i];
            const bool is_companion = first_companion_ > 0 && i >= first_companion_;
            if (is_companion)
                fs::create_directories(path.parent_path());
            move_into_place(is_companion
                                ? staging_ / path.parent_path().filename() / path.filename()
                                : staging_ / path.filename(),
                            path);
        }
        if (takes_directory_)
            note_other_meshes();
    } else {
        move_into_place(staging_, directory_);
    }
}

/// Frames of a longer run, say, that would be taken for this one's.
void MeshOutput::note_other_meshes() const
{
    const std::set<fs::path> own(paths_.begin(), paths_.end());
    std::set<std::string> others;
    for (const auto& entry : fs::directory_iterator(directory_))
        if (entry.path().extension() == file_ending(format_) && !own.contains(entry.path()))
            others.insert(entry.path().filename().string());
    if (!others.empty())
        session_.warn(join(directory_.string(), ": holds ",
                           counted(others.size(), "other mesh", "other meshes"), ", such as ",
                           *others.begin(), "; who reads the directory takes them too"));
}

std::vector<std::string> MeshOutput::paths() const
{
    return {paths_.begin(), paths_.end()};
}

} // namespace shape::tools
