// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <cmath>

// Fits a model to the meshes named by the arguments and writes mode1.ply, the mesh two standard
// deviations along mode 1.
int main(int argc, char** argv)
{
    std::vector<shape::NamedMesh> meshes;
    for (int i = 1; i < argc; ++i)
        meshes.push_back(shape::read_mesh(argv[i]));
    const shape::ShapeModel model = shape::fit_model(shape::collect(std::move(meshes)));

    const Eigen::VectorXd scores{{2.0 * std::sqrt(model.variances[0])}};
    const shape::Embedder embedder(model.topology, {model.reference_points});
    const shape::Embedding mesh =
        embedder.embed(shape::model_point(model, scores, model.mean_size()));
    shape::write_mesh("mode1.ply", mesh.points, model.topology.faces());
}
