// SPDX-License-Identifier: MIT

#include "libshape/linalg/symmetric_eigen.h"

#include <Eigen/Eigenvalues>
#include <Spectra/MatOp/DenseSymMatProd.h>
#include <Spectra/SymEigsSolver.h>
#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
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

    // Lanczos needs room for its subspace; close to full size the direct method is quicker too.
    const Eigen::Index subspace = std::max<Eigen::Index>(2 * count + 1, 20);
    if (subspace >= size)
        return full_decomposition(matrix, count);
    Spectra::DenseSymMatProd<double> product(matrix);
    Spectra::SymEigsSolver<Spectra::DenseSymMatProd<double>> solver(product, count, subspace);
    solver.init(); // Spectra's own fixed seed
    solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-13);
    if (solver.info() != Spectra::CompInfo::Successful)
        return full_decomposition(matrix, count);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

} // namespace shape
