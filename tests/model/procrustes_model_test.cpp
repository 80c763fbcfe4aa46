// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/embedding/embedder.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/shape_model.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"
#include "tests/support/h5py.h"
#include "tests/support/spaces.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

TEST(ModelOfAnySpace, GivesEveryMeshBackFromAllModes)
{
    const Collection collection = test::bumpy_spheres(7, 1);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeModel model = fit_model(collection, {.space = options});
        ASSERT_EQ(model.mode_count(), 6);
        for (Index i = 0; i < 7; ++i) {
            const Points& points = collection.points[to_size(i)];
            const Eigen::VectorXd lengths = edge_lengths(collection.topology, points);
            const DecodedShape shape =
                model_point(model, model.scores.row(i).transpose(), model.sizes[i]);
            const Points* decoded = std::get_if<Points>(&shape);
            const Eigen::VectorXd got = decoded ? edge_lengths(collection.topology, *decoded)
                                                : std::get<ShapePoint>(shape).edge_lengths;
            EXPECT_LE((got - lengths).cwiseQuotient(lengths).cwiseAbs().maxCoeff(), 1e-10);
        }
    }
}

TEST(ModelOfAnySpace, GivesItsMeshesTheirOwnScores)
{
    const Collection collection = test::bumpy_spheres(7, 2);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const ShapeModel model = fit_model(collection, {.space = options});
        const Projection projection = project(model, test::moved(collection, 20));
        const double spread = std::sqrt(model.variances[0]);
        EXPECT_LE((projection.scores - model.scores).cwiseAbs().maxCoeff(), 1e-9 * spread);
        EXPECT_LE(projection.residuals.maxCoeff(), 1e-9 * spread);
        EXPECT_LE((projection.sizes - model.sizes).cwiseAbs().maxCoeff(), 1e-10);
    }
}

TEST(ProcrustesModel, NeedsNoEmbeddingAndSaysExact)
{
    const Collection collection = test::bumpy_spheres(6, 3);
    const ShapeModel model = fit_model(collection, {.space = {.kind = SpaceKind::Procrustes}});
    const Points points = std::get<Points>(model_point(model, Eigen::Vector2d(0.01, 0.02), 5.0));
    const Embedding embedding = as_embedding(model.topology, points);
    EXPECT_EQ(embedding.report.status, EmbeddingStatus::Exact);
    EXPECT_TRUE(embedding.report.converged);
    EXPECT_EQ(embedding.report.edge_max, 0.0);
    EXPECT_EQ(embedding.report.dihedral_max_deg, 0.0);
    EXPECT_LE(embedding.report.closure_energy, 42 * 4e-15); // #V terms 4 (1 - cos), to rounding
    EXPECT_LE(embedding.points.colwise().mean().norm(), 1e-13);
    EXPECT_LE(
        (edge_lengths(model.topology, embedding.points) - edge_lengths(model.topology, points))
            .norm(),
        1e-12);
    const FeasibleRange range = feasible_range(model, 0, 4.0);
    EXPECT_EQ(range.low, -4.0);
    EXPECT_EQ(range.high, 4.0);
}

/// An independent Procrustes PCA (numpy, singular value decompositions throughout) of the
/// collection c.h5, compared with the model f: the largest relative errors of variances, total
/// variance, scores in standard deviations, and of the mean.
const std::string peer = R"(
X = h5py.File(os.path.dirname(f.filename) + '/c.h5')['points'][...]
X -= X.mean(1, keepdims=True)
if f.attrs['scale'].decode() == 'unit':
    X /= np.linalg.norm(X, axis=(1, 2))[:, None, None]
first, m = X[0].copy(), X[0].copy()
for step in range(200):
    U, s, V = np.linalg.svd(np.einsum('nvi,vj->nij', X, m))
    U[:, :, 2] *= np.linalg.det(U @ V)[:, None]
    X = X @ (U @ V)
    last, m = m, X.mean(0)
    if np.linalg.norm(m - last) < 1e-13 * np.linalg.norm(m):
        break
D = X.reshape(len(X), -1)
U, s, V = np.linalg.svd(D - D.mean(0), full_matrices=False)
var = s ** 2 / (len(X) - 1)
v = f['variances'][...]
k = np.searchsorted(-v, -1e-4 * v[0])
scores = np.abs(f['scores'][:, :k]) - np.abs(U * s)[:, :k]
M = f['mean/points'][...]
U, s, V = np.linalg.svd(m.T @ M)
print(np.max(np.abs(v[:k] / var[:k] - 1)), abs(f['total_variance'][()] / var.sum() - 1),
      np.max(np.abs(scores) / np.sqrt(v[:k])), np.linalg.norm(m @ (U @ V) - M) / np.linalg.norm(M))
)";

/// The largest of those errors.
double largest_difference_from_numpy(const Collection& collection, Scale scale)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", collection);
    write_model(directory / "m.h5",
                fit_model(collection, {.space = {.kind = SpaceKind::Procrustes, .scale = scale}}));
    const std::string printed = test::run_h5py(directory / "m.h5", "r", peer);
    std::istringstream in(printed);
    double largest = 0.0;
    for (int i = 0; i < 4; ++i) {
        double error = INFINITY;
        EXPECT_TRUE(in >> error) << printed;
        largest = std::max(largest, error);
    }
    return largest;
}

TEST(ProcrustesModel, IsThatOfNumpy)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    for (const Scale scale : {Scale::Unit, Scale::None})
        EXPECT_LT(largest_difference_from_numpy(test::bumpy_spheres(20, 4), scale), 1e-9);
}

TEST(ProcrustesModelOfRealFacesSlow, IsThatOfNumpy)
{
    if (test::python_with_h5py().empty() || !test::has_ict_faces())
        GTEST_SKIP() << "no Python with h5py, or the dataset ict_faces600 is not there";
    const Collection faces = test::ict_faces();
    for (const Scale scale : {Scale::Unit, Scale::None})
        EXPECT_LT(largest_difference_from_numpy(faces, scale), 1e-6);
}

} // namespace
} // namespace shape
