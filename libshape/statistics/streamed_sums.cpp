// SPDX-License-Identifier: MIT

#include "libshape/statistics/streamed_sums.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "libshape/base/stop.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/block_products.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Some members of a family, whose sums are taken in the same pass.
class FamilyChunk
{
public:
    /// Columns that are summed together: enough for a product of matrices to be quick.
    static constexpr Index columns = 256;

    FamilyChunk(const SumFamily& family, std::size_t number, Index begin, Index end)
        : family_(&family), number_(number), begin_(begin), end_(end)
    {
    }

    [[nodiscard]] std::uint64_t bytes(Index coordinates) const
    {
        return to_size(end_ - begin_) * (sizeof(double) * to_size(family_->width() * coordinates) +
                                         family_->bytes_per_member);
    }

    void start(Index coordinates)
    {
        fill_ = family_->prepare(begin_, end_);
        for (const SumColumns& set : family_->columns)
            sums_.emplace_back(RowMatrix::Zero((end_ - begin_) * set.width, coordinates));
    }

    void add(Index first, const RowMatrix& rows)
    {
        for (std::size_t set = 0; set < sums_.size(); ++set) {
            const std::vector<int>& support = family_->columns[set].support;
            const auto low = std::lower_bound(support.begin(), support.end(), first);
            const auto high = std::lower_bound(low, support.end(), first + rows.rows());
            if (low == high)
                continue;
            const Index width = family_->columns[set].width;
            RowMatrix weights(high - low, sums_[set].rows());
            for (Index member = begin_; member < end_; ++member)
                fill_(member, set, to_size(low - support.begin()),
                      weights.middleCols((member - begin_) * width, width));
            if (weights.rows() == rows.rows()) {
                add_product_of_columns(weights, rows, sums_[set]);
                continue;
            }
            RowMatrix some(weights.rows(), rows.cols());
            for (Index i = 0; i < some.rows(); ++i)
                some.row(i) = rows.row(low[i] - first);
            add_product_of_columns(weights, some, sums_[set]);
        }
    }

    void finish(SumAnswers& answers)
    {
        for (Index member = begin_; member < end_; ++member) {
            RowMatrix all(family_->width(), sums_.front().cols());
            Index top = 0;
            for (std::size_t set = 0; set < sums_.size(); ++set) {
                const Index width = family_->columns[set].width;
                all.middleRows(top, width) =
                    sums_[set].middleRows((member - begin_) * width, width);
                top += width;
            }
            RowMatrix products = RowMatrix::Zero(all.rows(), all.rows());
            add_product_with_rows(all, all, products);
            answers.families[number_][to_size(member)] = products;
        }
        sums_.clear();
        fill_ = nullptr;
    }

private:
    const SumFamily* family_;
    std::size_t number_;
    Index begin_;
    Index end_;
    SumFamily::Fill fill_;
    std::vector<RowMatrix> sums_; ///< For each set, members and their columns by E.
};

/// The sums of parts: one is kept from the first member of its part to the last. What the memory does not
/// hold waits for the next pass.
class PartSumming
{
public:
    PartSumming(const PartSums& parts, const PointPasses& points)
        : parts_(&parts),
          references_(&points.references),
          squares_(Eigen::VectorXd::Constant(parts.parts, waiting)),
          sizes_(to_size(parts.parts), 0)
    {
        for (const int part : parts.part_of)
            ++sizes_[to_size(part)];
        for (Index part = 0; part < parts.parts; ++part)
            if (sizes_[to_size(part)] == 0)
                squares_[part] = parts.taken.cols() > 0
                                     ? (parts.taken.row(part) * points.references).squaredNorm()
                                     : 0.0;
        bytes_ = sizeof(double) * to_size(points.coordinates);
    }

    void start(std::uint64_t memory)
    {
        room_ = std::max<std::uint64_t>(memory / bytes_, 1);
        seen_.assign(sizes_.size(), 0);
        slot_of_.assign(sizes_.size(), -1);
    }

    void add(Index first, const RowMatrix& rows)
    {
        const std::vector<int>& points = parts_->points;
        const auto low = std::lower_bound(points.begin(), points.end(), first);
        for (auto point = low; point != points.end() && *point < first + rows.rows(); ++point) {
            const auto number = point - points.begin();
            add_row(to_size(parts_->part_of[to_size(number)]), parts_->weights[number],
                    rows.row(*point - first));
        }
    }

    [[nodiscard]] bool is_complete() const { return (squares_.array() != waiting).all(); }
    [[nodiscard]] const Eigen::VectorXd& squares() const { return squares_; }

private:
    static constexpr double waiting = -1.0;

    void add_row(std::size_t part, double weight, const Eigen::Ref<const Eigen::RowVectorXd>& row)
    {
        if (squares_[static_cast<Index>(part)] != waiting)
            return;
        if (sizes_[part] == 1 && parts_->taken.cols() == 0) {
            squares_[static_cast<Index>(part)] = weight * weight * row.squaredNorm();
            return;
        }
        ++seen_[part];
        int& slot = slot_of_[part];
        if (slot < 0) {
            if (seen_[part] > 1 || (free_.empty() && sums_.size() >= room_))
                return; // its turn comes later
            if (free_.empty()) {
                free_.push_back(static_cast<int>(sums_.size()));
                sums_.emplace_back(row.size());
            }
            slot = free_.back();
            free_.pop_back();
            sums_[to_size(slot)].setZero();
        }
        Eigen::RowVectorXd& sum = sums_[to_size(slot)];
        sum += weight * row;
        if (seen_[part] == sizes_[part]) {
            if (parts_->taken.cols() > 0)
                sum -= parts_->taken.row(static_cast<Index>(part)) * *references_;
            squares_[static_cast<Index>(part)] = sum.squaredNorm();
            free_.push_back(slot);
            slot = -1;
        }
    }

    const PartSums* parts_;
    const RowMatrix* references_;
    Eigen::VectorXd squares_;
    std::vector<int> sizes_; ///< Members of each part.
    std::vector<int> seen_;  ///< In this pass.
    std::vector<int> slot_of_;
    std::vector<int> free_;
    std::vector<Eigen::RowVectorXd> sums_;
    std::uint64_t bytes_ = 0;
    std::uint64_t room_ = 1;
};

/// What one look at each point tells.
void measure(Index first, const RowMatrix& rows, const SumQuestions& questions,
             const RowMatrix& means, SumAnswers& answers)
{
    parallel_for(to_size(rows.rows()), 8, [&](std::size_t begin, std::size_t end) {
        for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i) {
            answers.squares[first + i] = rows.row(i).squaredNorm();
            if (questions.groups)
                answers.squares_about_means[first + i] =
                    (rows.row(i) - means.row(questions.groups->group_of[to_size(first + i)]))
                        .squaredNorm();
        }
    });
}

} // namespace

SumAnswers answer(const PointPasses& points, const SumQuestions& questions, std::uint64_t memory)
{
    SumAnswers answers;
    answers.squares.resize(points.points);
    if (questions.groups)
        answers.squares_about_means.resize(points.points);
    std::vector<FamilyChunk> waiting;
    for (std::size_t f = 0; f < questions.families.size(); ++f) {
        const SumFamily& family = questions.families[f];
        answers.families.emplace_back(to_size(family.members));
        const Index step = std::max<Index>(FamilyChunk::columns / family.width(), 1);
        throw_if_stop_requested();
        for (Index begin = 0; begin < family.members; begin += step)
            waiting.emplace_back(family, f, begin, std::min(begin + step, family.members));
    }
    std::vector<PartSumming> parts;
    for (const PartSums& question : questions.parts)
        parts.emplace_back(question, points);

    bool is_first = true;
    for (auto next = waiting.begin();
         is_first || next != waiting.end() ||
         !std::ranges::all_of(parts, [](const auto& part) { return part.is_complete(); });) {
        std::uint64_t left = memory;
        for (PartSumming& part : parts)
            part.start(memory / (4 * parts.size()));
        left -= memory / 4;
        const auto begin = next;
        for (; next != waiting.end() && (next == begin || next->bytes(points.coordinates) <= left);
             ++next)
            left -= std::min(left, next->bytes(points.coordinates));
        const std::span<FamilyChunk> chunks(begin, next);
        for (FamilyChunk& chunk : chunks) {
            throw_if_stop_requested();
            chunk.start(points.coordinates);
        }
        points.pass([&](Index first, const RowMatrix& rows) {
            if (is_first)
                measure(first, rows, questions, points.group_means, answers);
            parallel_for(chunks.size() + parts.size(), 1, [&](std::size_t k, std::size_t) {
                if (k < parts.size())
                    parts[k].add(first, rows);
                else
                    chunks[k - parts.size()].add(first, rows);
            });
        });
        parallel_for(chunks.size(), 1,
                     [&](std::size_t k, std::size_t) { chunks[k].finish(answers); });
        is_first = false;
    }
    for (const PartSumming& part : parts)
        answers.parts.push_back(part.squares());
    return answers;
}

SumAnswers answer_in_memory(const RowMatrix& points, const SumQuestions& questions)
{
    const auto pass = [&](const PointPasses::Visit& visit) {
        constexpr Index tile = 4096;
        for (Index first = 0; first < points.rows(); first += tile)
            visit(first, points.middleRows(first, std::min(tile, points.rows() - first)));
    };
    PointPasses passes{points.rows(), points.cols(), pass};
    if (questions.references.cols() > 0)
        passes.references = questions.references.transpose() * points;
    return answer(passes, questions, std::numeric_limits<std::uint32_t>::max());
}

} // namespace shape::internal
