#pragma once

#include <cstddef>
#include <functional>

namespace genus {

/// Threads used by `parallel_for`: what `set_thread_count` said, else GENUS_THREADS, else the
/// processors of the machine.
int thread_count();
/// At least 1. Results never depend on it.
void set_thread_count(int threads);

/// Runs `body(begin, end)` over disjoint chunks that cover [0, n), each at most `grain` long.
///
/// The cutting into chunks depends on `n` and `grain` only, so a body that writes to places named
/// by its indices gives the same bits on any number of threads. Chunks run in any order. A chunk
/// is never shared among threads; calls inside a body run on that body's thread. The first
/// exception by chunk number is thrown again here once all threads have stopped; cancelling
/// through current_progress() throws Cancelled.
void parallel_for(std::size_t n, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace genus
