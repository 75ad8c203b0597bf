#include "long_call.h"

#include <pthread.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus::python {

namespace py = pybind11;

namespace {

// Reserved address space, not memory. Trees and text models nest; the main thread's stack is
// whatever the shell says.
constexpr std::size_t kStackBytes = std::size_t{64} << 20;
constexpr std::chrono::milliseconds kPoll{20};
constexpr int kSilentPolls = 10;

struct Call {
    const std::function<void()>* work = nullptr;
    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
    std::exception_ptr error;
    bool has_news = false;
    std::string stage;
    double share = 0.0;
    Progress progress{[this](const std::string& s, double d) {
        const std::lock_guard lock(mutex);
        stage = s;
        share = d;
        has_news = true;
    }};
};

void* run(void* argument)
{
    Call& call = *static_cast<Call*>(argument);
    std::exception_ptr error;
    try {
        const ProgressScope scope(call.progress);
        (*call.work)();
    } catch (...) {
        error = std::current_exception();
    }
    const std::lock_guard lock(call.mutex);
    call.error = error;
    call.done = true;
    call.ended.notify_one();
    return nullptr;
}

class Worker {
public:
    explicit Worker(Call& call)
    {
        pthread_attr_t attributes;
        pthread_attr_init(&attributes);
        pthread_attr_setstacksize(&attributes, kStackBytes);
        const int failure = pthread_create(&thread_, &attributes, run, &call);
        pthread_attr_destroy(&attributes);
        if (failure != 0) throw Error("no thread could be started for the call");
    }
    ~Worker() { pthread_join(thread_, nullptr); }
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

private:
    pthread_t thread_;
};

struct News {
    bool done = false;
    bool has_progress = false;
    std::string stage;
    double share = 0.0;
};

News wait_for_news(Call& call)
{
    const py::gil_scoped_release released;
    std::unique_lock lock(call.mutex);
    call.ended.wait_for(lock, kPoll, [&] { return call.done; });
    News news{call.done, call.has_news, call.stage, call.share};
    call.has_news = false;
    return news;
}

// True if the caller wants the call to go on; else the Python error is in `stop`.
bool ask_caller(const News& news, const py::object& listener, std::exception_ptr& stop)
{
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (news.has_progress && !listener.is_none()) listener(news.stage, news.share);
        return true;
    } catch (py::error_already_set&) {
        stop = std::current_exception();
        return false;
    }
}

}  // namespace

void run_long(const std::function<void()>& work, const py::object& listener)
{
    Call call;
    call.work = &work;
    std::exception_ptr stop;
    {
        const Worker worker(call);
        for (int silent = 0;;) {
            News news = wait_for_news(call);
            if (news.done) break;
            // A listener that shows the time hears of a long step more than once.
            silent = news.has_progress ? 0 : silent + 1;
            if (silent == kSilentPolls && !news.stage.empty()) {
                news.has_progress = true;
                silent = 0;
            }
            if (!stop && !ask_caller(news, listener, stop)) call.progress.cancel();
        }
    }
    if (stop) std::rethrow_exception(stop);
    if (call.error) std::rethrow_exception(call.error);
}

}  // namespace genus::python
