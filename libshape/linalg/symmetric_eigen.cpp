// SPDX-License-Identifier: MIT

#include "libshape/linalg/symmetric_eigen.h"

#include <Spectra/MatOp/DenseSymMatProd.h>
#include <Spectra/SymEigsSolver.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {
namespace {

Eigenpairs full_decomposition(const Eigen::MatrixXd& matrix, Eigen::Index count)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
    if (solver.info() != Eigen::Success)
        throw NumericalError(join("eigenvalues of a matrix of size ", matrix.rows(),
                                  ": the decomposition did not converge"));
    return {solver.eigenvalues().tail(count).reverse(),
            solver.eigenvectors().rightCols(count).rowwise().reverse()};
}

std::optional<Eigenpairs> lanczos(const Eigen::MatrixXd& matrix, Eigen::Index count,
                                  Eigen::Index subspace)
{
    try {
        Spectra::DenseSymMatProd<double> product(matrix);
        Spectra::SymEigsSolver<Spectra::DenseSymMatProd<double>> solver(product, count, subspace);
        solver.init(); // Spectra's own fixed seed
        solver.compute(Spectra::SortRule::LargestAlge, 100, 1e-13);
        if (solver.info() == Spectra::CompInfo::Successful)
            return Eigenpairs{solver.eigenvalues(), solver.eigenvectors()};
    } catch (const std::runtime_error&) {
        // A Krylov space that ends early, as that of a matrix of low rank, may break it down.
    }
    return std::nullopt;
}

/// Whether these are the largest eigenpairs indeed. Lanczos from one start vector may miss copies
/// of a multiple eigenvalue, or return vectors that are not orthonormal. With V of eigenvectors,
/// A - V (Lambda - lambda_k) V^T has the wanted eigenvalues lowered to lambda_k: if a Cholesky
/// factorisation finds it below lambda_k + tolerance, no larger one is left.
bool are_largest(const Eigenpairs& pairs, const Eigen::MatrixXd& matrix)
{
    const Eigen::MatrixXd& v = pairs.vectors;
    const double lowest = pairs.values.minCoeff();
    const double scale = pairs.values.cwiseAbs().maxCoeff();
    const double tolerance =
        4.0 * static_cast<double>(matrix.rows()) * std::numeric_limits<double>::epsilon() * scale;
    const auto a = matrix.selfadjointView<Eigen::Lower>();
    // 100 times what Lanczos is asked for: rounding adds to that, and whatever fails is solved directly.
    if (!v.allFinite() || !(v.transpose() * v).isIdentity(1e-11) ||
        !((a * v - v * pairs.values.asDiagonal()).cwiseAbs().maxCoeff() <= 1e-11 * scale))
        return false;
    const Eigen::VectorXd lowered = pairs.values.array() - lowest;
    Eigen::MatrixXd rest = v * lowered.asDiagonal() * v.transpose() - matrix;
    rest.diagonal().array() += lowest + tolerance;
    return Eigen::LLT<Eigen::MatrixXd>(rest).info() == Eigen::Success;
}

} // namespace

Eigenpairs largest_eigenpairs(const Eigen::MatrixXd& matrix, int count)
{
    const Eigen::Index size = matrix.rows();
    if (matrix.cols() != size || size == 0)
        throw InvalidInput(join("eigenvalues: the matrix is ", size, " by ", matrix.cols(),
                                ", must be square and not empty"));
    if (count < 1 || count > size)
        throw InvalidInput(join("eigenvalues: count is ", count, ", must be in [1, ", size, "]"));
    if (!matrix.allFinite())
        throw InvalidInput("eigenvalues: the matrix has an entry that is not finite");

    // Tolerances want entries of about 1; a power of two costs no bit.
    int exponent = 0;
    std::frexp(matrix.cwiseAbs().maxCoeff(), &exponent);
    exponent = std::clamp(exponent, -1000, 1000);
    const Eigen::MatrixXd scaled = std::ldexp(1.0, -exponent) * matrix;

    // Lanczos needs room for its subspace; close to full size the direct method is quicker too.
    const Eigen::Index subspace = std::max<Eigen::Index>(2 * count + 1, 20);
    std::optional<Eigenpairs> pairs;
    if (subspace < size)
        pairs = lanczos(scaled, count, subspace);
    if (!pairs || !are_largest(*pairs, scaled))
        pairs = full_decomposition(scaled, count);
    pairs->values *= std::ldexp(1.0, exponent);
    return *pairs;
}

} // namespace shape::internal
