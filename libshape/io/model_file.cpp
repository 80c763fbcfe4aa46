// SPDX-License-Identifier: MIT

#include "libshape/io/model_file.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/io/hdf5_parts.h"

namespace shape {
namespace {

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

void check_model(const ShapeModel& model, const std::string& place)
{
    const Check check(place);
    check_mean(check, model.mean_edge_lengths, model.scale);
    check(is_orthonormal(model.mode_edge_lengths), "/modes/edge_lengths",
          "rows must be orthonormal");
    for (Eigen::Index k = 0; k < model.variances.size(); ++k)
        check(model.variances[k] >= 0.0 && (k == 0 || model.variances[k] <= model.variances[k - 1]),
              "/variances", "must be >= 0 and descend");
    check(model.total_variance >= (1.0 - 1e-9) * model.variances.sum(), "/total_variance",
          "must be at least the sum of /variances");
    check(model.sizes.size() > 0 && model.sizes.minCoeff() > 0.0, "/sizes", "must be > 0");
}

void check_difference(const DifferenceVector& difference, const std::string& place)
{
    const Check check(place);
    check_mean(check, difference.mean_edge_lengths, difference.scale);
    check(difference.from_size > 0.0, "/from_size", "must be > 0");
    check(difference.to_size > 0.0, "/to_size", "must be > 0");
}

/// A number as a matrix of one, which add_numbers() takes.
using Single = Eigen::Matrix<double, 1, 1>;

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

double read_number(const Hdf5File& file, const std::string& name)
{
    return file.numbers(name, {})(0, 0);
}

} // namespace

void write_model(const std::filesystem::path& path, const ShapeModel& model,
                 const std::optional<ModelOptions>& asked)
{
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
    add_base(content, model.topology, model.reference_points, model.scale);
    add_numbers(content, "/mean/edge_lengths", {edges}, model.mean_edge_lengths);
    add_numbers(content, "/mean/dihedral_angles", {edges}, model.mean_dihedral_angles);
    add_numbers(content, "/modes/edge_lengths", {modes, edges}, model.mode_edge_lengths);
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
    const ShapeModel model{
        .topology = topology,
        .reference_points = reference_points,
        .scale = read_scale(file),
        .mean_edge_lengths = file.numbers("/mean/edge_lengths", {edges}),
        .mean_dihedral_angles = file.numbers("/mean/dihedral_angles", {edges}),
        .mode_edge_lengths = file.numbers("/modes/edge_lengths", {modes, edges}),
        .mode_dihedral_angles = file.numbers("/modes/dihedral_angles", {modes, edges}),
        .variances = variances,
        .total_variance = read_number(file, "/total_variance"),
        .scores = file.numbers("/scores", {count, modes}),
        .sizes = file.numbers("/sizes", {count}),
        .names = names,
        .labels = read_labels(file, count),
    };
    check_model(model, file.path());
    return model;
}

void write_difference(const std::filesystem::path& path, const DifferenceVector& difference,
                      const std::optional<DifferenceOptions>& asked)
{
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
    const DifferenceVector difference{
        .topology = topology,
        .reference_points = reference_points,
        .scale = read_scale(file),
        .mean_edge_lengths = file.numbers("/mean/edge_lengths", {edges}),
        .mean_dihedral_angles = file.numbers("/mean/dihedral_angles", {edges}),
        .edge_lengths = file.numbers("/difference/edge_lengths", {edges}),
        .dihedral_angles = file.numbers("/difference/dihedral_angles", {edges}),
        .from_size = read_number(file, "/from_size"),
        .to_size = read_number(file, "/to_size"),
        .pairs = file.strings("/pairs", any_length),
    };
    check_difference(difference, file.path());
    return difference;
}

} // namespace shape
