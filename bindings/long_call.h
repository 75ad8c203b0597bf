#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <type_traits>

namespace genus::python {

/// Runs `work` on a thread of its own with a large stack, without the interpreter lock. The
/// calling thread looks every 20 ms for signals and hands news of progress to `listener`, a
/// callable of (stage, done) or None. Ctrl-C, or an exception from the listener, cancels the work
/// and is thrown once it has stopped. Whatever `work` throws is thrown again here.
void run_long(const std::function<void()>& work, const pybind11::object& listener);

template <class Work>
std::invoke_result_t<Work> long_call(Work&& work,
                                     const pybind11::object& listener = pybind11::none())
{
    using Result = std::invoke_result_t<Work>;
    if constexpr (std::is_void_v<Result>) {
        run_long(work, listener);
    } else {
        std::optional<Result> result;
        run_long([&] { result.emplace(work()); }, listener);
        return std::move(*result);
    }
}

}  // namespace genus::python
