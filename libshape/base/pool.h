// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace shape::internal {

/// Objects whose memory serves again and again, for one caller at a time each; as many are made as
/// callers work at once. Fresh memory often costs more than what is done in it.
template <class T>
class Pool
{
public:
    Pool() : Pool([] { return std::make_unique<T>(); }) {}
    explicit Pool(std::function<std::unique_ptr<T>()> make) : make_(std::move(make)) {}

    /// One that nobody else has until the pointer is destroyed, which must be before the pool is. Safe to
    /// call concurrently.
    [[nodiscard]] auto borrow()
    {
        auto give_back = [this](T* item) {
            const std::lock_guard lock(mutex_);
            idle_.emplace_back(item);
        };
        return std::unique_ptr<T, decltype(give_back)>(take().release(), give_back);
    }

private:
    std::unique_ptr<T> take()
    {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<T> item = std::move(idle_.back());
                idle_.pop_back();
                return item;
            }
        }
        return make_();
    }

    std::function<std::unique_ptr<T>()> make_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> idle_;
};

} // namespace shape::internal
