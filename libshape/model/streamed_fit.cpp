// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_fit.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/linalg/block_products.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/statistics/block_krylov.h"
#include "libshape/statistics/component_steps.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

constexpr std::uint64_t number = sizeof(double);
constexpr std::size_t strip = 2048; ///< Columns that are worked on together.

/// Runs body(first, count) for fixed strips of [0, total).
void for_strips(Index total, const std::function<void(Index, Index)>& body)
{
    parallel_for(to_size(total), strip, [&](std::size_t begin, std::size_t end) {
        body(static_cast<Index>(begin), static_cast<Index>(end - begin));
    });
}

/// Dihedral angles of the meshes of a block, a row each.
void measure_angles(const Collection& block, RowMatrix& angles)
{
    angles.resize(static_cast<Index>(block.size()), block.topology.edge_count());
    parallel_for(block.size(), 1, [&](std::size_t mesh, std::size_t) {
        angles.row(static_cast<Index>(mesh)) =
            dihedral_angles(block.topology, block.points[mesh]).transpose();
    });
}

/// Finds, from angles that come by once, the branch that each edge's lie on (unify_branches()).
class BranchSums
{
public:
    explicit BranchSums(Index edges)
        : sharpest_(Eigen::VectorXd::Zero(edges)), cosines_(sharpest_), sines_(sharpest_)
    {
    }

    void add(const RowMatrix& angles)
    {
        for_strips(angles.cols(), [&](Index first, Index count) {
            Eigen::VectorXd sines(count), cosines(count);
            for (Index i = 0; i < angles.rows(); ++i) {
                const auto row = angles.row(i).segment(first, count).transpose();
                sines_cosines(row.data(), to_size(count), sines.data(), cosines.data());
                sharpest_.segment(first, count) =
                    sharpest_.segment(first, count).cwiseMax(row.cwiseAbs());
                cosines_.segment(first, count) += cosines;
                sines_.segment(first, count) += sines;
            }
        });
    }

    /// Around which angles near the fold are measured [rad]; 0, where on_branch() changes nothing, of
    /// edges whose angles keep away from it.
    [[nodiscard]] Eigen::VectorXd means(Index count) const
    {
        constexpr double near = 2.0; // [rad]; the fold begins at 2 pi / 3
        Eigen::VectorXd means = Eigen::VectorXd::Zero(sharpest_.size());
        for (Index e = 0; e < means.size(); ++e)
            if (sharpest_[e] > near)
                means[e] = circular_mean(cosines_[e], sines_[e], static_cast<double>(count));
        return means;
    }

    void save(PassState& state) const
    {
        for (const Eigen::VectorXd* sums : {&sharpest_, &cosines_, &sines_})
            state.arrays.emplace_back(sums->transpose());
    }
    void restore(PassStateReader& state)
    {
        for (Eigen::VectorXd* sums : {&sharpest_, &cosines_, &sines_})
            *sums = state.vector(sums->size());
    }

private:
    Eigen::VectorXd sharpest_;
    Eigen::VectorXd cosines_;
    Eigen::VectorXd sines_;
};

/// The modes and what stands beside them as the passes find it.
class Fit
{
public:
    Fit(const MeshStream& meshes, const ModelOptions& options, const StreamOptions& stream)
        : meshes_(meshes),
          options_(options),
          stream_(stream),
          space_(make_space(meshes, options.space, 8)),
          dimension_(internal::dimension(space_, meshes.topology)),
          sizes_(meshes.size()),
          branches_(has_companions(space_) ? meshes.topology.edge_count() : 0),
          memory_(stream.memory > 0 ? stream.memory : usual_memory())
    {
        algorithm_ = choose();
    }

    StreamedFit run()
    {
        const PrincipalComponentsOptions options{.modes = options_.modes,
                                                 .variance = options_.variance};
        if (algorithm_ == FitAlgorithm::Gram)
            find_by_gram(options);
        else
            find_by_krylov(options);
        measure_scores();
        PrincipalComponents& found = components_;
        return {.model = {.topology = meshes_.topology,
                          .reference_points = std::move(reference_),
                          .space = std::move(space_),
                          .mean = std::move(found.mean),
                          .mean_dihedral_angles = std::move(mean_angles_),
                          .modes = std::move(found.modes),
                          .mode_dihedral_angles = std::move(mode_angles_),
                          .variances = std::move(found.variances),
                          .total_variance = found.total_variance,
                          .scores = std::move(found.scores),
                          .sizes = std::move(sizes_),
                          .names = meshes_.names,
                          .labels = meshes_.labels},
                .algorithm = algorithm_,
                .passes = passes_,
                .error = error_};
    }

private:
    [[nodiscard]] std::uint64_t bytes(Index rows, Index columns) const
    {
        return number * static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns);
    }
    /// Of one mesh as it is worked on: positions fetched and unpacked, coordinates, angles.
    [[nodiscard]] std::uint64_t bytes_of_mesh() const
    {
        return 3 * bytes(meshes_.topology.vertex_count(), 3) +
               bytes(meshes_.topology.edge_count() + dimension_, 1);
    }

    [[noreturn]] void fail_for_memory(const std::string& what, std::uint64_t wanted) const
    {
        throw LimitExceeded(join(what, " need ", (wanted >> 20) + 1, " MiB, the memory allowed is ",
                                 memory_ >> 20,
                                 " MiB; keep fewer modes (--modes) or allow more "
                                 "(--memory)"));
    }

    /// Both ways cost about N E times N, or times 4 s for each of some 6 passes, multiplications.
    [[nodiscard]] FitAlgorithm choose() const
    {
        const Index count = meshes_.size();
        const Index modes = options_.modes;
        const std::uint64_t matrices = 4 * bytes(count, count);
        const std::uint64_t model =
            modes > 0 ? bytes(modes, dimension_ + meshes_.topology.edge_count()) : 0;
        if (model > memory_)
            fail_for_memory(counted(modes, "mode"), model);
        const bool wants_all = modes == 0 && options_.variance == 1.0;
        if (wants_all && bytes(count, dimension_) > memory_)
            fail_for_memory("all modes", 2 * bytes(count, dimension_));
        if (stream_.algorithm != FitAlgorithm::Automatic)
            return stream_.algorithm;
        const Index few = 24 * BlockKrylov::block_size(modes > 0 ? modes : 32);
        const bool fits = matrices <= memory_ / 2;
        if (wants_all && !fits)
            fail_for_memory("all modes", 2 * matrices);
        return fits && (wants_all || count <= std::max<Index>(few, 1000)) ? FitAlgorithm::Gram
                                                                          : FitAlgorithm::Krylov;
    }

    /// A pass over the meshes from `begin` on: visit(first, block).
    void pass(const std::string& name, Index begin, Index block,
              const std::function<void(Index, const Collection&)>& visit)
    {
        const auto kilobytes = [&](Index count) {
            return to_size(count) * to_size(meshes_.bytes_per_mesh) / 1000;
        };
        const std::string stage = join("pass ", passes_ + 1, ", ", name, ", kB");
        for_each_block(
            meshes_, begin, meshes_.size(), block, [&](Index first, const Collection& part) {
                visit(first, part);
                const Index done = first + static_cast<Index>(part.size()) - begin;
                if (stream_.progress)
                    stream_.progress(stage, kilobytes(done), kilobytes(meshes_.size() - begin));
            });
        ++passes_;
    }

    /// What the first pass learns besides: sizes, branches, the first mesh.
    void learn(Index first, const Collection& block, const Eigen::VectorXd& sizes)
    {
        sizes_.segment(first, sizes.size()) = sizes;
        if (first == 0)
            reference_ = block.points.front();
        if (!has_companions(space_))
            return;
        measure_angles(block, rows_); // what stood there is used up
        branches_.add(rows_);
    }

    /// Hands over the state, and takes it back: it may be as large as what is left of the memory.
    template <class Solver>
    void save(Solver& solver)
    {
        if (!stream_.save)
            return;
        PassState state;
        state.numbers.push_back(passes_);
        state.arrays.emplace_back(sizes_.transpose());
        state.arrays.emplace_back(reference_);
        branches_.save(state);
        solver.release(state);
        stream_.save(state);
        restore(solver, std::move(state));
    }

    template <class Solver>
    void restore(Solver& solver, PassState state)
    {
        PassStateReader reader(std::move(state));
        passes_ = static_cast<int>(reader.number());
        sizes_ = reader.vector(meshes_.size());
        reference_ = reader.array(meshes_.topology.vertex_count(), 3);
        branches_.restore(reader);
        solver.restore(reader);
    }

    void find_by_gram(const PrincipalComponentsOptions& options)
    {
        const Index tile = TiledGram::tile_rows(dimension_);
        TiledGram gram(meshes_.size(), dimension_, held_rows(tile));
        if (stream_.state)
            restore(gram, *stream_.state);
        while (!gram.is_complete()) {
            const bool is_first = gram.begin() == 0;
            pass("inner products", gram.begin(), tile, [&](Index first, const Collection& block) {
                Eigen::VectorXd sizes;
                encode(space_, block, rows_, sizes);
                gram.add(first, rows_);
                if (is_first)
                    learn(first, block, sizes);
            });
            gram.end_pass();
            save(gram);
        }
        components_.mean = gram.mean();
        RowMatrix weights;
        {
            const Eigen::MatrixXd products = gram.products();
            gram = TiledGram(0, 0, 0);
            check_spread(products.trace());
            components_.total_variance = products.trace() / static_cast<double>(meshes_.size() - 1);
            const Eigenpairs pairs = leading_eigenpairs(products, options);
            weights = pairs.vectors * pairs.values.cwiseSqrt().cwiseInverse().asDiagonal();
        }
        const std::uint64_t model =
            bytes(weights.cols(), dimension_ + meshes_.topology.edge_count());
        if (model > memory_)
            fail_for_memory(counted(weights.cols(), "mode"), model);
        RowMatrix& modes = components_.modes;
        modes = RowMatrix::Zero(weights.cols(), dimension_);
        pass("modes", 0, tile, [&](Index first, const Collection& block) {
            Eigen::VectorXd sizes;
            encode(space_, block, rows_, sizes);
            centre_rows(rows_, components_.mean);
            const auto shares = weights.middleRows(first, rows_.rows());
            for_strips(dimension_, [&](Index begin, Index count) {
                add_product_of_columns(shares, rows_.middleCols(begin, count),
                                       modes.middleCols(begin, count));
            });
        });
        orthonormalise(modes, weights);
    }

    /// As many rows as spare passes: an eighth of all or 48 MiB, whatever is more, if it fits.
    [[nodiscard]] Index held_rows(Index tile) const
    {
        const std::uint64_t row = bytes(1, dimension_);
        const std::uint64_t busy = static_cast<std::uint64_t>(tile) * bytes_of_mesh() +
                                   bytes(meshes_.size(), meshes_.size());
        const std::uint64_t room = memory_ > busy ? (memory_ - busy) / row : 0;
        const std::uint64_t useful = std::max(static_cast<std::uint64_t>(meshes_.size()) / 8,
                                              (std::uint64_t{48} << 20) / row);
        return static_cast<Index>(std::min(room, useful));
    }

    void find_by_krylov(const PrincipalComponentsOptions& options)
    {
        if (options.modes == 0 && options.variance == 1.0)
            throw InvalidInput("Krylov finds some modes, not all: choose a number or a share");
        const Index block = BlockKrylov::tile_rows(dimension_);
        const std::uint64_t busy = static_cast<std::uint64_t>(block) * bytes_of_mesh() +
                                   bytes(options.modes, meshes_.topology.edge_count());
        BlockKrylov krylov(meshes_.size(), dimension_,
                           {.components = options.modes,
                            .variance = options.variance,
                            .tolerance = stream_.tolerance,
                            .seed = stream_.seed,
                            .memory = memory_ > busy ? memory_ - busy : 0});
        if (stream_.state)
            restore(krylov, *stream_.state);
        while (!krylov.is_complete()) {
            const bool is_first = krylov.passes() == 0;
            pass("block Krylov", 0, block, [&](Index first, const Collection& part) {
                Eigen::VectorXd sizes;
                encode(space_, part, rows_, sizes);
                krylov.add(first, rows_);
                if (is_first)
                    learn(first, part, sizes);
            });
            krylov.end_pass();
            if (is_first) {
                components_.mean = krylov.mean();
                check_spread(krylov.squared_norm());
            }
            if (!krylov.is_complete())
                save(krylov);
        }
        components_.mean = krylov.mean();
        components_.total_variance =
            krylov.squared_norm() / static_cast<double>(meshes_.size() - 1);
        components_.modes = krylov.components();
        error_ = krylov.error();
    }

    void check_spread(double squares) const
    {
        const double all =
            squares + static_cast<double>(meshes_.size()) * components_.mean.squaredNorm();
        if (squares <= 1e-24 * all)
            throw InvalidInput(join("principal components: all ", meshes_.size(),
                                    " observations are equal, they have no modes"));
    }

    /// The last pass: scores in the modes, and with them what the modes do to the angles,
    /// (S^T S)^-1 S^T angles. Then everything is turned until the scores are uncorrelated.
    void measure_scores()
    {
        const Index modes = components_.modes.rows();
        const Index edges = has_companions(space_) ? meshes_.topology.edge_count() : 0;
        const Eigen::VectorXd branches = branches_.means(meshes_.size());
        RowMatrix& scores = components_.scores;
        scores = RowMatrix::Zero(meshes_.size(), modes);
        mode_angles_ = RowMatrix::Zero(modes, edges);
        Eigen::VectorXd first_angles;
        Eigen::VectorXd sums = Eigen::VectorXd::Zero(edges);
        // Of small blocks: both kinds of modes are in memory now.
        pass("scores and angles", 0, std::max<Index>(TiledGram::tile_rows(dimension_) / 2, 4),
             [&](Index first, const Collection& block) {
                 RowMatrix& rows = rows_;
                 Eigen::VectorXd sizes;
                 encode(space_, block, rows, sizes);
                 centre_rows(rows, components_.mean);
                 auto own = scores.middleRows(first, rows.rows());
                 own = coordinates(rows);
                 if (edges == 0)
                     return;
                 measure_angles(block, rows);
                 parallel_for(block.size(), 1, [&](std::size_t i, std::size_t) {
                     auto row = rows.row(static_cast<Index>(i));
                     for (Index e = 0; e < edges; ++e)
                         row[e] = on_branch(row[e], branches[e]);
                 });
                 if (first == 0)
                     first_angles = rows.row(0).transpose();
                 centre_rows(rows, first_angles, &sums); // scores sum to 0: rounding stays small
                 for_strips(edges, [&](Index begin, Index count) {
                     add_product_of_columns(own, rows.middleCols(begin, count),
                                            mode_angles_.middleCols(begin, count));
                 });
             });
        if (edges > 0)
            mean_angles_ = first_angles + sums / static_cast<double>(meshes_.size());
        rows_.resize(0, 0);
        turn();
    }

    /// rows modes^T, strips of columns added in their order.
    [[nodiscard]] RowMatrix coordinates(const RowMatrix& rows) const
    {
        const RowMatrix& modes = components_.modes;
        std::vector<RowMatrix> parts((to_size(dimension_) + strip - 1) / strip);
        for_strips(dimension_, [&](Index begin, Index count) {
            RowMatrix& part = parts[to_size(begin) / strip];
            part = RowMatrix::Zero(rows.rows(), modes.rows());
            add_product_with_rows(rows.middleCols(begin, count), modes.middleCols(begin, count),
                                  part);
        });
        RowMatrix sum = RowMatrix::Zero(rows.rows(), modes.rows());
        for (const RowMatrix& part : parts)
            sum += part;
        return sum;
    }

    /// Makes the scores uncorrelated, fixes signs and order, and leaves out what is rounding.
    void turn()
    {
        PrincipalComponents& found = components_;
        RowMatrix change = decorrelating_rotation(found.scores);
        mix_rows(change, found.modes);
        RowMatrix signs = RowMatrix::Identity(change.rows(), change.rows());
        fix_signs(found.modes, signs);
        change = change * signs;
        found.scores = found.scores * change;
        found.weights = RowMatrix::Identity(change.rows(), change.rows());
        measure_variances(found);
        change = change * found.weights;
        mix_rows(change, mode_angles_);
        Index kept = 0;
        while (kept < found.variances.size() &&
               found.variances[kept] > smallest_variance_ratio * found.variances[0])
            ++kept;
        if (kept < found.variances.size()) {
            found.variances.conservativeResize(kept);
            found.modes.conservativeResize(kept, Eigen::NoChange);
            found.scores = found.scores.leftCols(kept).eval();
            mode_angles_.conservativeResize(kept, Eigen::NoChange);
        }
        if (mode_angles_.cols() > 0)
            mode_angles_.array().colwise() /=
                found.variances.array() * static_cast<double>(meshes_.size() - 1);
    }

    const MeshStream& meshes_;
    const ModelOptions& options_;
    const StreamOptions& stream_;
    ShapeSpace space_;
    Index dimension_;
    Eigen::VectorXd sizes_;
    BranchSums branches_;
    std::uint64_t memory_;
    FitAlgorithm algorithm_ = FitAlgorithm::Gram;
    int passes_ = 0;
    double error_ = 0.0;
    Points reference_;
    RowMatrix
        rows_; ///< Of a block, worked on; kept, for fresh memory costs more than what is done in it.
    PrincipalComponents components_;
    Eigen::VectorXd mean_angles_;
    RowMatrix mode_angles_;
};

} // namespace

void check(const StreamOptions& options)
{
    require(options.tolerance > 0.0 && options.tolerance < 1.0, "StreamOptions.tolerance",
            options.tolerance, "in (0, 1)");
}

std::uint64_t usual_memory()
{
    const auto pages = static_cast<std::uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 0L));
    return pages * static_cast<std::uint64_t>(std::max(sysconf(_SC_PAGESIZE), 0L)) / 4;
}

StreamedFit fit_model(const MeshStream& meshes, const ModelOptions& options,
                      const StreamOptions& stream)
{
    check(options);
    check(stream);
    const Index most = meshes.size() - 1;
    if (most < 1)
        throw InvalidInput(join("a model needs at least 2 meshes, there is ", meshes.size()));
    if (options.modes > most)
        throw InvalidInput(join("principal components: modes is ", options.modes,
                                ", must be in [0, ", most, "] for ", meshes.size(),
                                " observations"));
    return Fit(meshes, options, stream).run();
}

} // namespace shape
