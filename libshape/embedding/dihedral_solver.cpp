// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral_solver.h"

#include <lbfgs.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/embedding/closure.h"

namespace shape {
namespace {

void check(const Eigen::VectorXd& initial, const DihedralSolverOptions& options)
{
    for (Eigen::Index e = 0; e < initial.size(); ++e)
        if (!std::isfinite(initial[e]))
            throw InvalidInput(
                join("initial dihedral angle of edge ", e, " is ", initial[e], ", must be finite"));
    if (options.memory < 1)
        throw InvalidInput(join("memory is ", options.memory, ", must be >= 1"));
    if (!(options.gradient_tolerance >= 0.0))
        throw InvalidInput(
            join("gradient_tolerance is ", options.gradient_tolerance, ", must be >= 0"));
    if (!(options.decrease_tolerance >= 0.0))
        throw InvalidInput(
            join("decrease_tolerance is ", options.decrease_tolerance, ", must be >= 0"));
    if (options.max_iterations < 0)
        throw InvalidInput(join("max_iterations is ", options.max_iterations, ", must be >= 0"));
}

/// What libLBFGS calls back.
struct Run
{
    ClosureEnergy& energy;
    const DihedralSolverOptions& options;
    const Progress& progress;
    DihedralSolution solution;
    std::exception_ptr stopped{};

    static double evaluate(void* instance, const double* x, double* g, int n, double)
    {
        Run& run = *static_cast<Run*>(instance);
        ++run.solution.evaluations;
        const Eigen::Index edges = run.energy.edge_count();
        std::fill(g + edges, g + n, 0.0); // libLBFGS may round up the number of variables
        return run.energy.evaluate(Eigen::Map<const Eigen::VectorXd>(x, edges),
                                   Eigen::Map<Eigen::VectorXd>(g, edges));
    }

    /// After every step; anything but 0 ends the run.
    static int step_taken(void* instance, const double*, const double* g, double value, double,
                          double, double, int n, int k, int)
    {
        Run& run = *static_cast<Run*>(instance);
        DihedralSolution& solution = run.solution;
        const double decrease = solution.energy - value;
        solution.iterations = k;
        solution.energy = value;
        solution.gradient_maximum =
            Eigen::Map<const Eigen::VectorXd>(g, n).lpNorm<Eigen::Infinity>();
        solution.converged =
            solution.gradient_maximum <= run.options.gradient_tolerance ||
            decrease <= run.options.decrease_tolerance * std::max(1.0, value + decrease);
        try { // no exception may cross the C library
            if (run.progress)
                run.progress("closing the walks", static_cast<std::size_t>(k),
                             static_cast<std::size_t>(run.options.max_iterations));
        } catch (...) {
            run.stopped = std::current_exception();
        }
        return solution.converged || run.stopped ? 1 : 0;
    }
};

} // namespace

DihedralSolution solve_dihedrals(const Topology& topology, const Points& corner_angles,
                                 const Eigen::VectorXd& initial,
                                 const DihedralSolverOptions& options, const Progress& progress)
{
    check(initial, options);
    ClosureEnergy energy(topology, corner_angles);
    Run run{energy, options, progress, {}};
    DihedralSolution& solution = run.solution;
    solution.dihedral_angles = initial;
    Eigen::VectorXd gradient(energy.edge_count());
    solution.energy = energy.evaluate(initial, gradient);
    solution.gradient_maximum = gradient.lpNorm<Eigen::Infinity>();
    solution.evaluations = 1;
    solution.converged = solution.gradient_maximum <= options.gradient_tolerance;
    if (solution.converged || options.max_iterations == 0)
        return solution;

    // libLBFGS built with SSE wants a multiple of 16 variables and aligned memory.
    const auto variables = static_cast<int>((initial.size() + 15) / 16 * 16);
    const std::unique_ptr<double, void (*)(double*)> x(lbfgs_malloc(variables), lbfgs_free);
    if (!x)
        throw std::bad_alloc();
    std::fill(std::copy(initial.begin(), initial.end(), x.get()), x.get() + variables, 0.0);
    lbfgs_parameter_t parameters;
    lbfgs_parameter_init(&parameters);
    parameters.m = options.memory;
    parameters.epsilon = 0.0; // step_taken() decides
    parameters.max_iterations = options.max_iterations;
    lbfgs(variables, x.get(), nullptr, Run::evaluate, Run::step_taken, &run, &parameters);
    if (run.stopped)
        std::rethrow_exception(run.stopped);
    // Where the line search finds no lower value libLBFGS goes back to the last point.
    std::copy_n(x.get(), initial.size(), solution.dihedral_angles.begin());
    return solution;
}

} // namespace shape
