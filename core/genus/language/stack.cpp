#include "genus/language/stack.h"

#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus::language {

namespace {

constexpr std::size_t kLargest = std::size_t{64} << 20;
constexpr std::size_t kSmallest = std::size_t{16} << 20;
// Left for calls that do not check: formatting, allocation, unwinding.
constexpr std::size_t kReserve = std::size_t{1} << 20;

struct Run {
    const std::function<void()>* work;
    Progress* progress;
    std::size_t stack;
    std::exception_ptr error;
    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
};

void* main_of_thread(void* argument)
{
    auto& run = *static_cast<Run*>(argument);
    const auto top = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
    detail::t_stack_limit = top - run.stack + kReserve;
    try {
        const ProgressScope scope(*run.progress);
        (*run.work)();
    } catch (...) {
        run.error = std::current_exception();
    }
    const std::lock_guard lock(run.mutex);
    run.done = true;
    run.ended.notify_one();
    return nullptr;
}

pthread_t start(Run& run)
{
    for (std::size_t stack = kLargest; stack >= kSmallest; stack /= 2) {
        pthread_attr_t attributes;
        pthread_attr_init(&attributes);
        pthread_attr_setstacksize(&attributes, stack);
        // Some of the stack is already taken when main_of_thread starts.
        run.stack = stack - (std::size_t{64} << 10);
        pthread_t thread;
        const int failed = pthread_create(&thread, &attributes, main_of_thread, &run);
        pthread_attr_destroy(&attributes);
        if (!failed) return thread;
    }
    throw Error("no memory for the stack of a text model (16 MB)");
}

}  // namespace

void run_on_large_stack(const char* stage, const std::function<void()>& work)
{
    Run run;
    run.work = &work;
    run.progress = &current_progress();
    const pthread_t thread = start(run);
    std::exception_ptr stopped;
    {
        std::unique_lock lock(run.mutex);
        while (!run.ended.wait_for(lock, std::chrono::milliseconds(50), [&] { return run.done; })) {
            if (stopped) continue;
            lock.unlock();
            try {
                run.progress->report(stage, 0.0);
            } catch (...) {
                // The listener wants to stop: so must the thread.
                stopped = std::current_exception();
                run.progress->cancel();
            }
            lock.lock();
        }
    }
    pthread_join(thread, nullptr);
    if (stopped) std::rethrow_exception(stopped);
    if (run.error) std::rethrow_exception(run.error);
}

}  // namespace genus::language
