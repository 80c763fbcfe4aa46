// SPDX-License-Identifier: MIT

#include <libshape/shape.h>

#include <iostream>

// Do expressions differ in shape? A permutation test within people, and the mean of each expression.
int main()
{
    const shape::Collection faces = shape::make_synthetic("faces", {.count = 6, .vertices = 500});
    const shape::Grouping expressions =
        shape::group_by(shape::find_label(faces.labels, "expression").values);
    const shape::Grouping people =
        shape::group_by(shape::find_label(faces.labels, "subject").values);

    const shape::GroupedShapes shapes = shape::group_shapes(faces, expressions, {}, people);
    const shape::GroupComparison comparison = shape::compare_groups(
        shapes.products, expressions, people, Eigen::MatrixXd(shapes.products.rows(), 0));
    std::cout << "p = " << comparison.overall.p_value << "\n";

    const shape::Embedder embedder(faces.topology, faces.points);
    for (int g = 0; g < expressions.group_count(); ++g) {
        const std::string& name = expressions.names[static_cast<std::size_t>(g)];
        shape::write_mesh(name + ".ply", embedder.embed(shape::mean_shape(shapes, g)).points,
                          faces.topology.faces());
    }
}
