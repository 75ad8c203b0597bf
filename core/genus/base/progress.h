#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace genus {

/// What a long call tells its caller, and how the caller stops it. One object serves one call at
/// a time; `cancel()` may come from any thread or from a signal handler.
class Progress {
public:
    /// Called on the thread that runs the call, at most every 50 ms, with the stage and its share
    /// done in [0, 1]; a stage of several loops begins again with each. May throw to stop the call.
    using Listener = std::function<void(const std::string& stage, double done)>;

    Progress() = default;
    explicit Progress(Listener listener) : listener_(std::move(listener)) {}

    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

    /// Throws Cancelled once `cancel()` was called. Cheap: call it in every outer loop, so that
    /// no more than a tenth of a second passes between two calls.
    void check() const;

    /// Tells the listener, then checks. Only from the calling thread, not inside parallel_for.
    void report(const char* stage, double done);
    /// The same for the stage that was named last; parallel_for does it after every chunk.
    void report(double done);

private:
    Listener listener_;
    std::atomic<bool> cancelled_{false};
    const char* stage_ = "";  // a literal
    double last_report_ = -1.0;
};

/// Seconds on a clock that never goes back.
double seconds_now();

/// The progress of the call in which this thread runs; never null. `parallel_for` hands it on to
/// its workers. Deep code says `current_progress().check()`.
Progress& current_progress();

/// Makes `progress` the current one of this thread for the life of the scope.
class ProgressScope {
public:
    explicit ProgressScope(Progress& progress);
    ~ProgressScope();
    ProgressScope(const ProgressScope&) = delete;
    ProgressScope& operator=(const ProgressScope&) = delete;

private:
    Progress* previous_;
};

}  // namespace genus
