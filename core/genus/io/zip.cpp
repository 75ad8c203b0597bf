#include "genus/io/zip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/pack.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr std::uint64_t kEndRecord = 0x06054B50;
constexpr std::uint64_t kEndLocator64 = 0x07064B50;
constexpr std::uint64_t kEndRecord64 = 0x06064B50;
constexpr std::uint64_t kDirectoryEntry = 0x02014B50;
constexpr std::uint64_t kLocalHeader = 0x04034B50;

constexpr std::size_t kEndBytes = 22;
constexpr std::size_t kMostComment = 65535;
constexpr std::size_t kDirectoryEntryBytes = 46;
constexpr std::size_t kLocalBytes = 30;
constexpr std::uint16_t kStored = 0;
constexpr std::uint16_t kDeflated = 8;
constexpr std::uint64_t kIn64 = 0xFFFFFFFF;  // the number stands in the 64-bit field

constexpr std::uint64_t kAlwaysAllowed = std::uint64_t{64} << 20;
constexpr std::uint64_t kLargestRatio = 100;
constexpr std::size_t kPiece = std::size_t{1} << 16;

std::string plain_name(std::string_view name)
{
    while (name.starts_with('/')) name.remove_prefix(1);
    return std::string(name);
}

bool equal_names(std::string_view a, std::string_view b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return to_lower(x) == to_lower(y); });
}

// zlib in the raw form without a header of its own.
class Inflater {
public:
    Inflater()
    {
        if (::inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
    }
    ~Inflater() { ::inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    ::z_stream stream = {};
};

// Packs what is written to it.
class Deflater : public Output {
public:
    explicit Deflater(const std::string& name) : name_(name)
    {
        constexpr int level = 5;
        constexpr int memory = 8;
        if (::deflateInit2(&stream_, level, Z_DEFLATED, -MAX_WBITS, memory, Z_DEFAULT_STRATEGY) !=
            Z_OK)
            throw std::bad_alloc();
        checksum_ = ::crc32(0, nullptr, 0);
    }
    ~Deflater() override { ::deflateEnd(&stream_); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    void write(std::span<const char> bytes) override
    {
        for (; !bytes.empty(); bytes = bytes.subspan(std::min(bytes.size(), kPiece))) {
            const auto piece = bytes.first(std::min(bytes.size(), kPiece));
            // zlib does not write to its input, but an old declaration says it could.
            auto* data = reinterpret_cast<::Bytef*>(const_cast<char*>(piece.data()));
            checksum_ = ::crc32(checksum_, data, static_cast<::uInt>(piece.size()));
            size_ += piece.size();
            stream_.next_in = data;
            stream_.avail_in = static_cast<::uInt>(piece.size());
            run(Z_NO_FLUSH);
        }
    }
    void finish() { run(Z_FINISH); }
    const std::string& name() const override { return name_; }

    std::uint32_t checksum() const { return static_cast<std::uint32_t>(checksum_); }
    std::uint64_t size() const { return size_; }
    std::span<const char> packed() const { return packed_; }

private:
    void run(int flush)
    {
        do {
            char buffer[kPiece];
            stream_.next_out = reinterpret_cast<::Bytef*>(buffer);
            stream_.avail_out = kPiece;
            ::deflate(&stream_, flush);
            packed_.insert(packed_.end(), buffer, buffer + (kPiece - stream_.avail_out));
        } while (stream_.avail_out == 0);
    }

    const std::string& name_;
    ::z_stream stream_ = {};
    ::uLong checksum_ = 0;
    std::uint64_t size_ = 0;
    std::vector<char> packed_;
};

// Fields one after the other, the lower byte first.
class Fields {
public:
    Fields& two(std::uint64_t value) { return add(value, 2); }
    Fields& four(std::uint64_t value) { return add(value, 4); }
    Fields& text(const std::string& value)
    {
        bytes_.insert(bytes_.end(), value.begin(), value.end());
        return *this;
    }
    std::span<const char> bytes() const { return bytes_; }

private:
    Fields& add(std::uint64_t value, std::size_t n)
    {
        for (std::size_t i = 0; i < n; ++i)
            bytes_.push_back(static_cast<char>(value >> 8 * i & 0xFF));
        return *this;
    }
    std::vector<char> bytes_;
};

constexpr std::uint64_t kVersion = 20;  // of the format that an unpacker must know
constexpr std::uint64_t kUtf8Names = 0x800;
constexpr std::uint64_t kFirstDate = 0x21;  // 1 January 1980

}  // namespace

ZipArchive::ZipArchive(std::span<const std::byte> content, const std::string& name)
    : content_(content), name_(name)
{
    read_directory();
}

void ZipArchive::fail(std::uint64_t byte, const std::string& problem) const
{
    throw FileError(name_, problem, FileError::at_byte(static_cast<std::int64_t>(byte)));
}

// The number of `bytes` bytes at `at`.
std::uint64_t ZipArchive::number(std::size_t at, std::size_t bytes) const
{
    if (at > content_.size() || content_.size() - at < bytes)
        fail(content_.size(), "the ZIP archive ends too soon");
    std::uint64_t value = 0;
    for (std::size_t i = bytes; i-- > 0;)
        value = value << 8 | std::to_integer<std::uint64_t>(content_[at + i]);
    return value;
}

void ZipArchive::read_directory()
{
    if (content_.size() < kEndBytes) fail(content_.size(), "the ZIP archive ends too soon");
    std::size_t end = content_.size() - kEndBytes;
    const std::size_t last = end > kMostComment ? end - kMostComment : 0;
    while (number(end, 4) != kEndRecord)
        if (end-- == last) fail(content_.size(), "the directory of the ZIP archive is missing");
    std::uint64_t count = number(end + 10, 2);
    std::uint64_t at = number(end + 16, 4);
    if (end >= 20 && number(end - 20, 4) == kEndLocator64) {
        const std::uint64_t record = number(end - 20 + 8, 8);
        if (record > content_.size() || number(record, 4) != kEndRecord64)
            fail(end - 20, "the 64-bit directory of the ZIP archive is missing");
        count = number(record + 32, 8);
        at = number(record + 48, 8);
    }
    if (at > end || count > (end - at) / kDirectoryEntryBytes)
        fail(end, "the ZIP archive is too short for its directory");
    std::size_t position = at;
    for (std::uint64_t i = 0; i < count; ++i) read_entry(position);
}

void ZipArchive::read_entry(std::size_t& at)
{
    if (number(at, 4) != kDirectoryEntry) fail(at, "the directory of the ZIP archive is damaged");
    Entry entry;
    const bool encrypted = (number(at + 8, 2) & 1) != 0;
    entry.method = static_cast<std::uint16_t>(number(at + 10, 2));
    entry.checksum = static_cast<std::uint32_t>(number(at + 16, 4));
    entry.packed_size = number(at + 20, 4);
    entry.size = number(at + 24, 4);
    entry.offset = number(at + 42, 4);
    const std::size_t name_bytes = number(at + 28, 2);
    const std::size_t extra_bytes = number(at + 30, 2);
    const std::size_t comment_bytes = number(at + 32, 2);
    const std::size_t name_at = at + kDirectoryEntryBytes;
    const std::size_t next = name_at + name_bytes + extra_bytes + comment_bytes;
    if (next > content_.size()) fail(at, "the directory of the ZIP archive is damaged");
    entry.name = plain_name({reinterpret_cast<const char*>(content_.data()) + name_at, name_bytes});
    if (encrypted) fail(at, "the ZIP archive is encrypted");
    // Extra fields are a kind, a length, and that many bytes; kind 1 has the 64-bit numbers of
    // those fields above that are full, in this order.
    for (std::size_t e = name_at + name_bytes; e + 4 <= name_at + name_bytes + extra_bytes;) {
        const std::size_t length = number(e + 2, 2);
        if (number(e, 2) == 1) {
            std::size_t field = e + 4;
            for (std::uint64_t* value : {&entry.size, &entry.packed_size, &entry.offset}) {
                if (*value != kIn64) continue;
                *value = number(field, 8);
                field += 8;
            }
        }
        e += 4 + length;
    }
    entries_.push_back(std::move(entry));
    at = next;
}

const ZipArchive::Entry* ZipArchive::find(std::string_view name) const
{
    const std::string wanted = plain_name(name);
    for (const Entry& entry : entries_)
        if (equal_names(entry.name, wanted)) return &entry;
    return nullptr;
}

std::span<const std::byte> ZipArchive::packed_bytes(const Entry& entry) const
{
    if (entry.offset > content_.size() || number(entry.offset, 4) != kLocalHeader)
        fail(std::min<std::uint64_t>(entry.offset, content_.size()),
             "the entry '" + entry.name + "' of the ZIP archive is not where it should be");
    const std::uint64_t data =
        entry.offset + kLocalBytes + number(entry.offset + 26, 2) + number(entry.offset + 28, 2);
    if (data > content_.size() || content_.size() - data < entry.packed_size)
        fail(entry.offset, "the entry '" + entry.name + "' is longer than the ZIP archive");
    return content_.subspan(data, entry.packed_size);
}

void ZipArchive::unpack(const Entry& entry,
                        const std::function<void(std::span<const char>)>& sink) const
{
    const std::span<const std::byte> packed = packed_bytes(entry);
    const auto spoiled = [&](const char* problem) {
        fail(entry.offset, "the entry '" + entry.name + "' of the ZIP archive " + problem);
    };
    if (entry.method == kStored) {
        const auto* data = reinterpret_cast<const ::Bytef*>(packed.data());
        if (::crc32_z(0, data, packed.size()) != entry.checksum) spoiled("is damaged");
        sink({reinterpret_cast<const char*>(packed.data()), packed.size()});
        return;
    }
    if (entry.method != kDeflated) spoiled("is packed by a method that is not read");
    const std::uint64_t most = std::max(kAlwaysAllowed, kLargestRatio * packed.size());
    Inflater inflater;
    std::vector<char> buffer(kPiece);
    ::uLong checksum = ::crc32(0, nullptr, 0);
    std::uint64_t total = 0;
    std::size_t fed = 0;
    for (int status = Z_OK; status != Z_STREAM_END;) {
        current_progress().check();
        if (inflater.stream.avail_in == 0) {
            const std::size_t n = std::min(packed.size() - fed, kPiece);
            // zlib does not write to its input, but an old declaration says it could.
            inflater.stream.next_in =
                reinterpret_cast<::Bytef*>(const_cast<std::byte*>(packed.data() + fed));
            inflater.stream.avail_in = static_cast<::uInt>(n);
            fed += n;
        }
        inflater.stream.next_out = reinterpret_cast<::Bytef*>(buffer.data());
        inflater.stream.avail_out = static_cast<::uInt>(buffer.size());
        status = ::inflate(&inflater.stream, Z_NO_FLUSH);
        const std::size_t n = buffer.size() - inflater.stream.avail_out;
        if (status != Z_OK && status != Z_STREAM_END) spoiled("is damaged");
        if (n == 0 && inflater.stream.avail_in == 0 && fed == packed.size() &&
            status != Z_STREAM_END)
            spoiled("is damaged");
        checksum =
            ::crc32(checksum, reinterpret_cast<::Bytef*>(buffer.data()), static_cast<::uInt>(n));
        total += n;
        if (total > most) spoiled("unpacks to far more than its size");
        sink({buffer.data(), n});
    }
    if (static_cast<std::uint32_t>(checksum) != entry.checksum) spoiled("is damaged");
}

void ZipWriter::put(std::span<const char> bytes)
{
    output_.write(bytes);
    offset_ += bytes.size();
}

void ZipWriter::add(const std::string& name, const std::function<void(Output&)>& write)
{
    Deflater deflater(output_.name());
    write(deflater);
    deflater.finish();
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (deflater.size() > most || offset_ + deflater.packed().size() + 65536 > most)
        throw FileError(output_.name(), "more than the 4 GB that a ZIP archive can hold");
    const Entry entry = {
        name, deflater.checksum(), static_cast<std::uint32_t>(deflater.packed().size()),
        static_cast<std::uint32_t>(deflater.size()), static_cast<std::uint32_t>(offset_)};
    Fields header;
    header.four(kLocalHeader).two(kVersion).two(kUtf8Names).two(kDeflated).two(0).two(kFirstDate);
    header.four(entry.checksum).four(entry.packed_size).four(entry.size);
    header.two(name.size()).two(0).text(name);
    put(header.bytes());
    put(deflater.packed());
    entries_.push_back(entry);
}

void ZipWriter::finish()
{
    const std::uint64_t start = offset_;
    for (const Entry& entry : entries_) {
        Fields record;
        record.four(kDirectoryEntry).two(kVersion).two(kVersion).two(kUtf8Names).two(kDeflated);
        record.two(0).two(kFirstDate).four(entry.checksum).four(entry.packed_size).four(entry.size);
        record.two(entry.name.size()).two(0).two(0).two(0).two(0).four(0).four(entry.offset);
        record.text(entry.name);
        put(record.bytes());
    }
    const std::uint64_t length = offset_ - start;
    Fields end;
    end.four(kEndRecord).two(0).two(0).two(entries_.size()).two(entries_.size());
    end.four(length).four(start).two(0);
    put(end.bytes());
}

}  // namespace genus::io
