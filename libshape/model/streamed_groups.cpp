// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_groups.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/linalg/block_products.h"
#include "libshape/model/mesh_passes.h"
#include "libshape/model/streamed_angles.h"
#include "libshape/statistics/group_fit.h"
#include "libshape/statistics/group_plans.h"
#include "libshape/statistics/streamed_sums.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Adds the rows of each group.
void add_by_group(const Grouping& groups, Index first, const RowMatrix& rows, RowMatrix& sums)
{
    for (Index i = 0; i < rows.rows(); ++i)
        sums.row(groups.group_of[to_size(first + i)]) += rows.row(i);
}

class GroupPasses
{
public:
    GroupPasses(const MeshStream& meshes, const Grouping& groups, const Grouping& blocks,
                const StreamedGroupsOptions& options)
        : groups_(groups),
          blocks_(blocks),
          options_(options),
          passes_(meshes, options.space, options.memory, options.progress),
          members_(members(groups)),
          angle_sums_(options.with_companions && has_companions(passes_.space())
                          ? meshes.topology.edge_count()
                          : 0)
    {
        require_room(to_size(groups.group_count()) *
                     to_size(passes_.dimension() + meshes.topology.edge_count()));
        result_.shapes.sizes.resize(meshes.size());
    }

    StreamedGroups run()
    {
        learn();
        const MatrixXd covariates = options_.covariates ? options_.covariates(result_.shapes.sizes)
                                                        : MatrixXd(passes_.meshes().size(), 0);
        GroupComparisonPlan comparison(groups_, blocks_, covariates, options_.permutations);
        const auto fit = std::make_shared<const GroupFit>(groups_, blocks_, covariates);
        GroupSpreadPlan spread(fit, options_.bootstrap);
        result_.shapes.covariate_means = fit->covariate_means();
        if (!fit->is_plain())
            weigh(*fit);
        SumQuestions questions;
        comparison.ask(questions);
        spread.ask(questions);
        const SumAnswers answers = find_answers(questions);
        result_.comparison = comparison.conclude(answers);
        result_.spread = spread.conclude(answers);
        result_.spread_test = spread.conclude_test(answers, options_.permutations);
        average_angles();
        result_.shapes.space = passes_.space();
        result_.passes = passes_.count();
        return std::move(result_);
    }

private:
    void require_room(std::size_t numbers) const
    {
        const std::uint64_t bytes = sizeof(double) * numbers;
        if (bytes > passes_.memory() / 2)
            throw LimitExceeded(join("the means of ", groups_.group_count(), " groups take ",
                                     (bytes >> 20) + 1, " MiB, which is more than half of the ",
                                     passes_.memory() >> 20, " MiB allowed; allow more memory"));
    }

    /// Sizes, means and, for the angles, branches.
    void learn()
    {
        const Index tile = TiledGram::tile_rows(passes_.dimension());
        GroupedShapes& shapes = result_.shapes;
        shapes.means = RowMatrix::Zero(groups_.group_count(), passes_.dimension());
        Eigen::VectorXd origin;
        passes_.run(
            "means", passes_.all(tile), [&](Index first, const Collection& block, RowMatrix& rows) {
                passes_.encode(block, rows,
                               shapes.sizes.segment(first, static_cast<Index>(block.size())));
                if (first == 0) {
                    result_.reference_points = block.points.front();
                    origin = rows.colwise().mean().transpose();
                }
                centre_rows(rows, origin); // sums of what is small round little
                add_by_group(groups_, first, rows, shapes.means);
                if (angle_sums_ > 0)
                    branches_.add(block);
            });
        mean_ = origin + shapes.means.colwise().sum().transpose() /
                             static_cast<double>(passes_.meshes().size());
        shapes.mean_sizes.resize(groups_.group_count());
        for (std::size_t g = 0; g < members_.size(); ++g) {
            const auto row = static_cast<Index>(g);
            shapes.means.row(row) /= static_cast<double>(members_[g].size());
            shapes.mean_sizes[row] = shapes.sizes(members_[g]).mean();
        }
        shapes.means.rowwise() += origin.transpose();
    }

    /// Means that are not those of all members, and what rows are measured from.
    void weigh(const GroupFit& fit)
    {
        const Index group_count = groups_.group_count();
        weights_ = fit.means();
        const MatrixXd references = fit.references();
        RowMatrix all(weights_.rows(), group_count + references.cols());
        all << weights_, references;
        require_room(to_size(all.cols() * (passes_.dimension() + all.rows()) +
                             group_count * passes_.meshes().topology.edge_count()));
        RowMatrix sums = RowMatrix::Zero(all.cols(), passes_.dimension());
        passes_.run("weighted means", passes_.all(TiledGram::tile_rows(passes_.dimension())),
                    [&](Index first, const Collection& block, RowMatrix& rows) {
                        passes_.encode(block, rows);
                        centre_rows(rows, mean_);
                        add_product_of_columns(all.middleRows(first, rows.rows()), rows, sums);
                    });
        GroupedShapes& shapes = result_.shapes;
        shapes.means = sums.topRows(group_count).rowwise() + mean_.transpose();
        shapes.mean_sizes = weights_.transpose() * shapes.sizes;
        references_ = sums.bottomRows(sums.rows() - group_count);
    }

    /// Inner products cost N^2 E, sums 2 N E a column.
    [[nodiscard]] bool inner_products_pay(const SumQuestions& questions) const
    {
        const Index count = passes_.meshes().size();
        const std::uint64_t bytes = 4 * sizeof(double) * to_size(count * count);
        double columns = 0.0;
        for (const SumFamily& family : questions.families)
            for (const SumColumns& set : family.columns)
                columns += static_cast<double>(family.members * set.width) *
                           static_cast<double>(set.support.size()) / static_cast<double>(count);
        return bytes <= passes_.memory() / 2 && static_cast<double>(count) < 2.0 * columns;
    }

    SumAnswers find_answers(const SumQuestions& questions)
    {
        result_.by_inner_products =
            options_.by_inner_products.value_or(inner_products_pay(questions));
        return result_.by_inner_products ? answers_by_inner_products(questions)
                                         : answers_by_sums(questions);
    }

    SumAnswers answers_by_inner_products(const SumQuestions& questions)
    {
        const Index count = passes_.meshes().size();
        const std::uint64_t room = passes_.memory() / 4;
        TiledGram gram(count, passes_.dimension(),
                       static_cast<Index>(room / (sizeof(double) * to_size(passes_.dimension()))));
        while (!gram.is_complete()) {
            passes_.run("inner products", {gram.begin(), count, gram.tile()},
                        [&](Index first, const Collection& block, RowMatrix& rows) {
                            passes_.encode(block, rows);
                            gram.add(first, rows);
                        });
            gram.end_pass();
        }
        return answer(gram.products(), questions);
    }

    SumAnswers answers_by_sums(const SumQuestions& questions)
    {
        const Index tile = TiledGram::tile_rows(passes_.dimension());
        PointPasses points{passes_.meshes().size(), passes_.dimension(), {}, {}};
        points.group_means = result_.shapes.means.rowwise() - mean_.transpose();
        points.references = references_;
        points.pass = [&](const PointPasses::Visit& visit) {
            passes_.run("sums", passes_.all(tile),
                        [&](Index first, const Collection& block, RowMatrix& rows) {
                            passes_.encode(block, rows);
                            centre_rows(rows, mean_);
                            visit(first, rows);
                        });
        };
        return answer(points, questions, passes_.memory() / 2);
    }

    void average_angles()
    {
        RowMatrix& means = result_.shapes.dihedral_angles;
        means = RowMatrix::Zero(groups_.group_count(), angle_sums_);
        if (angle_sums_ == 0)
            return;
        const Eigen::VectorXd branches = branches_.means(passes_.meshes().size());
        passes_.run("angles", passes_.all(TiledGram::tile_rows(angle_sums_)),
                    [&](Index first, const Collection& block, RowMatrix& rows) {
                        rows.resize(static_cast<Index>(block.size()), angle_sums_);
                        measure_angles(block, rows);
                        internal::unify_branches(rows, branches);
                        if (weights_.cols() > 0)
                            add_product_of_columns(weights_.middleRows(first, rows.rows()), rows,
                                                   means);
                        else
                            add_by_group(groups_, first, rows, means);
                    });
        if (weights_.cols() > 0)
            return;
        for (std::size_t g = 0; g < members_.size(); ++g)
            means.row(static_cast<Index>(g)) /= static_cast<double>(members_[g].size());
    }

    const Grouping& groups_;
    const Grouping& blocks_;
    const StreamedGroupsOptions& options_;
    MeshPasses passes_;
    std::vector<std::vector<int>> members_;
    Index angle_sums_; ///< Angles that are averaged: all edges or none.
    BranchSums branches_{angle_sums_};
    Eigen::VectorXd mean_;
    RowMatrix weights_;    ///< N by G: of meshes in the means; N by 0 if those are of all members.
    RowMatrix references_; ///< See PointPasses.
    StreamedGroups result_;
};

} // namespace

void check(const StreamedGroupsOptions& options)
{
    check(options.space);
    check(options.permutations);
    check(options.bootstrap);
}

StreamedGroups compare_groups(const MeshStream& meshes, const Grouping& groups,
                              const Grouping& blocks, const StreamedGroupsOptions& options)
{
    check(options);
    for (const Grouping* grouping : {&groups, &blocks})
        if (grouping->size() != meshes.size())
            throw InvalidInput(join("groups: the grouping is of ", grouping->size(),
                                    " meshes, the collection has ", meshes.size()));
    return GroupPasses(meshes, groups, blocks, options).run();
}

} // namespace shape
