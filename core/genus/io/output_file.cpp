#include "genus/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"

namespace genus::io {

namespace {

constexpr int kDefaultMode = 0666;  // less what the user's mask takes away

std::string system_text(int code)
{
    return std::generic_category().message(code);
}

// Another name each time, in this process and among processes.
std::string temporary_name(const std::filesystem::path& target)
{
    static std::atomic<unsigned> counter{0};
    const std::string unique = std::to_string(::getpid()) + "-" + std::to_string(counter++);
    // A long name would not leave room for the addition.
    const std::string stem = target.filename().string().substr(0, 128);
    return (target.parent_path() / ("." + stem + "." + unique + ".part")).string();
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path), target_(path)
{
    if (path.empty()) throw FileError(path, "the name of the output file is empty");
    if (path.find('\0') != std::string::npos) throw FileError(path, "has a zero byte in its name");
    struct ::stat status = {};
    if (::stat(path.c_str(), &status) != 0) {
        open_beside(-1);
    } else if (S_ISDIR(status.st_mode)) {
        throw FileError(path, "is a folder");
    } else if (S_ISREG(status.st_mode)) {
        if (::access(path.c_str(), W_OK) != 0)
            throw FileError(path, "cannot be written: " + system_text(errno));
        std::error_code error;
        const auto resolved = std::filesystem::canonical(path, error);
        if (!error) target_ = resolved.string();
        open_beside(static_cast<int>(status.st_mode & 07777));
    } else {
        open_directly();
    }
}

OutputFile::~OutputFile()
{
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::open_beside(int mode)
{
    constexpr int kTries = 100;  // a name may be taken by what an ended process left behind
    for (int i = 0; i < kTries && descriptor_ < 0; ++i) {
        temporary_ = temporary_name(target_);
        descriptor_ =
            ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kDefaultMode);
        if (descriptor_ < 0 && errno != EEXIST) break;
    }
    if (descriptor_ < 0) {
        const int code = errno;
        temporary_.clear();
        const std::string folder = std::filesystem::path(target_).parent_path().string();
        if (code == ENOENT) throw FileError(path_, "the folder '" + folder + "' does not exist");
        throw FileError(path_, "cannot be written: " + system_text(code));
    }
    // File systems without permissions refuse this; then there is nothing to keep.
    if (mode >= 0) static_cast<void>(::fchmod(descriptor_, static_cast<::mode_t>(mode)) == 0);
}

void OutputFile::open_directly()
{
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) throw FileError(path_, "cannot be written: " + system_text(errno));
}

void OutputFile::write(std::span<const char> bytes)
{
    while (!bytes.empty()) {
        const ::ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw FileError(path_, "cannot be written: " + system_text(errno));
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
}

void OutputFile::commit()
{
    // Some file systems tell of a full disk only here.
    if (::close(std::exchange(descriptor_, -1)) != 0)
        throw FileError(path_, "cannot be written: " + system_text(errno));
    if (temporary_.empty()) return;
    if (::rename(temporary_.c_str(), target_.c_str()) != 0)
        throw FileError(path_, "cannot be written: " + system_text(errno));
    temporary_.clear();
}

void OutputBytes::write(std::span<const char> bytes)
{
    const auto raw = std::as_bytes(bytes);
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
}

void write_records(Output& output, std::size_t n, std::size_t grain,
                   const std::function<void(std::size_t, std::size_t, TextBlock&)>& format)
{
    // One block a thread, used again: the bytes stay in the cache until they are handed on.
    std::vector<TextBlock> blocks(static_cast<std::size_t>(thread_count()));
    const std::size_t batch = grain * blocks.size();
    for (std::size_t start = 0; start < n; start += batch) {
        current_progress().check();
        const std::size_t count = std::min(batch, n - start);
        parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
            TextBlock& block = blocks[begin / grain];
            block.clear();
            format(start + begin, start + end, block);
        });
        for (std::size_t i = 0; i * grain < count; ++i) output.write(blocks[i].content());
    }
}

}  // namespace genus::io
