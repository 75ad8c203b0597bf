#include "genus/base/progress.h"

#include <chrono>

#include "genus/base/error.h"

namespace genus {

namespace {

thread_local Progress* t_current = nullptr;

constexpr double kReportInterval = 0.05;  // seconds

}  // namespace

double seconds_now()
{
    using Clock = std::chrono::steady_clock;
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void Progress::check() const
{
    if (cancelled()) throw Cancelled();
}

void Progress::report(const char* stage, double done)
{
    stage_ = stage;
    report(done);
}

void Progress::report(double done)
{
    check();
    if (!listener_) return;
    const double now = seconds_now();
    if (now - last_report_ < kReportInterval) return;
    last_report_ = now;
    listener_(stage_, done);
    check();
}

Progress& current_progress()
{
    thread_local Progress nobody_listens;
    return t_current ? *t_current : nobody_listens;
}

ProgressScope::ProgressScope(Progress& progress) : previous_(t_current)
{
    t_current = &progress;
}

ProgressScope::~ProgressScope()
{
    t_current = previous_;
}

}  // namespace genus
