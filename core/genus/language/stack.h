#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace genus::language {

/// Thrown by `check_stack`; whoever knows the place turns it into a ModelError.
struct StackExhausted {};

namespace detail {
inline thread_local std::uintptr_t t_stack_limit = 0;
}

/// Throws StackExhausted when little of the stack of this thread is left. A comparison: cheap
/// enough for every step of an evaluation. Without `run_on_large_stack` it never throws.
inline void check_stack()
{
    const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
    if (here < detail::t_stack_limit) throw StackExhausted();
}

/// Runs `work` on a thread of its own with a stack of at least 16 MB, 64 MB where the system
/// grants it (only what is touched takes memory), and returns when it is done. Exceptions arrive
/// here. While it runs, the progress of the caller is reported under `stage` about 20 times a
/// second; it is the current progress of the new thread too, so cancelling stops both.
void run_on_large_stack(const char* stage, const std::function<void()>& work);

}  // namespace genus::language
