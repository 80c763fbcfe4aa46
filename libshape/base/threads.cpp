// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
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
///
/// Its chunks are split into as many shares as threads may run them. A thread begins with the share of its own number, the
/// same in every loop, and goes on with what others have left of theirs: so where loops over the same arrays follow each
/// other, most of what a core reads is what it wrote itself, and lies in its own cache.
class Loop
{
public:
    Loop(std::size_t chunks, int threads, const std::function<void(std::size_t)>& run)
        : chunks_(chunks),
          most_helpers_(threads - 1),
          shares_(std::min({chunks, to_size(threads), most_shares})),
          run_(run),
          errors_(chunks) // NOLINT(bugprone-throw-keyword-missing): none is meant to be thrown
    {
        for (std::size_t i = 0; i < shares_; ++i)
            next_[i].chunk = begin_of(i);
    }

    /// Runs chunks until all are taken, or a stop is requested.
    /// @param helper  Number of the worker; none for the caller, whose share is the first.
    void work(std::optional<std::size_t> helper)
    {
        inside_loop = true;
        const StopScope heed(stop_request_);
        const std::size_t first = helper && shares_ > 1 ? 1 + *helper % (shares_ - 1) : 0;
        for (std::size_t i = 0; i < shares_ && !is_stopped_; ++i)
            work_on((first + i) % shares_);
        inside_loop = false;
    }

    [[nodiscard]] bool wants_help() const
    {
        if (helpers >= most_helpers_ || is_stopped_)
            return false;
        for (std::size_t i = 0; i < shares_; ++i)
            if (next_[i].chunk < begin_of(i + 1))
                return true;
        return false;
    }

    void rethrow_first_error() const
    {
        for (const std::exception_ptr& error : errors_)
            if (error)
                std::rethrow_exception(error);
        if (is_stopped_)
            throw_interrupted();
    }

    /// Workers inside work(); they enter under the lock of the workers.
    std::atomic<int> helpers{0};
    Loop* next_loop = nullptr; ///< Posted before this one.

private:
    [[nodiscard]] std::size_t begin_of(std::size_t share) const
    {
        return share * chunks_ / shares_;
    }

    void work_on(std::size_t share)
    {
        const std::size_t end = begin_of(share + 1);
        for (std::size_t chunk = next_[share].chunk++; chunk < end; chunk = next_[share].chunk++) {
            if (is_stop_requested()) {
                is_stopped_ = true;
                return;
            }
            try {
                run_(chunk);
            } catch (...) {
                errors_[chunk] = std::current_exception();
            }
        }
    }

    /// If there are more threads, some begin with the same share.
    static constexpr std::size_t most_shares = 16;
    /// On a cache line of its own: two threads that count in one line would wait for each other.
    struct alignas(64) Next
    {
        std::atomic<std::size_t> chunk{0};
    };

    std::array<Next, most_shares> next_; ///< Of every share.
    std::size_t chunks_;
    int most_helpers_;
    std::size_t shares_;
    const std::function<void(std::size_t)>& run_;
    std::vector<std::exception_ptr> errors_;
    const std::atomic<bool>* stop_request_ = stop_request; ///< That of the caller.
    std::atomic<bool> is_stopped_{false};
};

/// Lets the other half of a core have its turn.
void pause()
{
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
}

/// Spins for up to 50 microseconds: loops follow each other closely, and to wake a thread costs as much.
template <class Condition>
bool soon(const Condition& condition)
{
    // By the clock, as processors pause for 10 to 60 nanoseconds at a time.
    constexpr auto patience = std::chrono::microseconds(50);
    const auto start = std::chrono::steady_clock::now();
    do {
        for (int i = 0; i < 16; ++i) {
            if (condition())
                return true;
            pause();
        }
    } while (std::chrono::steady_clock::now() - start < patience);
    return condition();
}

/// Spins before it sleeps: a lock of the workers is held for some tens of nanoseconds.
class SoonLocked : public std::unique_lock<std::mutex>
{
public:
    explicit SoonLocked(std::mutex& mutex) : std::unique_lock<std::mutex>(mutex, std::defer_lock)
    {
        lock_soon();
    }

    void lock_soon()
    {
        for (int i = 0; i < 100; ++i) {
            if (try_lock())
                return;
            pause();
        }
        lock();
    }
};

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
            const SoonLocked lock(mutex_);
            start_missing();
            loop.next_loop = loops_;
            loops_ = &loop;
            ++posts_;
        }
        posted_.notify_all();
        loop.work(std::nullopt);
        SoonLocked lock(mutex_);
        Loop** link = &loops_;
        while (*link != &loop)
            link = &(*link)->next_loop;
        *link = loop.next_loop;
        if (loop.helpers == 0)
            return;
        lock.unlock();
        if (soon([&] { return loop.helpers == 0; }))
            return;
        lock.lock();
        ++waiting_;
        left_.wait(lock, [&] { return loop.helpers == 0; });
        --waiting_;
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
                threads_.emplace_back([this, number = threads_.size()] { help(number); });
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

    /// @param number  Of the worker.
    void help(std::size_t number)
    {
        SoonLocked lock(mutex_);
        while (!is_ending_) {
            if (Loop* loop = loop_that_wants_help()) {
                ++loop->helpers;
                lock.unlock();
                loop->work(number);
                // The caller may leave, and the loop be gone, from here on.
                const bool is_last = --loop->helpers == 0;
                lock.lock_soon();
                if (is_last && waiting_ > 0)
                    left_.notify_all();
                continue;
            }
            const unsigned seen = posts_;
            lock.unlock();
            soon([&] { return posts_ != seen; });
            lock.lock_soon();
            posted_.wait(lock, [&] { return is_ending_ || posts_ != seen; });
        }
    }

    std::mutex mutex_;
    std::condition_variable posted_; ///< A loop was posted, or the end has come.
    std::condition_variable left_;   ///< The last helper has left a loop.
    std::atomic<unsigned> posts_{0};
    int waiting_ = 0;       ///< Callers asleep until their last helper has left.
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
    Loop loop(chunks, threads, run);
    workers().run(loop);
    loop.rethrow_first_error();
}

} // namespace shape
