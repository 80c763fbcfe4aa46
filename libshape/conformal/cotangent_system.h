// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/conformal/intrinsic_triangulation.h"

namespace shape::internal {

/// The Laplacian of given edge weights with Dirichlet conditions: the Hessian of the angle-defect
/// energy and the operator that lays out flat surfaces. The pattern is analysed once.
class CotangentSystem
{
public:
    /// @param is_free  #V; rows and columns of the other vertices are left out. May be none.
    CotangentSystem(const IntrinsicTriangulation& triangulation, std::vector<char> is_free);
    ~CotangentSystem();
    CotangentSystem(CotangentSystem&&) noexcept;
    CotangentSystem& operator=(CotangentSystem&&) noexcept;

    /// Factors L = D - W, W the edge weights. The diagonal is raised by 1e-12, and more where that
    /// is not enough for positive definiteness.
    /// @throws NumericalError if a weight is not finite.
    void factor(const Eigen::VectorXd& edge_weights);

    /// Solves L x = rhs on the free vertices. rhs and result #V by k; the result is 0 elsewhere.
    [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape::internal
