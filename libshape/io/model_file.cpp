// SPDX-License-Identifier: MIT

#include "libshape/io/model_file.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/io/file_parts.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape {
using namespace internal;
namespace {

// The bounds below are not tuned: far above what rounding does to the values in question (1e-12 and less),
// so that files of other programs pass, and far below what a wrong or exchanged value does. Relative 1e-9
// where a value is a sum of others; 1e-6 where it comes of an eigenproblem; 1e-4 [rad] for angles, which
// multiply errors of lengths at slivers.

/// Throws InvalidInput about one value of what is written or read.
class Check
{
public:
    explicit Check(std::string place) : place_(std::move(place)) {}

    void operator()(bool holds, std::string_view name, std::string_view rule) const
    {
        if (!holds)
            throw InvalidInput(join(place_, ": ", name, ": ", rule));
    }

private:
    std::string place_;
};

/// Whether the rows are orthonormal: then M M^T r = r for every r. One random r finds any gap but
/// with probability 0, and costs K E where M M^T costs K^2 E.
bool is_orthonormal(const RowMatrix& rows)
{
    Random random(1);
    Eigen::VectorXd r(rows.rows());
    for (double& value : r)
        value = random.normal();
    const Eigen::VectorXd combined = rows.transpose() * r;
    return (rows * combined - r).norm() <= 1e-6 * r.norm();
}

void check_mean(const Check& check, const Eigen::VectorXd& lengths, Scale scale)
{
    check(lengths.size() > 0 && lengths.minCoeff() > 0.0, "/mean/edge_lengths", "must be > 0");
    check(scale == Scale::None || std::abs(lengths.sum() - 1.0) <= 1e-9, "/mean/edge_lengths",
          "must sum to 1, for attribute scale is 'unit'");
}

/// What the coordinates of a space are called in the groups /mean and /modes.
std::string coordinates_name(const ShapeSpace& space)
{
    if (std::holds_alternative<ProcrustesSpace>(space))
        return "points";
    return is_plain(space) ? "edge_lengths" : "coordinates";
}

void check_model(const ShapeModel& model, const std::string& place)
{
    const Check check(place);
    if (is_plain(model.space))
        check_mean(check, model.mean, scale_of(model.space));
    if (const EdgeSpace* edge = std::get_if<EdgeSpace>(&model.space)) {
        check((edge->length_factors.array() > 0.0).all(), "/space/length_factors", "must be > 0");
        check((edge->dihedral_factors.array() > 0.0).all(), "/space/dihedral_factors",
              "must be > 0");
        check((edge->position_factors.array() > 0.0).all(), "/space/position_factors",
              "must be > 0");
    }
    check(is_orthonormal(model.modes), "/modes/" + coordinates_name(model.space),
          "rows must be orthonormal");
    for (Eigen::Index k = 0; k < model.variances.size(); ++k)
        check(model.variances[k] >= 0.0 && (k == 0 || model.variances[k] <= model.variances[k - 1]),
              "/variances", "must be >= 0 and descend");
    check(model.total_variance >= (1.0 - 1e-9) * model.variances.sum(), "/total_variance",
          "must be at least the sum of /variances");
    // All modes of N meshes have all the variance.
    check(model.variances.size() < static_cast<Eigen::Index>(model.names.size()) - 1 ||
              model.total_variance <= (1.0 + 1e-5) * model.variances.sum(),
          "/total_variance", "must be the sum of /variances, which are all there are");
    check(model.sizes.size() > 0 && model.sizes.minCoeff() > 0.0, "/sizes", "must be > 0");
}

void check_difference(const DifferenceVector& difference, const std::string& place)
{
    const Check check(place);
    check_mean(check, difference.mean_edge_lengths, difference.scale);
    check(difference.from_size > 0.0, "/from_size", "must be > 0");
    check(difference.to_size > 0.0, "/to_size", "must be > 0");
    check(difference.scale == Scale::None || std::abs(difference.edge_lengths.sum()) <= 1e-9,
          "/difference/edge_lengths", "must sum to 0, as both means sum to 1");
}

/// A number as a matrix of one, which add_numbers() takes.
using Single = Eigen::Matrix<double, 1, 1>;

constexpr std::array<const char*, 3> length_names = {"plain", "squared", "log"};

/// Adds the attributes that name a space and what it took from its collection. The mean that meshes
/// are aligned with in Procrustes space is that of the model.
void add_space(Hdf5Content& content, const ShapeSpace& space)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    content.attributes.emplace_back("space", std::string(edge ? "edge" : "procrustes"));
    if (edge == nullptr || is_plain(space))
        return;
    content.attributes.emplace_back(
        "coordinates", std::string(length_names.at(static_cast<std::size_t>(edge->coordinates))));
    if (edge->length_factors.size() > 0)
        add_numbers(content, "/space/length_factors", {edge->length_factors.size()},
                    edge->length_factors);
    if (edge->dihedral_factors.size() > 0) {
        add_numbers(content, "/space/dihedral_factors", {edge->dihedral_factors.size()},
                    edge->dihedral_factors);
        add_numbers(content, "/space/branch_angles", {edge->branch_angles.size()},
                    edge->branch_angles);
    }
    if (edge->position_factors.size() > 0) {
        add_numbers(content, "/space/position_factors", {edge->position_factors.size()},
                    edge->position_factors);
        add_numbers(content, "/space/mean_positions", {edge->mean_positions.rows(), 3},
                    edge->mean_positions);
    }
}

EdgeSpace read_edge_space(const Hdf5File& file, const Topology& topology)
{
    const Eigen::Index edges = topology.edge_count();
    const Eigen::Index vertices = topology.vertex_count();
    EdgeSpace space{.scale = read_scale(file),
                    .coordinates = LengthCoordinates::Plain,
                    .length_factors = {},
                    .dihedral_factors = {},
                    .branch_angles = {},
                    .position_factors = {},
                    .mean_positions = {}};
    if (file.has_attribute("coordinates")) {
        const std::string name = file.text_attribute("coordinates");
        const auto found = std::find(length_names.begin(), length_names.end(), name);
        if (found == length_names.end())
            file.fail("attribute coordinates",
                      "is '" + name + "', must be 'plain', 'squared' or 'log'");
        space.coordinates = static_cast<LengthCoordinates>(found - length_names.begin());
    }
    if (file.has("/space/length_factors"))
        space.length_factors = file.numbers("/space/length_factors", {edges});
    if (file.has("/space/dihedral_factors")) {
        space.dihedral_factors = file.numbers("/space/dihedral_factors", {edges});
        space.branch_angles = file.numbers("/space/branch_angles", {edges});
    }
    if (file.has("/space/position_factors")) {
        space.position_factors = file.numbers("/space/position_factors", {vertices});
        space.mean_positions = file.numbers("/space/mean_positions", {vertices, 3});
    }
    return space;
}

/// The space of a model; files from before there was a choice have none and are of edge space.
ShapeSpace read_space(const Hdf5File& file, const Topology& topology)
{
    const std::string name = file.has_attribute("space") ? file.text_attribute("space") : "edge";
    if (name == "edge")
        return read_edge_space(file, topology);
    if (name != "procrustes")
        file.fail("attribute space", "is '" + name + "', must be 'edge' or 'procrustes'");
    return ProcrustesSpace{.scale = read_scale(file),
                           .mean = file.numbers("/mean/points", {topology.vertex_count(), 3})};
}

/// Extents of the coordinates of one mesh.
Extents coordinate_extents(const ShapeSpace& space, const Topology& topology)
{
    const EdgeSpace* edge = std::get_if<EdgeSpace>(&space);
    if (edge == nullptr)
        return {topology.vertex_count(), 3};
    return {topology.edge_count() * (edge->dihedral_factors.size() > 0 ? 2 : 1) +
            3 * edge->position_factors.size()};
}

Extents operator+(Extents a, const Extents& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

void add_base(Hdf5Content& content, const Topology& topology, const Points& reference_points,
              Scale scale)
{
    add_scale(content, scale);
    add_topology(content, topology);
    add_numbers(content, "/reference_points", {topology.vertex_count(), 3}, reference_points);
}

Points read_reference_points(const Hdf5File& file)
{
    return file.numbers("/reference_points", {any_length, 3});
}

/// Scores along a mode have mean 0 and its variance.
void check_scores(const Hdf5File& file, const ShapeModel& model)
{
    const auto count = static_cast<double>(model.scores.rows());
    const double unit = std::sqrt(model.variances.size() > 0 ? model.variances[0] : 0.0);
    for (Eigen::Index k = 0; k < model.scores.cols(); ++k) {
        const double mean = model.scores.col(k).mean();
        if (!(std::abs(mean) <= 1e-6 * unit))
            file.fail("/scores", join("column ", k, " has the mean ", mean, ", must have 0"));
        const double deviation =
            std::sqrt(model.scores.col(k).squaredNorm() / std::max(count - 1.0, 1.0));
        if (!(std::abs(deviation - std::sqrt(model.variances[k])) <= 1e-6 * unit))
            file.fail("/scores", join("column ", k, " has the standard deviation ", deviation,
                                      ", /variances give ", std::sqrt(model.variances[k])));
    }
}

/// The angles of a mesh that lies in the span of the modes are those of the model there, up to whole
/// turns.
void check_first_angles(const Hdf5File& file, const ShapeModel& model)
{
    const Eigen::VectorXd made =
        model.mean_dihedral_angles +
        model.mode_dihedral_angles.transpose() * model.scores.row(0).transpose();
    const Eigen::VectorXd angles = dihedral_angles(model.topology, model.reference_points);
    Eigen::Index edge = 0;
    const double gap = (made - angles).unaryExpr(&wrapped_angle).cwiseAbs().maxCoeff(&edge);
    if (!(gap <= 1e-4))
        file.fail("/modes/dihedral_angles",
                  join("with /mean/dihedral_angles and /scores they give ", made[edge], " at edge ",
                       edge, " of the first mesh, /reference_points give ", angles[edge]));
}

/// The reference is the first mesh: its size and scores follow from mean and modes, and where the
/// modes span it, its angles too.
void check_first_mesh(const Hdf5File& file, const ShapeModel& model)
{
    const Projection first =
        project(model, Collection{model.topology, {"first"}, {model.reference_points}, {}});
    if (!(std::abs(model.sizes[0] - first.sizes[0]) <= 1e-9 * first.sizes[0]))
        file.fail("/sizes",
                  join("value 0 is ", model.sizes[0], ", /reference_points give ", first.sizes[0]));
    const double unit = std::sqrt(model.variances[0]);
    Eigen::Index mode = 0;
    const double gap = (model.scores.row(0) - first.scores.row(0)).cwiseAbs().maxCoeff(&mode);
    if (!(gap <= 1e-6 * unit))
        file.fail("/scores",
                  join("value (0, ", mode, ") is ", model.scores(0, mode),
                       ", mean, modes and /reference_points give ", first.scores(0, mode)));
    // Within 1e-8 of a deviation the modes span it: what they leave out else is a part of a mode.
    if (has_companions(model.space) && first.residuals[0] <= 1e-8 * unit)
        check_first_angles(file, model);
}

double read_number(const Hdf5File& file, const std::string& name)
{
    return file.numbers(name, {})(0, 0);
}

} // namespace

void write_model(const std::filesystem::path& path, const ShapeModel& model,
                 const std::optional<ModelOptions>& asked)
{
    if (asked)
        check(*asked);
    check_model(model, "model");
    const Eigen::Index edges = model.topology.edge_count();
    const Eigen::Index modes = model.mode_count();
    const auto count = static_cast<Eigen::Index>(model.names.size());
    const Single total_variance(model.total_variance);
    Hdf5Content content = begin_content(FileKind::Model);
    if (asked) {
        content.attributes.emplace_back("asked_modes", std::int64_t{asked->modes});
        content.attributes.emplace_back("asked_variance", asked->variance);
    }
    add_base(content, model.topology, model.reference_points, scale_of(model.space));
    add_space(content, model.space);
    const std::string name = coordinates_name(model.space);
    const Extents extents = coordinate_extents(model.space, model.topology);
    add_numbers(content, "/mean/" + name, extents, model.mean);
    if (has_companions(model.space))
        add_numbers(content, "/mean/dihedral_angles", {edges}, model.mean_dihedral_angles);
    add_numbers(content, "/modes/" + name, Extents{modes} + extents, model.modes);
    if (has_companions(model.space))
        add_numbers(content, "/modes/dihedral_angles", {modes, edges}, model.mode_dihedral_angles);
    add_numbers(content, "/variances", {modes}, model.variances);
    add_numbers(content, "/total_variance", {}, total_variance);
    add_numbers(content, "/scores", {count, modes}, model.scores);
    add_numbers(content, "/sizes", {count}, model.sizes);
    add_names(content, count, model.names);
    add_labels(content, count, model.labels);
    write_hdf5(path, content);
}

ShapeModel read_model(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Model);
    const Points reference_points = read_reference_points(file);
    const Topology topology = read_topology(file, reference_points.rows());
    const Eigen::Index edges = topology.edge_count();
    const Eigen::VectorXd variances = file.numbers("/variances", {any_length});
    const Eigen::Index modes = variances.size();
    const std::vector<std::string> names = read_names(file, any_length);
    const auto count = static_cast<Eigen::Index>(names.size());
    const ShapeSpace space = read_space(file, topology);
    const bool companions = has_companions(space);
    const std::string name = coordinates_name(space);
    const Extents extents = coordinate_extents(space, topology);
    ShapeModel model{
        .topology = topology,
        .reference_points = reference_points,
        .space = space,
        .mean = file.numbers("/mean/" + name, extents).reshaped<Eigen::RowMajor>(),
        .mean_dihedral_angles =
            companions ? file.numbers("/mean/dihedral_angles", {edges}) : RowMatrix(0, 1),
        .modes = file.numbers("/modes/" + name, Extents{modes} + extents),
        .mode_dihedral_angles = companions ? file.numbers("/modes/dihedral_angles", {modes, edges})
                                           : RowMatrix(modes, 0),
        .variances = variances,
        .total_variance = read_number(file, "/total_variance"),
        .scores = file.numbers("/scores", {count, modes}),
        .sizes = file.numbers("/sizes", {count}),
        .names = names,
        .labels = read_labels(file, count),
    };
    check_model(model, file.path());
    if (companions) {
        check_boundary_angles(file, "/mean/dihedral_angles", topology,
                              model.mean_dihedral_angles.transpose());
        check_boundary_angles(file, "/modes/dihedral_angles", topology, model.mode_dihedral_angles);
    }
    check_scores(file, model);
    check_first_mesh(file, model);
    return model;
}

void write_difference(const std::filesystem::path& path, const DifferenceVector& difference,
                      const std::optional<DifferenceOptions>& asked)
{
    if (asked)
        check(*asked);
    check_difference(difference, "difference");
    const Eigen::Index edges = difference.topology.edge_count();
    const Single from_size(difference.from_size);
    const Single to_size(difference.to_size);
    Hdf5Content content = begin_content(FileKind::Difference);
    if (asked) {
        content.attributes.emplace_back("pair_by", asked->pair_by);
        content.attributes.emplace_back("from", asked->from_label + "=" + asked->from_value);
        content.attributes.emplace_back("to", asked->to_label + "=" + asked->to_value);
    }
    add_base(content, difference.topology, difference.reference_points, difference.scale);
    add_numbers(content, "/mean/edge_lengths", {edges}, difference.mean_edge_lengths);
    add_numbers(content, "/mean/dihedral_angles", {edges}, difference.mean_dihedral_angles);
    add_numbers(content, "/difference/edge_lengths", {edges}, difference.edge_lengths);
    add_numbers(content, "/difference/dihedral_angles", {edges}, difference.dihedral_angles);
    add_numbers(content, "/from_size", {}, from_size);
    add_numbers(content, "/to_size", {}, to_size);
    if (!difference.pairs.empty())
        add_strings(content, "/pairs", static_cast<Eigen::Index>(difference.pairs.size()),
                    difference.pairs);
    write_hdf5(path, content);
}

DifferenceVector read_difference(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Difference);
    const Points reference_points = read_reference_points(file);
    const Topology topology = read_topology(file, reference_points.rows());
    const Eigen::Index edges = topology.edge_count();
    DifferenceVector difference{
        .topology = topology,
        .reference_points = reference_points,
        .scale = read_scale(file),
        .mean_edge_lengths = file.numbers("/mean/edge_lengths", {edges}),
        .mean_dihedral_angles = file.numbers("/mean/dihedral_angles", {edges}),
        .edge_lengths = file.numbers("/difference/edge_lengths", {edges}),
        .dihedral_angles = file.numbers("/difference/dihedral_angles", {edges}),
        .from_size = read_number(file, "/from_size"),
        .to_size = read_number(file, "/to_size"),
        .pairs =
            file.has("/pairs") ? file.strings("/pairs", any_length) : std::vector<std::string>(),
    };
    check_difference(difference, file.path());
    check_boundary_angles(file, "/mean/dihedral_angles", topology,
                          difference.mean_dihedral_angles.transpose());
    check_boundary_angles(file, "/difference/dihedral_angles", topology,
                          difference.dihedral_angles.transpose());
    return difference;
}

} // namespace shape
