// SPDX-License-Identifier: MIT

#include "libshape/embedding/crossing_count.h"

#include <algorithm>

namespace shape::internal {

void CrossingCount::make()
{
    std::call_once(made_, [this] {
        faces_.emplace(topology_, references_.front());
        for (const Points& reference : references_) {
            const std::vector<FacePair> pairs = faces_->crossings(reference);
            known_.insert(known_.end(), pairs.begin(), pairs.end());
        }
        std::sort(known_.begin(), known_.end());
        known_.erase(std::unique(known_.begin(), known_.end()), known_.end());
    });
}

const FaceTree& CrossingCount::faces()
{
    make();
    return *faces_;
}

const std::vector<FacePair>& CrossingCount::known()
{
    make();
    return known_;
}

CrossingCount::Count CrossingCount::count(const Points& points)
{
    const std::vector<FacePair> pairs = faces().crossings(points);
    const auto is_new = [this](const FacePair& pair) {
        return !std::binary_search(known_.begin(), known_.end(), pair);
    };
    return {static_cast<int>(pairs.size()),
            static_cast<int>(std::count_if(pairs.begin(), pairs.end(), is_new))};
}

void CrossingCount::add_to(Embedding& embedding)
{
    const Count found = count(embedding.points);
    embedding.report.self_intersections = found.all;
    embedding.report.new_self_intersections = found.in_no_reference;
}

} // namespace shape::internal
