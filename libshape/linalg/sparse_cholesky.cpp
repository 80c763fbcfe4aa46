// SPDX-License-Identifier: MIT

#include "libshape/linalg/sparse_cholesky.h"

#include <cblas.h>
#include <cholmod.h>

#include <mutex>
#include <new>
#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/blas_turn.h"
#include "libshape/linalg/simplicial_cholesky.h"

extern "C" void openblas_set_num_threads(
    int);                                   // cblas.h of OpenBLAS declares it, that of others not
extern "C" int omp_get_max_active_levels(); // omp.h
extern "C" void omp_set_max_active_levels(int);

namespace shape::internal {
namespace {

/// A view, nothing is copied.
cholmod_dense dense_view(const Eigen::MatrixXd& matrix)
{
    cholmod_dense view{};
    view.nrow = to_size(matrix.rows());
    view.ncol = to_size(matrix.cols());
    view.nzmax = to_size(matrix.size());
    view.d = view.nrow;
    view.x = const_cast<double*>(matrix.data());
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    return view;
}

void start_quietly(cholmod_common& common)
{
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.try_catch = 1;
}

/// @throws std::bad_alloc or NumericalError if CHOLMOD has failed.
void check(const cholmod_common& common, const char* what)
{
    if (common.status == CHOLMOD_OUT_OF_MEMORY)
        throw std::bad_alloc();
    if (common.status < CHOLMOD_OK)
        throw NumericalError(join(what, " failed (CHOLMOD status ", common.status, ")"));
}

/// What one solve needs of its own, so that solves may run concurrently.
struct Workspace
{
    cholmod_common common{};
    cholmod_dense* y = nullptr;
    cholmod_dense* e = nullptr;

    Workspace() { start_quietly(common); }
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    ~Workspace()
    {
        cholmod_free_dense(&y, &common);
        cholmod_free_dense(&e, &common);
        cholmod_finish(&common);
    }
};

} // namespace

struct SparseCholesky::Factor
{
    cholmod_common common{};
    cholmod_factor* factor = nullptr;
    std::optional<SimplicialCholesky> simplicial; // in its place, of a small matrix
    Eigen::Index size = 0;
    Eigen::Index entries = 0;

    Factor()
    {
        // Bits must not depend on the machine's thread count.
        openblas_set_num_threads(1);
        start_quietly(common);
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.final_ll = 1; // L L^T, not L D L^T, which exists for indefinite matrices too
    }
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;
    ~Factor()
    {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }

    /// A view, nothing is copied; CHOLMOD does not write to its input.
    static cholmod_sparse view(const SparseMatrix& matrix)
    {
        cholmod_sparse view{};
        view.nrow = to_size(matrix.rows());
        view.ncol = to_size(matrix.cols());
        view.nzmax = to_size(matrix.nonZeros());
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
        // CHOLMOD starts four threads for loops of every supernode, whatever the machine has: 3
        // times slower on two cores. The setting is that of the calling thread, and given back.
        const BlasTurn turn;
        const int levels = omp_get_max_active_levels();
        omp_set_max_active_levels(0);
        cholmod_sparse a = view(matrix);
        cholmod_factorize(&a, factor, &common);
        omp_set_max_active_levels(levels);
        check(common, "sparse Cholesky factorisation");
        if (common.status == CHOLMOD_NOT_POSDEF || factor->minor < factor->n)
            throw NumericalError(join("sparse Cholesky factorisation: the matrix of size ", size,
                                      " is not positive definite (pivot ", factor->minor, ")"));
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
    f.common.method[0].ordering = ordering == Ordering::MinimumDegree ? CHOLMOD_AMD : CHOLMOD_METIS;
    constexpr Eigen::Index small = 3000; // waking CHOLMOD's threads would cost more than the work
    if (ordering == Ordering::MinimumDegree && f.size < small) {
        f.simplicial.emplace(matrix);
        return;
    }
    cholmod_sparse a = Factor::view(matrix);
    {
        // METIS draws by rand(), from a seed that it sets: of two at once each would draw from the other's numbers.
        static std::mutex ordering_alone;
        const std::lock_guard lock(ordering_alone);
        f.factor = cholmod_analyze(&a, &f.common);
    }
    check(f.common, "sparse Cholesky analysis");
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
    if (factor_->simplicial)
        factor_->simplicial->refactor(matrix);
    else
        factor_->factorise(matrix);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& rhs) const
{
    const Factor& f = *factor_;
    if (rhs.rows() != f.size)
        throw InvalidInput(
            join("solve: the right-hand side has ", rhs.rows(), " rows, the matrix ", f.size));
    if (f.simplicial)
        return f.simplicial->solve(rhs);
    if (f.factor->minor < f.factor->n)
        throw NumericalError("solve: the last factorisation failed");
    Eigen::MatrixXd solution(rhs.rows(), rhs.cols());
    if (rhs.cols() == 0)
        return solution;
    Workspace workspace;
    cholmod_dense b = dense_view(rhs);
    cholmod_dense x = dense_view(solution);
    cholmod_dense* target = &x; // of the right size: CHOLMOD fills it in place
    const BlasTurn turn;
    cholmod_solve2(CHOLMOD_A, f.factor, &b, nullptr, &target, nullptr, &workspace.y, &workspace.e,
                   &workspace.common);
    check(workspace.common, "sparse back-substitution");
    return solution;
}

Eigen::Index SparseCholesky::size() const
{
    return factor_->size;
}

SupernodalFactor SparseCholesky::factor() const
{
    if (factor_->simplicial)
        throw InvalidInput("the factor of a small matrix in MinimumDegree has no supernodes");
    const cholmod_factor& f = *factor_->factor;
    const auto view = [](const void* data, std::size_t count) {
        return std::span(static_cast<const int*>(data), count);
    };
    return {.permutation = view(f.Perm, f.n),
            .first_columns = view(f.super, f.nsuper + 1),
            .first_rows = view(f.pi, f.nsuper + 1),
            .first_values = view(f.px, f.nsuper + 1),
            .rows = view(f.s, f.ssize),
            .values = static_cast<const double*>(f.x)};
}

std::size_t SparseCholesky::nonzeros() const
{
    return factor_->simplicial ? factor_->simplicial->nonzeros()
                               : static_cast<std::size_t>(factor_->common.lnz);
}

} // namespace shape::internal
