// SPDX-License-Identifier: MIT

#include "libshape/embedding/crossing_count.h"

#include <algorithm>

namespace shape::internal {

void CrossingCount::add_to(Embedding& embedding)
{
    std::call_once(made_, [this] {
        faces_.emplace(topology_, references_.front());
        for (const Points& reference : references_) {
            const std::vector<FacePair> pairs = faces_->crossings(reference);
            known_.insert(known_.end(), pairs.begin(), pairs.end());
        }
        std::sort(known_.begin(), known_.end());
    });
    const std::vector<FacePair> pairs = faces_->crossings(embedding.points);
    const auto is_new = [this](const FacePair& pair) {
        return !std::binary_search(known_.begin(), known_.end(), pair);
    };
    embedding.report.self_intersections = static_cast<int>(pairs.size());
    embedding.report.new_self_intersections =
        static_cast<int>(std::count_if(pairs.begin(), pairs.end(), is_new));
}

} // namespace shape::internal
