// SPDX-License-Identifier: MIT

#include "libshape/linalg/sparse_cholesky.h"

#include <cblas.h>
#include <cholmod.h>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

extern "C" void openblas_set_num_threads(int); // cblas.h of OpenBLAS declares it, that of others not

namespace shape {

struct SparseCholesky::Factor
{
    mutable cholmod_common common{};
    cholmod_factor* factor = nullptr;
    Eigen::Index size = 0;
    Eigen::Index entries = 0;
    // Workspaces of cholmod_solve2, kept so that repeated solves allocate nothing.
    mutable cholmod_dense* solution = nullptr;
    mutable cholmod_dense* scratch_y = nullptr;
    mutable cholmod_dense* scratch_e = nullptr;

    Factor()
    {
        // Bits must not depend on the machine's thread count.
        openblas_set_num_threads(1);
        cholmod_start(&common);
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.print = 0;
        common.error_handler = nullptr;
        common.try_catch = 1;
    }
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;
    ~Factor()
    {
        cholmod_free_dense(&solution, &common);
        cholmod_free_dense(&scratch_y, &common);
        cholmod_free_dense(&scratch_e, &common);
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }

    /// A view, nothing is copied; CHOLMOD does not write to its input.
    static cholmod_sparse view(const SparseMatrix& matrix)
    {
        cholmod_sparse view{};
        view.nrow = static_cast<std::size_t>(matrix.rows());
        view.ncol = static_cast<std::size_t>(matrix.cols());
        view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
        view.p = const_cast<int*>(matrix.outerIndexPtr());
        view.i = const_cast<int*>(matrix.innerIndexPtr());
        view.x = const_cast<double*>(matrix.valuePtr());
        view.stype = -1; // symmetric, the lower triangle is read
        view.itype = CHOLMOD_INT;
        view.xtype = CHOLMOD_REAL;
        view.dtype = CHOLMOD_DOUBLE;
        view.sorted = 1;
        view.packed = 1;
        return view;
    }

    void factorise(const SparseMatrix& matrix)
    {
        cholmod_sparse a = view(matrix);
        cholmod_factorize(&a, factor, &common);
        if (common.status == CHOLMOD_NOT_POSDEF || factor->minor < factor->n)
            throw NumericalError(join("sparse Cholesky factorisation: the matrix of size ", size,
                                      " is not positive definite (pivot ", factor->minor, ")"));
        if (common.status < CHOLMOD_OK)
            throw NumericalError(join("sparse Cholesky factorisation failed (CHOLMOD status ",
                                      common.status, ")"));
    }
};

SparseCholesky::SparseCholesky(const SparseMatrix& matrix, Ordering ordering)
    : factor_(std::make_unique<Factor>())
{
    if (matrix.rows() != matrix.cols() || matrix.rows() == 0 || !matrix.isCompressed())
        throw InvalidInput(join("sparse Cholesky factorisation: the matrix is ", matrix.rows(),
                                " by ", matrix.cols(), ", must be square, not empty, compressed"));
    Factor& f = *factor_;
    f.size = matrix.rows();
    f.entries = matrix.nonZeros();
    f.common.nmethods = 1;
    f.common.method[0].ordering =
        ordering == Ordering::MinimumDegree ? CHOLMOD_AMD : CHOLMOD_METIS;
    cholmod_sparse a = Factor::view(matrix);
    f.factor = cholmod_analyze(&a, &f.common);
    if (f.factor == nullptr)
        throw NumericalError(
            join("sparse Cholesky analysis failed (CHOLMOD status ", f.common.status, ")"));
    f.factorise(matrix);
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::refactor(const SparseMatrix& matrix)
{
    if (matrix.rows() != factor_->size || matrix.cols() != factor_->size ||
        matrix.nonZeros() != factor_->entries || !matrix.isCompressed())
        throw InvalidInput(join("refactor: the matrix has ", matrix.rows(), " rows and ",
                                matrix.nonZeros(), " entries, the pattern has ", factor_->size,
                                " and ", factor_->entries));
    factor_->factorise(matrix);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& rhs) const
{
    Factor& f = *factor_;
    if (rhs.rows() != f.size)
        throw InvalidInput(
            join("solve: the right-hand side has ", rhs.rows(), " rows, the matrix ", f.size));
    cholmod_dense b{};
    b.nrow = static_cast<std::size_t>(rhs.rows());
    b.ncol = static_cast<std::size_t>(rhs.cols());
    b.nzmax = static_cast<std::size_t>(rhs.size());
    b.d = b.nrow;
    b.x = const_cast<double*>(rhs.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    if (!cholmod_solve2(CHOLMOD_A, f.factor, &b, nullptr, &f.solution, nullptr, &f.scratch_y,
                        &f.scratch_e, &f.common))
        throw NumericalError(join("sparse back-substitution failed (CHOLMOD status ",
                                  f.common.status, ")"));
    return Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(f.solution->x), rhs.rows(),
                                             rhs.cols());
}

Eigen::Index SparseCholesky::size() const { return factor_->size; }

std::size_t SparseCholesky::nonzeros() const { return static_cast<std::size_t>(factor_->common.lnz); }

} // namespace shape
