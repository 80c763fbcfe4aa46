// SPDX-License-Identifier: MIT

#include "libshape/explore/model_block.h"

#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {
namespace {

using Eigen::Index;

constexpr std::uint64_t magic = 0x316b636f6c425348; // "HSBlock1"

template <class Rows>
void write_rows(const Rows& rows, ByteWriter& to)
{
    to.number(static_cast<std::uint32_t>(rows.rows()));
    to.number(static_cast<std::uint32_t>(rows.cols()));
    to.array(rows);
}

template <class Rows>
Rows read_rows(ByteReader& from)
{
    const auto rows = from.number<std::uint32_t>();
    const auto columns = from.number<std::uint32_t>();
    const auto values = from.array<typename Rows::Scalar>();
    if (values.size() != static_cast<std::uint64_t>(rows) * columns)
        throw InvalidInput(
            join("model block: ", values.size(), " numbers for ", rows, " rows of ", columns));
    return Eigen::Map<const Rows>(values.data(), static_cast<Index>(rows),
                                  static_cast<Index>(columns));
}

Eigen::VectorXd read_vector(ByteReader& from)
{
    const std::vector<double> values = from.array<double>();
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(values.size()));
}

template <class Matrix>
Matrix read_triples(ByteReader& from)
{
    const auto values = from.array<typename Matrix::Scalar>();
    if (values.size() % 3 != 0)
        throw InvalidInput("model block: a list of triples has another size");
    return Eigen::Map<const Matrix>(values.data(), static_cast<Index>(values.size() / 3), 3);
}

void write_space(const ShapeSpace& space, ByteWriter& to)
{
    const EdgeSpace* const edge = std::get_if<EdgeSpace>(&space);
    to.number(static_cast<std::uint32_t>(edge != nullptr ? 0 : 1));
    to.number(static_cast<std::uint32_t>(scale_of(space)));
    to.number(
        static_cast<std::uint32_t>(edge != nullptr ? edge->coordinates : LengthCoordinates::Plain));
    to.array(edge != nullptr ? edge->length_factors : Eigen::VectorXd());
    to.array(edge != nullptr ? edge->dihedral_factors : Eigen::VectorXd());
    to.array(edge != nullptr ? edge->position_factors : Eigen::VectorXd());
}

ShapeSpace read_space(ByteReader& from, Index vertices)
{
    const auto kind = from.number<std::uint32_t>();
    const auto scale = static_cast<Scale>(from.number<std::uint32_t>());
    const auto coordinates = static_cast<LengthCoordinates>(from.number<std::uint32_t>());
    Eigen::VectorXd length_factors = read_vector(from);
    Eigen::VectorXd dihedral_factors = read_vector(from);
    Eigen::VectorXd position_factors = read_vector(from);
    if (kind == 1)
        return ProcrustesSpace{.scale = scale, .mean = Points::Zero(vertices, 3)};
    return EdgeSpace{.scale = scale,
                     .coordinates = coordinates,
                     .length_factors = std::move(length_factors),
                     .dihedral_factors = std::move(dihedral_factors),
                     .position_factors = std::move(position_factors)};
}

} // namespace

std::vector<unsigned char> write_block(const ModelBlock& block)
{
    ByteWriter to;
    to.number(magic);
    to.array(block.topology.faces());
    to.array(block.reference_points);
    write_space(block.space, to);
    to.array(block.mean);
    to.array(block.mean_dihedral_angles);
    write_rows(block.modes, to);
    write_rows(block.mode_dihedral_angles, to);
    write_rows(block.directions.edge_lengths, to);
    write_rows(block.directions.dihedral_angles, to);
    to.number(block.smoothness);
    to.number(static_cast<std::uint32_t>(block.factor.size()));
    for (const SinglePrecisionSolve& factor : block.factor)
        factor.write(to);
    to.array(block.linear.mean);
    write_rows(block.linear.modes, to);
    write_rows(block.linear.directions, to);
    to.number(block.linear.size);
    return to.bytes();
}

ModelBlock read_block(std::span<const unsigned char> bytes)
{
    ByteReader from(bytes);
    if (from.number<std::uint64_t>() != magic)
        throw InvalidInput("model block: it does not begin as one");
    const auto faces = read_triples<Faces>(from);
    auto reference = read_triples<Points>(from);
    Topology topology(faces, static_cast<int>(reference.rows()));
    ShapeSpace space = read_space(from, reference.rows());
    ModelBlock block{.topology = std::move(topology),
                     .reference_points = std::move(reference),
                     .space = std::move(space),
                     .mean = read_vector(from),
                     .mean_dihedral_angles = read_vector(from),
                     .modes = read_rows<RowMatrix>(from),
                     .mode_dihedral_angles = read_rows<RowMatrix>(from),
                     .directions = {.edge_lengths = read_rows<RowMatrix>(from),
                                    .dihedral_angles = read_rows<RowMatrix>(from)},
                     .smoothness = from.number<double>(),
                     .factor = {},
                     .linear = {}};
    if (block.modes.cols() != block.mean.size() ||
        block.mode_dihedral_angles.rows() != block.modes.rows() ||
        block.mode_dihedral_angles.cols() != block.mean_dihedral_angles.size())
        throw InvalidInput("model block: the modes do not fit the mean");
    for (auto left = from.number<std::uint32_t>(); left > 0; --left)
        block.factor.emplace_back(from);
    block.linear = {.mean = read_triples<Points>(from),
                    .modes = read_rows<FloatRows>(from),
                    .directions = read_rows<FloatRows>(from),
                    .size = from.number<double>()};
    return block;
}

} // namespace shape::internal
