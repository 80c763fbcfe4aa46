// SPDX-License-Identifier: MIT

#include <pybind11/pybind11.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/frame_embedder.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/gltf_file.h"
#include "libshape/io/label_doubts.h"
#include "libshape/io/label_file.h"
#include "libshape/io/mesh_write_options.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/oddities.h"
#include "libshape/model/shape_distances.h"
#include "libshape/synthetic/synthetic.h"
#include "tools/input/mesh_input.h"
#include "tools/input/path_arguments.h"
#include "tools/input/space_arguments.h"
#include "tools/python/handles.h"
#include "tools/python/jobs.h"

namespace shape::python {

using namespace internal;

Faces faces_of(const Integers& array)
{
    Faces faces(array.shape(0), 3);
    for (py::ssize_t i = 0; i < array.size(); ++i) {
        const std::int64_t vertex = array.data()[i];
        if (vertex < 0 || vertex > std::numeric_limits<int>::max())
            throw InvalidInput(join("F: row ", i / 3, " names vertex ", vertex));
        faces.data()[i] = static_cast<int>(vertex);
    }
    return faces;
}

Integers array_of_faces(const Faces& faces)
{
    Integers array({faces.rows(), Eigen::Index{3}});
    std::copy(faces.data(), faces.data() + faces.size(), array.mutable_data());
    return array;
}

py::dict to_python(const Labels& labels)
{
    py::dict result;
    for (const LabelColumn& column : labels) {
        py::tuple values(column.values.size());
        for (std::size_t i = 0; i < column.values.size(); ++i)
            values[i] = column.values[i].empty() ? py::object(py::none())
                                                 : py::object(py::str(column.values[i]));
        result[py::str(column.name)] = values;
    }
    return result;
}

namespace {

using CollectionPointer = std::shared_ptr<CollectionHandle>;

CollectionPointer handle_of(Collection collection)
{
    return std::make_shared<CollectionHandle>(CollectionHandle{std::move(collection)});
}

/// (collection, messages, warnings)
py::tuple read(std::vector<std::string> paths, const std::string& labels, bool triangulate,
               const py::object& callback)
{
    struct Said
    {
        Collection collection;
        std::vector<std::string> messages;
        std::vector<std::string> warnings;
    };
    tools::MeshInput input;
    input.paths = std::move(paths);
    input.labels = labels;
    input.triangulate = triangulate;
    Said said = run(
        [input](const Progress& progress) {
            std::vector<std::string> messages;
            std::vector<std::string> warnings;
            const tools::MeshNotices notices{
                .message = [&](const std::string& text) { messages.push_back(text); },
                .warn = [&](const std::string& text) { warnings.push_back(text); },
                .progress = progress};
            Collection collection = tools::read_meshes(notices, input);
            return Said{std::move(collection), std::move(messages), std::move(warnings)};
        },
        callback);
    return py::make_tuple(handle_of(std::move(said.collection)), said.messages, said.warnings);
}

/// (collection, warnings); copies of meshes are odd unless they may repeat.
py::tuple from_arrays(const std::vector<Doubles>& vertices, const Integers& faces,
                      const std::vector<std::string>& names,
                      const std::vector<std::pair<std::string, std::vector<std::string>>>& labels,
                      bool may_repeat)
{
    struct Made
    {
        Collection collection;
        std::vector<std::string> warnings;
    };
    std::vector<NamedMesh> meshes;
    const Faces all = faces_of(faces);
    for (std::size_t i = 0; i < vertices.size(); ++i)
        meshes.push_back({names.at(i), names.at(i), points_of(vertices[i]), all});
    Labels columns;
    for (const auto& [name, values] : labels) {
        columns.push_back({name, {}});
        for (const std::string& cell : values)
            columns.back().values.push_back(label_value(cell));
    }
    Made made = run([meshes, columns, may_repeat](const Progress&) {
        Collection collection = collect(meshes);
        collection.labels = columns;
        std::vector<std::string> warnings;
        if (const auto alike = tools::find_names_alike(collection.names, collection.names))
            warnings.push_back(alike->message);
        std::ranges::copy(doubts_about(columns), std::back_inserter(warnings));
        for (const Oddity& oddity : find_oddities(collection))
            if (!(may_repeat && oddity.kind == OddityKind::Copies))
                warnings.push_back(tools::advice_on(oddity));
        return Made{std::move(collection), std::move(warnings)};
    });
    return py::make_tuple(handle_of(std::move(made.collection)), made.warnings);
}

/// (values of the labels, rows of the table that were not asked for)
py::tuple read_labels(const std::string& path, const std::vector<std::string>& names)
{
    const LabelFile file = run([=](const Progress&) { return read_label_file(path, names); });
    return py::make_tuple(to_python(file.labels), file.unused);
}

/// Refuses a mesh whose faces are not those of another one.
void check_same_faces(const Doubles& points, const Integers& faces, const std::string& name,
                      const Doubles& known_points, const Integers& known_faces,
                      const std::string& known)
{
    const std::string difference = describe_correspondence_break(
        {known, known, points_of(known_points), faces_of(known_faces)},
        {name, name, points_of(points), faces_of(faces)});
    if (!difference.empty())
        throw InvalidInput(difference);
}

CollectionPointer choose(const CollectionPointer& handle, const std::vector<std::size_t>& meshes)
{
    return handle_of(subset(handle->collection, meshes));
}

/// Frames along the line through so many meshes, as the program takes them.
tools::Blends frames_of_line(int meshes, std::int64_t frames)
{
    tools::PathArguments arguments;
    arguments.options.frames = frames;
    return tools::blends_of(arguments, meshes);
}

/// A row of weights for each frame.
Doubles line_weights(int meshes, std::int64_t frames)
{
    const tools::Blends blends = frames_of_line(meshes, frames);
    RowMatrix rows(static_cast<Eigen::Index>(blends.weights.size()), meshes);
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
        rows.row(i) = blends.weights[to_size(i)].transpose();
    return array_of(std::move(rows));
}

/// Positions of every frame, and their reports; the first is placed as the first mesh is, each further
/// one of a path as the one before it, as `shape interpolate` does.
/// @param is_path  The weights are those of line_weights().
py::list interpolate(const CollectionPointer& handle, const std::vector<Doubles>& weights,
                     bool is_path, bool squared, const EmbeddingOptions& options,
                     const py::object& callback)
{
    tools::Blends blends;
    if (is_path)
        blends = frames_of_line(static_cast<int>(handle->collection.size()),
                                static_cast<std::int64_t>(weights.size()));
    else
        for (const Doubles& row : weights)
            blends.weights.push_back(vector_of(row));
    std::vector<Embedding> frames = run(
        [=](const Progress& progress) {
            const Collection& collection = handle->collection;
            const ShapeVectors vectors = shape_vectors(collection, Scale::None);
            const auto target = [&](const Eigen::VectorXd& at) {
                return blend(vectors, at, squared ? LengthBlend::Squared : LengthBlend::Plain);
            };
            std::optional<FramePath> along;
            if (is_path)
                along = FramePath{
                    {[&](double t) { return target(blends.weights_at(t)); }, blends.stations},
                    blends.places};
            const FrameEmbedder embedder(collection.topology, collection.points, options, along,
                                         progress);
            const std::size_t count = blends.weights.size();
            std::vector<Embedding> made;
            Points previous = collection.points.front();
            for (std::size_t i = 0; i < count; ++i) {
                progress("embedding", i, count);
                made.push_back(embedder.embed(i, target(blends.weights[i]), previous));
                if (is_path)
                    previous = made.back().points;
            }
            progress("embedding", count, count);
            return made;
        },
        callback);
    py::list result;
    for (Embedding& frame : frames)
        result.append(to_python(std::move(frame)));
    return result;
}

/// (matrix, warnings)
py::tuple distances(const CollectionPointer& handle, const SpaceOptions& space)
{
    const ShapeDistances found =
        run([=](const Progress&) { return shape_distances(handle->collection, space); });
    std::vector<std::string> warnings;
    if (const auto doubt = tools::doubt_about_alignment(found.space))
        warnings.push_back(*doubt);
    return py::make_tuple(array_of(RowMatrix(found.matrix)), warnings);
}

void write(const std::string& path, const Doubles& points, const Integers& faces, bool ascii,
           bool single, const std::vector<std::pair<std::string, Doubles>>& scalars,
           const std::string& quality, const py::object& colours, const std::string& template_file)
{
    MeshWriteOptions options{.ascii = ascii, .single_precision = single, .quality = quality};
    for (const auto& [name, values] : scalars)
        options.scalars.push_back({name, vector_of(values)});
    if (!colours.is_none()) {
        const auto array = colours.cast<py::array_t<std::uint8_t, py::array::c_style>>();
        options.colours = Eigen::Map<const VertexColours>(array.data(), array.shape(0), 3);
    }
    const Points positions = points_of(points);
    const Faces corners = faces_of(faces);
    run([=](const Progress&) mutable {
        const std::filesystem::path file = path;
        if (!template_file.empty())
            options.obj_template = std::make_shared<const ObjTemplate>(
                read_obj_template(template_file, file.parent_path()));
        write_mesh(file, positions, corners, mesh_format(file), options);
        return true;
    });
}

/// (edges, lengths, dihedral angles)
py::tuple measure(const Doubles& points, const Integers& faces)
{
    struct Measures
    {
        Topology topology;
        Eigen::VectorXd lengths;
        Eigen::VectorXd angles;
    };
    const Points positions = points_of(points);
    const Faces corners = faces_of(faces);
    Measures all = run([=](const Progress&) {
        if (!positions.allFinite())
            throw InvalidInput("mesh.V: has a coordinate that is not finite");
        Topology topology(corners, static_cast<int>(positions.rows()));
        Eigen::VectorXd lengths = edge_lengths(topology, positions);
        Eigen::VectorXd angles = dihedral_angles(topology, positions);
        return Measures{std::move(topology), std::move(lengths), std::move(angles)};
    });
    const Edges& edges = all.topology.edges();
    Integers ends({edges.rows(), Eigen::Index{2}});
    std::copy(edges.data(), edges.data() + edges.size(), ends.mutable_data());
    return py::make_tuple(ends, array_of(std::move(all.lengths)), array_of(std::move(all.angles)));
}

CollectionPointer synthetic(const std::string& name, int count, int vertices, std::uint64_t seed)
{
    return handle_of(run([=](const Progress&) {
        return make_synthetic(name, {.count = count, .vertices = vertices, .seed = seed});
    }));
}

/// (frames kept, error as a fraction of the diagonal)
py::tuple write_animation(const std::string& path, const std::vector<Doubles>& frames,
                          const Integers& faces, double frames_per_second, double tolerance)
{
    std::vector<Points> points;
    for (const Doubles& frame : frames)
        points.push_back(points_of(frame));
    const Faces corners = faces_of(faces);
    const GlbAnimation written = run([=](const Progress&) {
        return write_glb_animation(
            path, points, corners,
            {.tolerance = tolerance, .frames_per_second = frames_per_second});
    });
    return py::make_tuple(written.keyframes, written.error);
}

} // namespace

void add_collections(py::module_& module)
{
    py::class_<CollectionHandle, CollectionPointer>(module, "Collection")
        .def_property_readonly("names",
                               [](const CollectionHandle& c) { return c.collection.names; })
        .def_property_readonly(
            "labels", [](const CollectionHandle& c) { return to_python(c.collection.labels); })
        .def(
            "faces",
            [](const CollectionHandle& c) { return array_of_faces(c.collection.topology.faces()); })
        .def_property_readonly(
            "vertex_count",
            [](const CollectionHandle& c) { return c.collection.topology.vertex_count(); })
        .def("__len__", [](const CollectionHandle& c) { return c.collection.size(); })
        .def("points",
             [](const CollectionPointer& c, std::size_t i) {
                 const Points& points = c->collection.points.at(i);
                 return view(c, points.data(), {points.rows(), 3});
             })
        .def("subset", choose)
        .def("write", [](const CollectionPointer& c, const std::string& path) {
            run([=](const Progress&) {
                write_collection(path, c->collection);
                return true;
            });
        });
    module.def("read", read);
    module.def("from_arrays", from_arrays);
    module.def("read_labels", read_labels);
    module.def("check_same_faces", check_same_faces);
    module.def("interpolate", interpolate);
    module.def("distances", distances);
    module.def("write", write);
    module.def("measure", measure);
    module.def("synthetic", synthetic);
    module.def("write_animation", write_animation);
    module.def("line_weights", line_weights);
}

} // namespace shape::python
