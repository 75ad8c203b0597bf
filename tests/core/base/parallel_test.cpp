#include "genus/base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numeric>
#include <thread>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {
namespace {

// Restores the thread count at the end of a test.
struct Threads {
    explicit Threads(int n) : before(thread_count()) { set_thread_count(n); }
    ~Threads() { set_thread_count(before); }
    int before;
};

TEST(ParallelFor, VisitsEveryIndexOnce)
{
    for (const int threads : {1, 2, 8})
        for (const std::size_t n : {0, 1, 2, 99, 100, 101, 12345}) {
            const Threads scope(threads);
            std::vector<std::atomic<int>> visits(n);
            parallel_for(n, 100, [&](std::size_t begin, std::size_t end) {
                ASSERT_LE(end - begin, 100u);
                for (std::size_t i = begin; i < end; ++i) ++visits[i];
            });
            for (const auto& count : visits) ASSERT_EQ(count, 1);
        }
}

TEST(ParallelFor, GivesTheSameBitsOnAnyNumberOfThreads)
{
    const auto sums = [] {
        std::vector<double> sum(50);
        parallel_for(50, 1, [&](std::size_t begin, std::size_t) {
            for (int k = 1; k < 2000; ++k) sum[begin] += std::sin(double(begin) + 1.0 / k);
        });
        return sum;
    };
    const Threads one(1);
    const auto expected = sums();
    for (const int threads : {2, 8}) {
        const Threads scope(threads);
        EXPECT_EQ(sums(), expected);
    }
}

TEST(ParallelFor, ThrowsTheFirstErrorByChunk)
{
    const Threads scope(8);
    for (int trial = 0; trial < 50; ++trial) {
        try {
            parallel_for(64, 1, [](std::size_t begin, std::size_t) {
                if (begin == 5 || begin > 20) throw InvalidInput(std::to_string(begin));
            });
            FAIL();
        } catch (const InvalidInput& error) {
            ASSERT_STREQ(error.what(), "5");
        }
    }
}

TEST(ParallelFor, NestsOnTheSameThread)
{
    const Threads scope(4);
    std::atomic<int> total{0};
    parallel_for(8, 1, [&](std::size_t, std::size_t) {
        const auto outer = std::this_thread::get_id();
        parallel_for(10, 1, [&](std::size_t, std::size_t) {
            EXPECT_EQ(std::this_thread::get_id(), outer);
            ++total;
        });
    });
    EXPECT_EQ(total, 80);
}

TEST(ParallelFor, StopsWhenCancelled)
{
    for (const int threads : {1, 4}) {
        const Threads scope(threads);
        Progress progress;
        const ProgressScope current(progress);
        std::atomic<int> chunks{0}, late{0};
        std::atomic<bool> cancelled{false};
        EXPECT_THROW(parallel_for(1'000'000, 1,
                                  [&](std::size_t, std::size_t) {
                                      if (cancelled) ++late;
                                      if (++chunks != 10) return;
                                      current_progress().cancel();
                                      cancelled = true;
                                  }),
                     Cancelled);
        // Each other thread may be between its look at the flag and its chunk.
        EXPECT_LE(late, threads - 1);
        EXPECT_GE(chunks, 10);
    }
}

TEST(ParallelFor, TellsHowFarItIs)
{
    const Threads scope(2);
    std::vector<double> heard;
    Progress progress([&](const std::string& stage, double done) {
        EXPECT_EQ(stage, "count");
        heard.push_back(done);
    });
    const ProgressScope current(progress);
    progress.report("count", 0.0);
    parallel_for(20, 1, [](std::size_t, std::size_t) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    });
    ASSERT_GE(heard.size(), 2u);
    EXPECT_TRUE(std::is_sorted(heard.begin(), heard.end()));
    EXPECT_LE(heard.back(), 1.0);
}

TEST(ParallelFor, ServesCallsFromSeveralThreads)
{
    const Threads scope(4);
    std::vector<std::thread> callers;
    std::atomic<long> total{0};
    for (int c = 0; c < 4; ++c)
        callers.emplace_back([&] {
            for (int round = 0; round < 50; ++round)
                parallel_for(100, 7, [&](std::size_t begin, std::size_t end) {
                    total += static_cast<long>(end - begin);
                });
        });
    for (std::thread& caller : callers) caller.join();
    EXPECT_EQ(total, 4 * 50 * 100);
}

TEST(ParallelFor, RefusesBadArguments)
{
    EXPECT_THROW(parallel_for(3, 0, [](std::size_t, std::size_t) {}), InvalidInput);
    EXPECT_THROW(set_thread_count(0), InvalidInput);
}

TEST(Progress, TellsTheListenerAndLetsItStopTheCall)
{
    int reports = 0;
    Progress progress([&](const std::string& stage, double done) {
        EXPECT_EQ(stage, "mesh");
        EXPECT_EQ(done, 0.5);
        ++reports;
        throw Cancelled();
    });
    EXPECT_THROW(progress.report("mesh", 0.5), Cancelled);
    EXPECT_EQ(reports, 1);
    EXPECT_NO_THROW(progress.report("mesh", 0.6));  // within 50 ms: the listener is left alone
}

}  // namespace
}  // namespace genus
