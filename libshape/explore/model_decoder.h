// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "libshape/embedding/crossing_count.h"
#include "libshape/embedding/finished_embedding.h"
#include "libshape/explore/model_block.h"

namespace shape::internal {

/// A point of a model as a mesh, and what of it is worth a colour.
struct DecodedModelPoint
{
    Embedding embedding;
    Eigen::VectorXf edge_error;     ///< #V; see ResidualField.
    Eigen::VectorXf dihedral_drift; ///< #V [deg]; the same.
    std::vector<char>
        broken_faces; ///< #F; 1 where the wanted lengths break the triangle inequality.
};

/// Meshes of points of a model that came as a block. Needs no package: of the portable core.
class ModelDecoder
{
public:
    /// @throws InvalidInput if the parts of the block do not fit each other.
    explicit ModelDecoder(ModelBlock block);
    ModelDecoder(const ModelDecoder&) = delete;
    ModelDecoder& operator=(const ModelDecoder&) = delete;

    /// @param scores  At most K coordinates along the modes; missing ones are 0.
    /// @param amounts  At most M, of the added directions.
    /// @param size  As decode() takes it.
    /// @param options  What the embedder does; its smoothness is that of the block.
    /// @throws InvalidInput, NumericalError as decode() and DihedralEmbedder::embed().
    [[nodiscard]] DecodedModelPoint decode(const Eigen::VectorXd& scores,
                                           const Eigen::VectorXd& amounts, double size,
                                           DihedralEmbeddingOptions options) const;

    /// The same to begin with where vertices are to first order, swept once (DihedralEmbedder::sweep()); exact
    /// in Procrustes space. The closure energy is left out. Costs a quarter of a preview.
    [[nodiscard]] DecodedModelPoint draft(const Eigen::VectorXd& scores,
                                          const Eigen::VectorXd& amounts, double size) const;

    /// Whether the wanted lengths keep every triangle inequality, strictly; always in Procrustes space.
    /// Arguments as above. Cost: that of the point; nothing is embedded.
    [[nodiscard]] bool is_feasible(const Eigen::VectorXd& scores, const Eigen::VectorXd& amounts,
                                   double size) const;

    /// Pairs of faces that cross in a mesh, and those that do not in the reference mesh. Cost: a tenth of a preview.
    /// @throws InvalidInput if it has another number of vertices.
    [[nodiscard]] CrossingCount::Count crossings(const Points& points) const;

    [[nodiscard]] const ModelBlock& block() const { return block_; }

private:
    [[nodiscard]] DecodedShape point(const Eigen::VectorXd& scores, const Eigen::VectorXd& amounts,
                                     double size) const;

    [[nodiscard]] DecodedModelPoint linear(Points points) const;
    [[nodiscard]] Points first_order(const Eigen::VectorXd& scores, const Eigen::VectorXd& amounts,
                                     double size) const;
    void add_fields(const ShapePoint& target, const EdgeResiduals& residuals,
                    DecodedModelPoint& to) const;

    ModelBlock block_;
    std::vector<Points> references_; // the one
    std::optional<DihedralEmbedder> embedder_;
    std::unique_ptr<CrossingCount> crossings_; // knows topology and references by their place
};

} // namespace shape::internal
