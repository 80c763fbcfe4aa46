// SPDX-License-Identifier: MIT

#include "libshape/conformal/cotangent_system.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

struct CotangentSystem::State
{
    std::vector<int> vertices; // of each row
    std::vector<int> rows;     // of each vertex, -1 if it is not free
    Edges edge_vertices;
    SparseMatrix matrix;           // lower triangle
    std::vector<int> edge_entries; // place of each edge's entry in the matrix, -1 if it has none
    std::vector<int> diagonal_entries;
    std::optional<SparseCholesky> factor;
};

CotangentSystem::CotangentSystem(const IntrinsicTriangulation& t, std::vector<char> is_free)
    : state_(std::make_unique<State>())
{
    State& s = *state_;
    s.rows.assign(to_size(t.vertex_count()), -1);
    for (int v = 0; v < t.vertex_count(); ++v)
        if (is_free[to_size(v)]) {
            s.rows[to_size(v)] = static_cast<int>(s.vertices.size());
            s.vertices.push_back(v);
        }
    const auto row = [&](int v) { return s.rows[to_size(v)]; };

    s.edge_vertices.resize(t.edge_count(), 2);
    std::vector<Eigen::Triplet<double, int>> entries;
    for (std::size_t r = 0; r < s.vertices.size(); ++r)
        entries.emplace_back(static_cast<int>(r), static_cast<int>(r), 1.0);
    for (int e = 0; e < t.edge_count(); ++e) {
        const int a = t.source(t.halfedge(e));
        const int b = t.target(t.halfedge(e));
        s.edge_vertices.row(e) << a, b;
        if (a != b && row(a) >= 0 && row(b) >= 0)
            entries.emplace_back(std::max(row(a), row(b)), std::min(row(a), row(b)), 1.0);
    }
    const auto size = static_cast<Eigen::Index>(s.vertices.size());
    s.matrix.resize(size, size);
    s.matrix.setFromTriplets(entries.begin(), entries.end());

    const auto place = [&](int i, int j) {
        const int* const inner = s.matrix.innerIndexPtr();
        const int* const begin = inner + s.matrix.outerIndexPtr()[j];
        const int* const end = inner + s.matrix.outerIndexPtr()[j + 1];
        return static_cast<int>(std::lower_bound(begin, end, i) - inner);
    };
    for (int r = 0; r < size; ++r)
        s.diagonal_entries.push_back(place(r, r));
    for (int e = 0; e < t.edge_count(); ++e) {
        const int a = row(s.edge_vertices(e, 0));
        const int b = row(s.edge_vertices(e, 1));
        s.edge_entries.push_back(a >= 0 && b >= 0 && a != b ? place(std::max(a, b), std::min(a, b))
                                                            : -1);
    }
}

CotangentSystem::~CotangentSystem() = default;
CotangentSystem::CotangentSystem(CotangentSystem&&) noexcept = default;
CotangentSystem& CotangentSystem::operator=(CotangentSystem&&) noexcept = default;

void CotangentSystem::factor(const Eigen::VectorXd& edge_weights)
{
    State& s = *state_;
    if (!edge_weights.allFinite())
        throw NumericalError("a cotangent weight is not finite");
    double* const values = s.matrix.valuePtr();
    std::fill(values, values + s.matrix.nonZeros(), 0.0);
    for (Eigen::Index e = 0; e < edge_weights.size(); ++e) {
        const int a = s.edge_vertices(e, 0);
        const int b = s.edge_vertices(e, 1);
        if (a == b)
            continue;
        for (const int v : {a, b})
            if (const int r = s.rows[to_size(v)]; r >= 0)
                values[s.diagonal_entries[to_size(r)]] += edge_weights[e];
        if (const int entry = s.edge_entries[to_size(e)]; entry >= 0)
            values[entry] -= edge_weights[e];
    }
    if (s.vertices.empty())
        return;
    // Weights are about 1. As little as lets the matrix be factorised, found in steps of 100: more bends the
    // Newton step towards the gradient.
    double shift = 0.0;
    for (const double wanted : {1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1e2}) {
        const double raise = wanted - std::exchange(shift, wanted);
        for (const int entry : s.diagonal_entries)
            values[entry] += raise;
        try {
            if (s.factor)
                s.factor->refactor(s.matrix);
            else
                s.factor.emplace(s.matrix);
            return;
        } catch (const NumericalError&) {
            // Broken triangles leave rows without weight: raise the diagonal.
        }
    }
    throw NumericalError("the cotangent Laplacian is not positive definite");
}

Eigen::MatrixXd CotangentSystem::solve(const Eigen::MatrixXd& rhs) const
{
    const State& s = *state_;
    const auto size = static_cast<Eigen::Index>(s.vertices.size());
    Eigen::MatrixXd b(size, rhs.cols());
    for (Eigen::Index r = 0; r < size; ++r)
        b.row(r) = rhs.row(s.vertices[to_size(r)]);
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rhs.rows(), rhs.cols());
    if (size == 0)
        return result;
    const Eigen::MatrixXd x = s.factor->solve(b);
    for (Eigen::Index r = 0; r < size; ++r)
        result.row(s.vertices[to_size(r)]) = x.row(r);
    return result;
}

} // namespace shape::internal
