#pragma once

#include <string>
#include <utility>
#include <vector>

#include "genus/base/progress.h"

namespace genus {

/// Numbers by name, in the order of their first mention.
using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// The number of that name, a new one being 0.
inline double& entry(NamedNumbers& numbers, const std::string& name)
{
    for (auto& [known, number] : numbers)
        if (known == name) return number;
    return numbers.emplace_back(name, 0.0).second;
}

/// Adds the seconds since construction, or since the last call, to a named stage.
class StageClock {
public:
    explicit StageClock(NamedNumbers& stages) : stages_(stages), last_(seconds_now()) {}

    void end(const char* stage)
    {
        const double now = seconds_now();
        entry(stages_, stage) += now - last_;
        last_ = now;
    }

private:
    NamedNumbers& stages_;
    double last_;
};

}  // namespace genus
