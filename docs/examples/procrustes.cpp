// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <iostream>

// The same statistics on aligned vertex positions instead of edge lengths, to compare with: there a
// point of the model is a mesh already, and the embedder hands it through.
int main()
{
    const shape::Collection faces = shape::make_synthetic("faces", {.count = 6, .vertices = 500});
    const shape::ShapeModel model =
        shape::fit_model(faces, {.modes = 3, .space = {.kind = shape::SpaceKind::Procrustes}});

    const shape::Embedder embedder(model.topology, {model.reference_points});
    const shape::Embedding mean =
        embedder.embed(shape::model_point(model, Eigen::VectorXd(), model.mean_size()));
    shape::write_mesh("procrustes_mean.ply", mean.points, model.topology.faces());
    std::cout << "mode 1 has " << 100.0 * model.variances[0] / model.total_variance
              << " % of the variance\n";
}
