// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
namespace {

std::atomic<int>& configured_threads()
{
    static std::atomic<int> count{
        std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 1024)};
    return count;
}

thread_local bool inside_loop = false; ///< This thread runs a chunk.

/// Tells the processor that a thread waits in a loop.
void pause()
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/// The threads that work on loops: the caller and others, which wait for the next loop between two.
///
/// Every thread has a share of the chunks, next to each other and the same in every loop over as
/// many, so that it finds in its cache what it wrote there in the loop before. Whoever is done helps
/// the others; threads that do not come in time find nothing left to do, and cost no waiting.
class Crew
{
public:
    explicit Crew(int threads) : shares_(static_cast<std::size_t>(threads))
    {
        for (std::size_t own = 1; own < shares_.size(); ++own)
            helpers_.emplace_back([this, own] { wait_and_work(own); });
    }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;
    ~Crew()
    {
        stopped_ = true;
        call();
        for (std::thread& helper : helpers_)
            helper.join();
    }

    [[nodiscard]] int threads() const { return static_cast<int>(shares_.size()); }

    /// Runs work(chunk), which must not throw, for all chunks. False if the crew is busy.
    [[nodiscard]] bool run(std::size_t chunks, const std::function<void(std::size_t)>& work)
    {
        const std::unique_lock lock(busy_, std::try_to_lock);
        if (!lock)
            return false;
        work_ = &work;
        unfinished_.store(chunks, std::memory_order_relaxed);
        for (std::size_t i = 0; i < shares_.size(); ++i) {
            const std::size_t begin = chunks * i / shares_.size();
            shares_[i].end = chunks * (i + 1) / shares_.size();
            shares_[i].left.store(static_cast<std::ptrdiff_t>(shares_[i].end - begin),
                                  std::memory_order_release);
        }
        call();
        work_on(0);
        for (int i = 0; unfinished_.load(std::memory_order_acquire) > 0; ++i)
            i < patience ? pause() : std::this_thread::yield();
        return true;
    }

private:
    static constexpr int patience = 1000; ///< Pauses, about 50 us: waking a thread takes longer.

    /// Whoever lowers `left` from above 0 has a chunk. Until that is finished no other loop begins,
    /// so a thread that comes late never sees half of a loop.
    struct alignas(64) Share
    {
        std::atomic<std::ptrdiff_t> left{0};
        std::size_t end = 0; ///< Of its chunks.
    };

    void call()
    {
        ++round_;
        round_.notify_all();
    }

    void work_on(std::size_t own)
    {
        for (std::size_t i = 0; i < shares_.size(); ++i) {
            Share& share = shares_[(own + i) % shares_.size()];
            while (share.left.load(std::memory_order_relaxed) > 0) {
                const std::ptrdiff_t left = share.left.fetch_sub(1, std::memory_order_acquire);
                if (left <= 0)
                    break;
                (*work_)(share.end - static_cast<std::size_t>(left));
                unfinished_.fetch_sub(1, std::memory_order_release);
            }
        }
    }

    void wait_and_work(std::size_t own)
    {
        while (!stopped_) {
            const int round = round_;
            work_on(own);
            for (int i = 0; i < patience && round_ == round; ++i)
                pause();
            round_.wait(round);
        }
    }

    std::vector<Share> shares_;
    const std::function<void(std::size_t)>* work_ = nullptr;
    std::atomic<std::size_t> unfinished_{0}; ///< Chunks.
    std::atomic<int> round_{0};
    std::atomic<bool> stopped_{false};
    std::mutex busy_;
    std::vector<std::thread> helpers_; ///< They use all the others.
};

/// Made anew after set_thread_count().
std::shared_ptr<Crew> crew()
{
    static std::mutex mutex;
    static std::shared_ptr<Crew> current;
    const std::lock_guard lock(mutex);
    if (!current || current->threads() != thread_count())
        current = std::make_shared<Crew>(thread_count());
    return current;
}

} // namespace

int thread_count()
{
    return configured_threads();
}

void set_thread_count(int count)
{
    if (count < 1 || count > 1024)
        throw InvalidInput(join("thread count is ", count, ", must be in [1, 1024]"));
    configured_threads() = count;
}

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body)
{
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t chunks = (count + grain - 1) / grain;
    const auto run = [&](std::size_t chunk) {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
    };
    if (chunks > 1 && thread_count() > 1 && !inside_loop) {
        std::mutex mutex;
        std::exception_ptr error; // of the lowest chunk
        std::size_t failed = chunks;
        const auto guarded = [&](std::size_t chunk) {
            inside_loop = true;
            try {
                run(chunk);
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (chunk < failed) {
                    failed = chunk;
                    error = std::current_exception();
                }
            }
            inside_loop = false;
        };
        if (crew()->run(chunks, guarded)) {
            if (error)
                std::rethrow_exception(error);
            return;
        }
    }
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
        run(chunk);
}

double parallel_sum(std::size_t count, std::size_t grain,
                    const std::function<double(std::size_t, std::size_t)>& term)
{
    grain = std::max<std::size_t>(grain, 1);
    std::vector<double> parts((count + grain - 1) / grain, 0.0);
    parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        parts[begin / grain] = term(begin, end);
    });
    double sum = 0.0;
    for (double part : parts)
        sum += part;
    return sum;
}

} // namespace shape
