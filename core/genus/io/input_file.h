#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

namespace genus::io {

/// Memory without initial value, in large pages where the system has them.
class PageBuffer {
public:
    PageBuffer() = default;
    /// Throws std::bad_alloc.
    explicit PageBuffer(std::size_t size);
    PageBuffer(PageBuffer&& other) noexcept;
    PageBuffer& operator=(PageBuffer&& other) noexcept;
    ~PageBuffer();

    std::byte* data() { return data_; }
    const std::byte* data() const { return data_; }
    std::size_t size() const { return size_; }

private:
    std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

/// The whole of a file, read once. (A mapped file would end the program, not the call, if another
/// program cuts the file short meanwhile.)
class InputFile {
public:
    /// Files and pipes. Throws FileError where `path` is missing, a folder, or not to be read.
    explicit InputFile(const std::string& path);

    std::span<const std::byte> bytes() const { return {buffer_.data(), size_}; }

private:
    void read_regular(int descriptor, const std::string& path, std::size_t size);
    void read_stream(int descriptor, const std::string& path);

    PageBuffer buffer_;
    std::size_t size_ = 0;
};

}  // namespace genus::io
