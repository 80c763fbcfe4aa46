// SPDX-License-Identifier: MIT

#include "libshape/embedding/finished_embedding.h"

#include <utility>

#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// E of Rojas 2014, eq. 3.
double closure_energy(const Topology& topology, const ShapePoint& target)
{
    const FaceLayout layout =
        lay_out_faces(topology, positive_lengths(target.edge_lengths), target.dihedral_angles);
    return (4.0 * (1.0 - closure_angles(topology, layout.transitions).array().cos())).sum();
}

} // namespace

Embedding as_embedding(const Topology& topology, Points points)
{
    points.rowwise() -= centroid(points);
    const ShapePoint target{edge_lengths(topology, points), dihedral_angles(topology, points)};
    Embedding embedding{std::move(points), {}};
    embedding.report = measure_embedding(topology, embedding.points, target);
    embedding.report.closure_energy = closure_energy(topology, target);
    embedding.report.converged = true;
    return embedding;
}

Embedding internal::finished_embedding(const Topology& topology, const Points& points,
                                       const Points& reference, const ShapePoint& target)
{
    Embedding embedding{best_rigid_motion(points, reference)(points), {}};
    embedding.points.rowwise() -= centroid(embedding.points);
    embedding.report = measure_embedding(topology, embedding.points, target);
    embedding.report.closure_energy = closure_energy(topology, target);
    return embedding;
}

Embedding internal::embed_by_dihedrals(const DihedralEmbedder& embedder, const Topology& topology,
                                       const Points& reference, const ShapePoint& target,
                                       const DihedralEmbeddingOptions& options)
{
    const DihedralEmbedding nearest = embedder.embed(target, options);
    Embedding embedding = finished_embedding(topology, nearest.points, reference, target);
    embedding.report.iterations = nearest.iterations;
    embedding.report.converged = nearest.converged;
    return embedding;
}

} // namespace shape
