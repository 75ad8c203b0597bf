#include "genus/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr int kMaxThreads = 256;

int initial_thread_count()
{
    if (const char* text = std::getenv("GENUS_THREADS")) {
        const int asked = std::atoi(text);
        if (asked >= 1) return std::min(asked, kMaxThreads);
    }
    return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
}

std::atomic<int>& thread_setting()
{
    static std::atomic<int> setting{initial_thread_count()};
    return setting;
}

thread_local bool t_inside_body = false;

// One call of parallel_for: chunks are handed out by a counter.
struct Job {
    std::size_t n;
    std::size_t grain;
    const std::function<void(std::size_t, std::size_t)>* body;
    Progress* progress;
    std::size_t n_chunks;

    std::atomic<std::size_t> next{0};
    std::atomic<bool> failed{false};
    std::mutex mutex{};
    std::exception_ptr error{};
    std::size_t error_chunk = 0;

    void keep_first_error(std::size_t chunk)
    {
        const std::lock_guard lock(mutex);
        failed.store(true, std::memory_order_relaxed);
        if (error && error_chunk < chunk) return;
        error = std::current_exception();
        error_chunk = chunk;
    }

    /// The thread that called parallel_for also tells how far the work is.
    void work(bool is_caller)
    {
        const ProgressScope scope(*progress);
        const bool outer = std::exchange(t_inside_body, true);
        while (!failed.load(std::memory_order_relaxed)) {
            const std::size_t chunk = next.fetch_add(1);
            if (chunk >= n_chunks) break;
            try {
                progress->check();
                (*body)(chunk * grain, std::min(n, (chunk + 1) * grain));
                if (is_caller && !outer)
                    progress->report(static_cast<double>(chunk + 1) /
                                     static_cast<double>(n_chunks));
            } catch (...) {
                keep_first_error(chunk);
            }
        }
        t_inside_body = outer;
    }
};

// Workers wait for a job and all take part in it. Started on first need, joined at exit.
class Pool {
public:
    ~Pool()
    {
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
        }
        wake_.notify_all();
        for (std::thread& worker : workers_) worker.join();
    }

    /// Runs `job` on the calling thread and up to `helpers` workers. One job at a time: a second
    /// caller does its work alone.
    void run(Job& job, int helpers)
    {
        const std::unique_lock busy(one_job_, std::try_to_lock);
        if (!busy.owns_lock() || helpers == 0) {
            job.work(true);
            return;
        }
        {
            const std::lock_guard lock(mutex_);
            while (static_cast<int>(workers_.size()) < helpers)
                workers_.emplace_back([this] { serve(); });
            job_ = &job;
            wanted_ = helpers;
        }
        wake_.notify_all();
        job.work(true);
        std::unique_lock lock(mutex_);
        wanted_ = 0;
        idle_.wait(lock, [this] { return active_ == 0; });
        job_ = nullptr;
    }

private:
    void serve()
    {
        std::unique_lock lock(mutex_);
        while (true) {
            wake_.wait(lock, [this] { return stopping_ || wanted_ > 0; });
            if (stopping_) return;
            --wanted_;
            ++active_;
            Job* job = job_;
            lock.unlock();
            job->work(false);
            lock.lock();
            if (--active_ == 0) idle_.notify_all();
        }
    }

    std::mutex one_job_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::condition_variable idle_;
    std::vector<std::thread> workers_;
    Job* job_ = nullptr;
    int wanted_ = 0;
    int active_ = 0;
    bool stopping_ = false;
};

Pool& pool()
{
    static Pool instance;
    return instance;
}

}  // namespace

int thread_count()
{
    return thread_setting().load();
}

void set_thread_count(int threads)
{
    require(threads >= 1 && threads <= kMaxThreads, "set_thread_count: threads", threads,
            "between 1 and 256");
    thread_setting().store(threads);
}

void parallel_for(std::size_t n, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body)
{
    require(grain > 0, "parallel_for: grain is 0, must be positive");
    if (n == 0) return;
    Job job{n, grain, &body, &current_progress(), (n - 1) / grain + 1};
    const auto helpers = std::min<std::size_t>(thread_count(), job.n_chunks) - 1;
    if (helpers == 0 || t_inside_body)
        job.work(true);
    else
        pool().run(job, static_cast<int>(helpers));
    if (job.error) std::rethrow_exception(job.error);
}

}  // namespace genus
