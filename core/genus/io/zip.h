#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "genus/io/output_file.h"

namespace genus::io {

/// The files in a ZIP archive [pkware2022], stored or deflated, also in its 64-bit form. Only the
/// directory at the end is read at first. Throws FileError with the byte of a mistake.
class ZipArchive {
public:
    ZipArchive(std::span<const std::byte> content, const std::string& name);

    struct Entry {
        std::string name;  // without a leading slash
        std::uint16_t method = 0;
        std::uint32_t checksum = 0;
        std::uint64_t packed_size = 0;
        std::uint64_t size = 0;
        std::uint64_t offset = 0;
    };

    const std::vector<Entry>& entries() const { return entries_; }
    /// By name, in either case, with or without a leading slash; null where there is none.
    const Entry* find(std::string_view name) const;

    /// Hands the unpacked bytes to `sink` piece by piece. Stops with a FileError at more than a
    /// hundred times the packed size (and 64 MB): meshes do not pack so well, bombs do.
    void unpack(const Entry& entry, const std::function<void(std::span<const char>)>& sink) const;

private:
    void read_directory();
    void read_entry(std::size_t& at);
    std::uint64_t number(std::size_t at, std::size_t bytes) const;
    std::span<const std::byte> packed_bytes(const Entry& entry) const;
    [[noreturn]] void fail(std::uint64_t byte, const std::string& problem) const;

    std::span<const std::byte> content_;
    const std::string& name_;
    std::vector<Entry> entries_;
};

/// Writes such an archive. Entries are packed in memory; their date is the first one the format
/// knows, so that the same mesh gives the same bytes.
class ZipWriter {
public:
    explicit ZipWriter(Output& output) : output_(output) {}

    /// Adds a file with what `write` puts out. Throws FileError beyond 4 GB.
    void add(const std::string& name, const std::function<void(Output&)>& write);
    void finish();

private:
    struct Entry {
        std::string name;
        std::uint32_t checksum;
        std::uint32_t packed_size;
        std::uint32_t size;
        std::uint32_t offset;
    };
    void put(std::span<const char> bytes);

    Output& output_;
    std::vector<Entry> entries_;
    std::uint64_t offset_ = 0;
};

}  // namespace genus::io
