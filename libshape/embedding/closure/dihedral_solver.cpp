// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/dihedral_solver.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/angle_limit.h"
#include "libshape/embedding/closure/closure.h"

namespace shape::internal {

DihedralSolution solve_dihedrals(const Topology& topology, const Points& corner_angles,
                                 const Eigen::VectorXd& initial, const LbfgsOptions& options,
                                 const Progress& progress)
{
    for (Eigen::Index e = 0; e < initial.size(); ++e)
        if (!is_within_angle_limit(initial[e]))
            throw InvalidInput(join("initial dihedral angle of edge ", e, " is ", initial[e],
                                    ", must be within ", angle_limit, " rad"));
    ClosureEnergy energy(topology, corner_angles);
    const auto evaluate = [&](const Eigen::VectorXd& angles, Eigen::VectorXd& gradient) {
        return energy.evaluate(angles, gradient);
    };
    const auto report = [&](int iterations) {
        if (progress)
            progress("closing the walks", to_size(iterations), to_size(options.max_iterations));
    };
    Minimum minimum = minimize_lbfgs(evaluate, initial, options, report);
    Eigen::VectorXd gradient(initial.size());
    DihedralSolution solution;
    solution.energy = energy.evaluate(minimum.point, gradient);
    solution.gradient_maximum = gradient.lpNorm<Eigen::Infinity>();
    solution.dihedral_angles = std::move(minimum.point);
    solution.iterations = minimum.iterations;
    solution.evaluations = minimum.evaluations + 1;
    solution.converged = minimum.converged;
    return solution;
}

} // namespace shape::internal
