// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

std::atomic<int>& configured_threads()
{
    static std::atomic<int> count{
        std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 1024)};
    return count;
}

thread_local bool inside_loop = false; ///< This thread runs a chunk.

/// A loop that its caller has not ended yet; lives on the stack of that caller.
class Loop
{
public:
    Loop(std::size_t chunks, int most_helpers, const std::function<void(std::size_t)>& run)
        : chunks_(chunks),
          most_helpers_(most_helpers),
          run_(run),
          errors_(chunks) // NOLINT(bugprone-throw-keyword-missing): none is meant to be thrown
    {
    }

    /// Runs chunks until all are taken, or a stop is requested.
    void work()
    {
        inside_loop = true;
        const StopScope heed(stop_request_);
        for (std::size_t chunk = next_++; chunk < chunks_; chunk = next_++) {
            if (is_stop_requested()) {
                is_stopped_ = true;
                next_ = chunks_;
                break;
            }
            try {
                run_(chunk);
            } catch (...) {
                errors_[chunk] = std::current_exception();
            }
        }
        inside_loop = false;
    }

    [[nodiscard]] bool wants_help() const { return helpers < most_helpers_ && next_ < chunks_; }

    void rethrow_first_error() const
    {
        for (const std::exception_ptr& error : errors_)
            if (error)
                std::rethrow_exception(error);
        if (is_stopped_)
            throw_interrupted();
    }

    std::atomic<int> helpers{0}; ///< Workers inside work(); changed under the lock of the workers.
    Loop* next_loop = nullptr;   ///< Posted before this one.

private:
    std::atomic<std::size_t> next_{0};
    std::size_t chunks_;
    int most_helpers_;
    const std::function<void(std::size_t)>& run_;
    std::vector<std::exception_ptr> errors_;
    const std::atomic<bool>* stop_request_ = stop_request; ///< That of the caller.
    std::atomic<bool> is_stopped_{false};
};

/// Spins for about 50 microseconds: loops follow each other closely, and to wake a thread costs as much.
template <class Condition>
bool soon(const Condition& condition)
{
    for (int i = 0; i < 1000; ++i) {
        if (condition())
            return true;
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
    return condition();
}

/// The threads that help the callers of loops. A caller never waits for one to start: without any
/// (no memory for a stack, or the limit of processes reached) it does all the work itself, to the
/// same bits. A fork leaves them behind: see Workers::begin_anew().
class Workers
{
public:
    Workers() = default;
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;
    ~Workers()
    {
        {
            const std::lock_guard lock(mutex_);
            is_ending_ = true;
        }
        posted_.notify_all();
        for (std::thread& thread : threads_)
            thread.join();
    }

    void lock() { mutex_.lock(); }
    void unlock() { mutex_.unlock(); }

    /// In the child of a fork, where no worker lives on and the conditions count waiters that are gone: the
    /// old members cannot be destroyed, only left. Threads start with the next loop.
    void begin_anew() { new (this) Workers; }

    void run(Loop& loop)
    {
        {
            const std::lock_guard lock(mutex_);
            start_missing();
            loop.next_loop = loops_;
            loops_ = &loop;
            ++posts_;
        }
        posted_.notify_all();
        loop.work();
        std::unique_lock lock(mutex_);
        Loop** link = &loops_;
        while (*link != &loop)
            link = &(*link)->next_loop;
        *link = loop.next_loop;
        if (loop.helpers == 0)
            return;
        lock.unlock();
        soon([&] { return loop.helpers == 0; });
        lock.lock();
        left_.wait(lock, [&] { return loop.helpers == 0; });
    }

private:
    /// Tries once for each thread_count(): where one thread is refused the next would be too.
    void start_missing()
    {
        const int wanted = thread_count();
        if (wanted == tried_)
            return;
        tried_ = wanted;
        try {
            threads_.reserve(to_size(wanted));
            while (static_cast<int>(threads_.size()) < wanted - 1)
                threads_.emplace_back([this] { help(); });
        } catch (const std::system_error&) {
        } catch (const std::bad_alloc&) {
        }
    }

    [[nodiscard]] Loop* loop_that_wants_help() const
    {
        Loop* loop = loops_;
        while (loop != nullptr && !loop->wants_help())
            loop = loop->next_loop;
        return loop;
    }

    void help()
    {
        std::unique_lock lock(mutex_);
        while (!is_ending_) {
            if (Loop* loop = loop_that_wants_help()) {
                ++loop->helpers;
                lock.unlock();
                loop->work();
                lock.lock();
                if (--loop->helpers ==
                    0) // the caller may leave, and the loop be gone, from here on
                    left_.notify_all();
                continue;
            }
            const unsigned seen = posts_;
            lock.unlock();
            soon([&] { return posts_ != seen; });
            lock.lock();
            posted_.wait(lock, [&] { return is_ending_ || posts_ != seen; });
        }
    }

    std::mutex mutex_;
    std::condition_variable posted_; ///< A loop was posted, or the end has come.
    std::condition_variable left_;   ///< The last helper has left a loop.
    std::atomic<unsigned> posts_{0};
    Loop* loops_ = nullptr; ///< The one posted last.
    bool is_ending_ = false;
    int tried_ = 1; ///< thread_count() for which threads were started.
    std::vector<std::thread> threads_;
};

Workers& workers();

/// Made when the library is loaded: a fork never comes while it is being made. Nobody holds its lock when the
/// process is copied, nor are its lists half changed.
class ForkableWorkers
{
public:
    ForkableWorkers()
    {
        pthread_atfork([] { workers().lock(); }, [] { workers().unlock(); },
                       [] { workers().begin_anew(); });
    }
    Workers all;
};

Workers& workers()
{
    static ForkableWorkers made;
    return made.all;
}

[[maybe_unused]] const Workers& made_at_loading = workers();

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
    const std::function<void(std::size_t)> run = [&](std::size_t chunk) {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
    };
    const int threads = thread_count();
    if (chunks <= 1 || threads == 1 || inside_loop) {
        for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
            throw_if_stop_requested();
            run(chunk);
        }
        return;
    }
    Loop loop(chunks, threads - 1, run);
    workers().run(loop);
    loop.rethrow_first_error();
}

} // namespace shape
