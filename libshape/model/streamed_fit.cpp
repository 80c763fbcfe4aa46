// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_fit.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/linalg/block_products.h"
#include "libshape/linalg/strips.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/model/mesh_passes.h"
#include "libshape/model/streamed_angles.h"
#include "libshape/statistics/block_krylov.h"
#include "libshape/statistics/column_strips.h"
#include "libshape/statistics/component_steps.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

constexpr std::uint64_t number = sizeof(double);
constexpr Index strip = 1008; ///< Columns worked on together: two shares of a strip of 2,016.

/// The Gram matrix rounds as its largest entries: the scores that it gives are off by some 1e-16 times the
/// ratio of the variances, here by 1e-12. Those of smaller modes are measured.
constexpr double smallest_ratio_by_gram = 1e-4;

bool wants_all(const ModelOptions& options)
{
    return options.modes == 0 && options.variance == 1.0;
}

/// Of the N by N matrices of Gram.
std::uint64_t matrix_bytes(Index meshes)
{
    const auto count = static_cast<std::uint64_t>(meshes);
    return 4 * number * count * count;
}

/// The modes and what stands beside them as the passes find it.
class Fit
{
public:
    Fit(const MeshStream& meshes, const ModelOptions& options, const StreamOptions& stream)
        : meshes_(meshes),
          options_(options),
          stream_(stream),
          passes_(meshes, options.space, stream.memory, stream.progress, stream.ranks),
          dimension_(passes_.dimension()),
          sizes_(Eigen::VectorXd::Zero(meshes.size())),
          branches_(has_companions(passes_.space()) ? meshes.topology.edge_count() : 0),
          memory_(passes_.memory())
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
        if (!has_scores())
            measure_scores();
        if (mode_angles_.cols() > 0)
            mean_angles_ = first_angles_ + angle_sums_ / static_cast<double>(meshes_.size());
        turn();
        PrincipalComponents& found = components_;
        return {.model = {.topology = meshes_.topology,
                          .reference_points = std::move(reference_),
                          .space = passes_.space(),
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
                .passes = passes_.count(),
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
                                 memory_ >> 20, " MiB; keep fewer modes or allow more memory"));
    }

    [[nodiscard]] FitAlgorithm choose() const
    {
        const Index count = meshes_.size();
        const Index modes = options_.modes;
        const std::uint64_t model =
            modes > 0 ? bytes(modes, dimension_ + meshes_.topology.edge_count()) : 0;
        if (model > memory_)
            fail_for_memory(counted(modes, "mode"), model);
        if (wants_all(options_) && bytes(count, dimension_) > memory_)
            fail_for_memory("all modes", 2 * bytes(count, dimension_));
        if (stream_.algorithm == FitAlgorithm::Automatic && wants_all(options_) &&
            matrix_bytes(count) > memory_ / 2)
            fail_for_memory("all modes", 2 * matrix_bytes(count));
        if (stream_.algorithm == FitAlgorithm::Gram && matrix_bytes(count) > memory_)
            throw LimitExceeded(
                join("the inner products of ", count, " meshes and their decomposition need ",
                     (matrix_bytes(count) >> 20) + 1, " MiB, the memory allowed is ", memory_ >> 20,
                     " MiB; allow more memory or take the other algorithm"));
        return algorithm_for(count, options_, stream_);
    }

    /// The first mesh, and the mean of the first tile, about which sums round little.
    Eigen::VectorXd look_at_first(Index tile)
    {
        Eigen::VectorXd origin;
        passes_.show({0, std::min(tile, meshes_.size()), tile},
                     [&](Index, const Collection& block, RowMatrix& rows) {
                         reference_ = block.points.front();
                         passes_.encode(block, rows);
                         origin = rows.colwise().mean().transpose();
                     });
        return origin;
    }

    /// At most so many meshes, a few here and there of all, the first among them.
    RowMatrix sample(Index most)
    {
        constexpr Index most_places = 16; // a block of the file at least is read for each
        const Index width = std::clamp<Index>(most / most_places, 1, meshes_.size());
        const Index places = std::min(most_places, meshes_.size() / width);
        RowMatrix rows(places * width, dimension_);
        for (Index place = 0; place < places; ++place) {
            const Index begin = place == 0 ? 0 : place * (meshes_.size() - width) / (places - 1);
            passes_.show({begin, begin + width, width},
                         [&](Index, const Collection& block, RowMatrix& some) {
                             if (place == 0)
                                 reference_ = block.points.front();
                             passes_.encode(block, some);
                             rows.middleRows(place * width, width) = some;
                         });
        }
        return rows;
    }

    /// What the first pass learns besides: sizes and branches.
    void learn(Index first, const Collection& block, const Eigen::VectorXd& sizes)
    {
        sizes_.segment(first, sizes.size()) = sizes;
        if (has_companions(passes_.space()))
            branches_.add(block);
    }

    /// A pass that adds to a solver, the first of which learns.
    template <class Solver>
    void pass(const std::string& name, const PassRange& range, bool is_first, Solver& solver,
              const std::function<void()>& finish = {})
    {
        std::vector<std::span<double>> sums = solver.sums();
        if (is_first)
            std::ranges::copy(branches_.sums(), std::back_inserter(sums));
        passes_.run(
            name, range,
            [&](Index first, const Collection& block, RowMatrix& rows) {
                Eigen::VectorXd sizes(static_cast<Index>(block.size()));
                passes_.encode(block, rows, sizes);
                solver.add(first, rows);
                if (is_first)
                    learn(first, block, sizes);
            },
            sums, finish);
        if (!is_first)
            return;
        passes_.gather(numbers_of(sizes_));
        stream_.ranks.all_reduce_max(branches_.largest());
    }

    /// Hands over the state, and takes it back: it may be as large as what is left of the memory.
    template <class Solver>
    void save(Solver& solver)
    {
        if (!stream_.save)
            return;
        PassState state;
        state.numbers.push_back(passes_.count());
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
        passes_.set_count(static_cast<int>(reader.number()));
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
        else
            gram.start_at(look_at_first(tile));
        if (gram.begin() == 0 && measure_once(gram, tile))
            save(gram);
        while (!gram.is_complete()) {
            if (stream_.ranks.partial_sums > 1)
                passes_.show({gram.begin(), gram.held_end(), tile},
                             [&](Index first, const Collection& block, RowMatrix& rows) {
                                 passes_.encode(block, rows);
                                 gram.hold(first, rows);
                             });
            pass("inner products", {gram.begin(), meshes_.size(), tile}, gram.begin() == 0, gram);
            if (stream_.ranks.count > 1)
                gram.gather([&](std::span<double> numbers) { passes_.gather(numbers); });
            gram.end_pass();
            save(gram);
        }
        components_.mean = gram.mean();
        Eigenpairs pairs;
        {
            const Eigen::MatrixXd products = gram.products();
            gram = TiledGram(0, 0, 0);
            check_spread(products.trace());
            components_.total_variance = products.trace() / static_cast<double>(meshes_.size() - 1);
            pairs = leading_eigenpairs(products, options);
        }
        const Index modes = pairs.values.size();
        const std::uint64_t model = bytes(modes, dimension_ + meshes_.topology.edge_count());
        if (model > memory_)
            fail_for_memory(counted(modes, "mode"), model);
        const Eigen::VectorXd lengths = pairs.values.cwiseSqrt();
        if (pairs.values[modes - 1] > smallest_ratio_by_gram * pairs.values[0])
            components_.scores = pairs.vectors * lengths.asDiagonal();
        add_modes(pairs.vectors * lengths.cwiseInverse().asDiagonal());
        RowMatrix change = RowMatrix::Identity(modes, modes);
        orthonormalise(components_.modes, change);
        if (has_scores()) {
            components_.scores = components_.scores * change;
            mix_rows(change, mode_angles_);
        }
    }

    /// All inner products by one pass, if the disk has room for all coordinates and all meshes are this process's.
    bool measure_once(TiledGram& gram, Index tile)
    {
        if (stream_.scratch.empty() || stream_.ranks.partial_sums > 1 ||
            2 * bytes(meshes_.size(), ColumnStrips::width_for(meshes_.size())) > memory_)
            return false;
        strips_ = ColumnStrips::make(stream_.scratch, meshes_.size(), dimension_);
        if (!strips_)
            return false;
        passes_.run("lengths", passes_.all(tile),
                    [&](Index first, const Collection& block, RowMatrix& rows) {
                        passes_.encode(block, rows,
                                       sizes_.segment(first, static_cast<Index>(block.size())));
                        strips_->put(first, rows);
                        if (has_companions(passes_.space()))
                            branches_.add(block);
                    });
        passes_.rest();
        strips_->for_each([&](Index first, RowMatrix& columns) {
            gram.add_columns(first, columns);
            tell("inner products", first + columns.cols());
        });
        gram.end_columns();
        return true;
    }

    /// Of what is done with strips.
    void tell(const char* work, Index columns) const
    {
        const auto kilobytes = [&](Index count) { return bytes(meshes_.size(), count) / 1000; };
        if (stream_.progress)
            stream_.progress(join(work, ", kB"), kilobytes(columns), kilobytes(dimension_));
    }

    [[nodiscard]] bool has_scores() const { return components_.scores.size() > 0; }

    /// The modes, from the shares that the meshes have in them; with them, if the scores are known, what they do
    /// to the angles. Coordinates that lie on the disk are not measured again; the bits are the same.
    void add_modes(const RowMatrix& weights)
    {
        RowMatrix& modes = components_.modes;
        modes = RowMatrix::Zero(weights.cols(), dimension_);
        const bool in_strips = strips_.has_value();
        if (in_strips) {
            strips_->for_each([&](Index first, RowMatrix& columns) {
                centre_rows(columns, components_.mean.segment(first, columns.cols()));
                for_strips(columns.cols(), strip, [&](Index begin, Index count) {
                    add_product_of_columns(weights, columns.middleCols(begin, count),
                                           modes.middleCols(first + begin, count));
                });
                tell("modes", first + columns.cols());
            });
            strips_.reset();
        }
        std::vector<std::span<double>> sums;
        if (!in_strips)
            sums.push_back(numbers_of(modes));
        if (has_scores())
            std::ranges::copy(start_angles(modes.rows()), std::back_inserter(sums));
        if (in_strips && mode_angles_.cols() == 0)
            return;
        passes_.run(
            in_strips ? "angles" : "modes", passes_.all(small_tile()),
            [&](Index first, const Collection& block, RowMatrix& rows) {
                if (!in_strips) {
                    passes_.encode(block, rows);
                    centre_rows(rows, components_.mean);
                    for_strips(dimension_, strip, [&](Index begin, Index count) {
                        add_product_of_columns(weights.middleRows(first, rows.rows()),
                                               rows.middleCols(begin, count),
                                               modes.middleCols(begin, count));
                    });
                }
                if (has_scores())
                    add_angles(
                        block,
                        components_.scores.middleRows(first, static_cast<Index>(block.size())),
                        rows);
            },
            sums);
    }

    /// Where both kinds of modes are in memory.
    [[nodiscard]] Index small_tile() const
    {
        return std::max<Index>(TiledGram::tile_rows(dimension_) / 2, 4);
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
        Index block = BlockKrylov::tile_rows(dimension_);
        while (block > 4 && static_cast<std::uint64_t>(block) * bytes_of_mesh() > memory_ / 4)
            block /= 2; // what little memory there is belongs to the basis
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
        else
            krylov.start_from(sample(krylov.sample_rows()));
        while (!krylov.is_complete()) {
            const bool is_first = krylov.passes() == 0;
            pass("block Krylov", passes_.all(block), is_first, krylov, [&] { krylov.flush(); });
            krylov.end_pass();
            if (is_first) {
                components_.mean = krylov.mean();
                check_spread(krylov.squared_norm());
                passes_.gather(krylov.residuals());
                if (!krylov.is_complete())
                    add_outlying(krylov);
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

    void add_outlying(BlockKrylov& krylov)
    {
        const std::vector<Index> outlying = krylov.outlying_rows();
        if (outlying.empty())
            return;
        RowMatrix rows(static_cast<Index>(outlying.size()), dimension_);
        for (Index i = 0; i < rows.rows(); ++i) {
            const Index mesh = outlying[to_size(i)];
            passes_.show({mesh, mesh + 1, 1}, [&](Index, const Collection& block, RowMatrix& one) {
                passes_.encode(block, one);
                rows.row(i) = one;
            });
        }
        krylov.add_directions(std::move(rows));
    }

    void check_spread(double squares) const
    {
        const double all =
            squares + static_cast<double>(meshes_.size()) * components_.mean.squaredNorm();
        if (squares <= 1e-24 * all)
            throw InvalidInput(join("principal components: all ", meshes_.size(),
                                    " observations are equal, they have no modes"));
    }

    /// Sets up what add_angles() adds to: (S^T S) times what the modes do to the angles is S^T angles.
    std::vector<std::span<double>> start_angles(Index modes)
    {
        const Index edges = has_companions(passes_.space()) ? meshes_.topology.edge_count() : 0;
        mode_angles_ = RowMatrix::Zero(modes, edges);
        angle_sums_ = Eigen::VectorXd::Zero(edges);
        branch_means_ = branches_.means(meshes_.size());
        branches_ = BranchSums(0);
        if (edges > 0)
            first_angles_ =
                dihedral_angles(meshes_.topology, reference_).binaryExpr(branch_means_, &on_branch);
        return {numbers_of(mode_angles_), numbers_of(angle_sums_)};
    }

    /// @param rows  Filled with the angles.
    void add_angles(const Collection& block, const ConstBlock& scores, RowMatrix& rows)
    {
        if (mode_angles_.cols() == 0)
            return;
        rows.resize(scores.rows(), mode_angles_.cols());
        measure_angles(block, rows);
        internal::unify_branches(rows, branch_means_);
        centre_rows(rows, first_angles_, &angle_sums_); // scores sum to 0: rounding stays small
        for_strips(mode_angles_.cols(), strip, [&](Index begin, Index count) {
            add_product_of_columns(scores, rows.middleCols(begin, count),
                                   mode_angles_.middleCols(begin, count));
        });
    }

    /// Scores in the modes, and with them what the modes do to the angles.
    void measure_scores()
    {
        const std::vector<std::span<double>> sums = start_angles(components_.modes.rows());
        components_.scores = RowMatrix::Zero(meshes_.size(), components_.modes.rows());
        passes_.run(
            "scores and angles", passes_.all(small_tile()),
            [&](Index first, const Collection& block, RowMatrix& rows) {
                passes_.encode(block, rows);
                centre_rows(rows, components_.mean);
                auto own = components_.scores.middleRows(first, rows.rows());
                own = coordinates(rows);
                add_angles(block, own, rows);
            },
            sums);
        passes_.gather(numbers_of(components_.scores));
    }

    /// rows modes^T, strips of columns added in their order.
    [[nodiscard]] RowMatrix coordinates(const RowMatrix& rows) const
    {
        const RowMatrix& modes = components_.modes;
        std::vector<RowMatrix> parts(to_size((dimension_ + strip - 1) / strip));
        for_strips(dimension_, strip, [&](Index begin, Index count) {
            RowMatrix& part = parts[to_size(begin / strip)];
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
    MeshPasses passes_;
    Index dimension_;
    Eigen::VectorXd sizes_;
    BranchSums branches_;
    std::uint64_t memory_;
    FitAlgorithm algorithm_ = FitAlgorithm::Gram;
    double error_ = 0.0;
    Points reference_;
    PrincipalComponents components_;
    Eigen::VectorXd branch_means_;
    Eigen::VectorXd first_angles_; ///< Of the reference: angles are summed from there.
    Eigen::VectorXd angle_sums_;
    Eigen::VectorXd mean_angles_;
    RowMatrix mode_angles_;
    std::optional<ColumnStrips> strips_; ///< All coordinates, where measure_once() could.
};

} // namespace

void check(const StreamOptions& options)
{
    require(options.tolerance > 0.0 && options.tolerance < 1.0, "StreamOptions.tolerance",
            options.tolerance, "in (0, 1)");
    check(options.ranks);
}

std::uint64_t usual_memory()
{
    const auto pages = static_cast<std::uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 0L));
    return pages * static_cast<std::uint64_t>(std::max(sysconf(_SC_PAGESIZE), 0L)) / 4;
}

FitAlgorithm algorithm_for(Index meshes, const ModelOptions& options, const StreamOptions& stream)
{
    if (stream.algorithm != FitAlgorithm::Automatic)
        return stream.algorithm;
    // Both ways cost about N E times N, or times 4 s for each of some 6 passes, multiplications: as many at N = 24 s. Up
    // to 1000 meshes Gram is taken all the same: it is exact, and reads them once.
    const Index few = 24 * BlockKrylov::block_size(options.modes > 0 ? options.modes : 32);
    const std::uint64_t memory = stream.memory > 0 ? stream.memory : usual_memory();
    const bool fits = matrix_bytes(meshes) <= memory / 2;
    return fits && (wants_all(options) || meshes <= std::max<Index>(few, 1000))
               ? FitAlgorithm::Gram
               : FitAlgorithm::Krylov;
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
