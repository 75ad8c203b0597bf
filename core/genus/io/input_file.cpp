#include "genus/io/input_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"

namespace genus::io {

namespace {

constexpr std::size_t kReadBytes = std::size_t{8} << 20;  // of one call to the system

std::string system_text(int code)
{
    return std::generic_category().message(code);
}

class Descriptor {
public:
    explicit Descriptor(int value) : value_(value) {}
    ~Descriptor()
    {
        if (value_ >= 0) ::close(value_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int value() const { return value_; }

private:
    int value_;
};

// Fills [begin, end) from the same place of the file; the number of bytes that were there.
std::size_t read_range(int descriptor, const std::string& path, std::byte* begin, std::byte* end,
                       std::size_t offset)
{
    std::byte* p = begin;
    while (p != end) {
        const ::ssize_t n =
            ::pread(descriptor, p, static_cast<std::size_t>(end - p),
                    static_cast<::off_t>(offset + static_cast<std::size_t>(p - begin)));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw FileError(path, "cannot be read: " + system_text(errno));
        if (n == 0) break;
        p += n;
    }
    return static_cast<std::size_t>(p - begin);
}

}  // namespace

PageBuffer::PageBuffer(std::size_t size) : size_(size)
{
    if (size == 0) return;
    void* memory =
        ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<std::byte*>(memory);
#ifdef MADV_HUGEPAGE
    ::madvise(memory, size, MADV_HUGEPAGE);  // a hint: without it the pages are small
#endif
}

PageBuffer::PageBuffer(PageBuffer&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0))
{
}

PageBuffer& PageBuffer::operator=(PageBuffer&& other) noexcept
{
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
}

PageBuffer::~PageBuffer()
{
    if (data_ != nullptr) ::munmap(data_, size_);
}

InputFile::InputFile(const std::string& path)
{
    if (path.find('\0') != std::string::npos) throw FileError(path, "has a zero byte in its name");
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.value() < 0) throw FileError(path, "cannot be opened: " + system_text(errno));
    struct ::stat status = {};
    if (::fstat(file.value(), &status) != 0)
        throw FileError(path, "cannot be read: " + system_text(errno));
    if (S_ISDIR(status.st_mode)) throw FileError(path, "is a folder");
    if (S_ISREG(status.st_mode))
        read_regular(file.value(), path, static_cast<std::size_t>(status.st_size));
    else if (S_ISFIFO(status.st_mode))
        read_stream(file.value(), path);
    else
        throw FileError(path, "is neither a file nor a pipe");
}

void InputFile::read_regular(int descriptor, const std::string& path, std::size_t size)
{
    buffer_ = PageBuffer(size);
    std::atomic<std::size_t> total{0};
    parallel_for(size, kReadBytes, [&](std::size_t begin, std::size_t end) {
        total += read_range(descriptor, path, buffer_.data() + begin, buffer_.data() + end, begin);
    });
    // Less than `size` where someone shortened the file meanwhile: what is then missing is
    // found missing by the reader of the format.
    size_ = total;
}

void InputFile::read_stream(int descriptor, const std::string& path)
{
    while (true) {
        current_progress().check();
        if (buffer_.size() - size_ < kReadBytes) {
            PageBuffer larger(2 * buffer_.size() + kReadBytes);
            if (size_ > 0) std::memcpy(larger.data(), buffer_.data(), size_);
            buffer_ = std::move(larger);
        }
        const ::ssize_t n = ::read(descriptor, buffer_.data() + size_, kReadBytes);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw FileError(path, "cannot be read: " + system_text(errno));
        if (n == 0) return;
        size_ += static_cast<std::size_t>(n);
    }
}

}  // namespace genus::io
