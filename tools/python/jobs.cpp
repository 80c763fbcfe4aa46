// SPDX-License-Identifier: MIT

#include "tools/python/jobs.h"

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "libshape/base/stop.h"

namespace shape::python {
namespace {

namespace py = pybind11;

constexpr auto look_for_signals = std::chrono::milliseconds(40);

/// What the waiting and the working thread share.
struct Job
{
    std::function<void(const Progress&)> work;
    std::atomic<bool> stop = false;

    std::mutex mutex;
    std::condition_variable changed;
    bool is_done = false;
    std::exception_ptr error;
    std::string stage;
    std::size_t done = 0;
    std::size_t total = 0;
    bool has_news = false;
};

void carry_out(Job& job)
{
    std::exception_ptr error;
    const internal::StopScope heed(&job.stop);
    try {
        job.work([&job](std::string_view stage, std::size_t done, std::size_t total) {
            internal::throw_if_stop_requested();
            const std::lock_guard lock(job.mutex);
            job.stage = stage;
            job.done = done;
            job.total = total;
            job.has_news = true;
        });
    } catch (...) {
        error = std::current_exception();
    }
    job.work = nullptr; // what it holds goes here, not where somebody waits
    const std::lock_guard lock(job.mutex);
    job.error = error;
    job.is_done = true;
    job.changed.notify_all();
}

/// Threads that wait for jobs. There are as many as there were jobs at one time: one that was left
/// alone with its work does not hold up the next.
class Workers
{
public:
    void lock() { mutex_.lock(); }
    void unlock() { mutex_.unlock(); }

    /// In the child of a fork, where no thread of these lives on: see libshape/base/threads.cpp.
    void begin_anew() { new (this) Workers; }

    void add(std::shared_ptr<Job> job)
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(job);
        running_.push_back(std::move(job));
        if (idle_ > 0) {
            --idle_;
            wake_.notify_one();
            return;
        }
        std::thread([this] { serve(); }).detach();
    }

    void end()
    {
        std::unique_lock lock(mutex_);
        for (const std::shared_ptr<Job>& job : running_)
            job->stop = true;
        finished_.wait(lock, [this] { return running_.empty(); });
    }

private:
    void serve()
    {
        std::unique_lock lock(mutex_);
        for (;;) {
            if (jobs_.empty()) {
                wake_.wait(lock, [this] { return !jobs_.empty(); });
            }
            const std::shared_ptr<Job> job = jobs_.front();
            jobs_.pop_front();
            lock.unlock();
            carry_out(*job);
            lock.lock();
            running_.remove(job);
            ++idle_;
            finished_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    std::condition_variable finished_;
    std::list<std::shared_ptr<Job>> jobs_;
    std::list<std::shared_ptr<Job>> running_;
    std::size_t idle_ = 0;
};

/// Never destroyed: its threads may outlive everything.
Workers& workers();

Workers* make_workers()
{
    pthread_atfork([] { workers().lock(); }, [] { workers().unlock(); },
                   [] { workers().begin_anew(); });
    return new Workers;
}

Workers& workers()
{
    static auto* const all = make_workers();
    return *all;
}

} // namespace

void run_job(const std::function<void(const Progress&)>& work, const py::object& callback)
{
    const auto job = std::make_shared<Job>();
    job->work = work;
    struct StopIfLeft
    {
        Job& job;
        ~StopIfLeft() { job.stop = true; }
    } const stop_if_left{*job};
    workers().add(job);
    for (;;) {
        bool is_done = false;
        std::optional<py::tuple> news;
        {
            std::string stage;
            std::size_t done = 0;
            std::size_t total = 0;
            bool has_news = false;
            {
                const py::gil_scoped_release release;
                std::unique_lock lock(job->mutex);
                job->changed.wait_for(lock, look_for_signals, [&] { return job->is_done; });
                is_done = job->is_done;
                has_news = std::exchange(job->has_news, false);
                stage = job->stage;
                done = job->done;
                total = job->total;
            }
            if (has_news && !callback.is_none())
                news = py::make_tuple(stage, done, total);
        }
        if (!is_done && PyErr_CheckSignals() != 0)
            throw py::error_already_set();
        if (news && !(is_done && job->error))
            callback(*(*news));
        if (is_done)
            break;
    }
    if (job->error)
        std::rethrow_exception(job->error);
}

void end_jobs()
{
    const py::gil_scoped_release release;
    workers().end();
}

} // namespace shape::python
