#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace genus::io {

/// Where the writers of the formats put their bytes.
class Output {
public:
    virtual ~Output() = default;
    virtual void write(std::span<const char> bytes) = 0;
    /// What messages call it.
    virtual const std::string& name() const = 0;
};

/// A file that appears whole or not at all: written beside its place under another name and
/// renamed by `commit`; without that it is removed. An existing file is replaced then and keeps
/// its permissions; a symbolic link is followed; a device or a pipe is written to directly.
class OutputFile : public Output {
public:
    /// Throws FileError where the folder is missing or not to be written to.
    explicit OutputFile(const std::string& path);
    ~OutputFile() override;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Throws FileError, of a full disk for instance.
    void write(std::span<const char> bytes) override;
    void commit();
    const std::string& name() const override { return path_; }

private:
    void open_beside(int mode);
    void open_directly();

    std::string path_;
    std::string target_;     // path_ with symbolic links resolved
    std::string temporary_;  // empty where the target is written directly
    int descriptor_ = -1;
};

/// Bytes in memory.
class OutputBytes : public Output {
public:
    explicit OutputBytes(std::string name) : name_(std::move(name)) {}
    void write(std::span<const char> bytes) override;
    const std::string& name() const override { return name_; }
    std::vector<std::byte> take() && { return std::move(bytes_); }

private:
    std::string name_;
    std::vector<std::byte> bytes_;
};

/// A block of output that grows by small pieces.
class TextBlock {
public:
    /// Room for `n` more characters, at the returned place; `advance_to` says how far it was used.
    char* room(std::size_t n)
    {
        if (bytes_.size() - used_ < n) bytes_.resize(2 * bytes_.size() + n);
        return bytes_.data() + used_;
    }
    void advance_to(const char* end) { used_ = static_cast<std::size_t>(end - bytes_.data()); }
    void clear() { used_ = 0; }
    std::span<const char> content() const { return {bytes_.data(), used_}; }

private:
    std::vector<char> bytes_;
    std::size_t used_ = 0;
};

/// Writes `n` records: `format(begin, end, block)` puts those of a chunk into `block`; chunks are
/// formatted on all threads and written in their order. Can be cancelled.
void write_records(Output& output, std::size_t n, std::size_t grain,
                   const std::function<void(std::size_t, std::size_t, TextBlock&)>& format);

}  // namespace genus::io
