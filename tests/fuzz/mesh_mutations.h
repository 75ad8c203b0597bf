#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <random>
#include <vector>

#include "genus/base/error.h"
#include "genus/io/read_mesh.h"

namespace genus {

using FileBytes = std::vector<std::byte>;

/// Ways to spoil a file, each decided by the numbers of `random`.
class Spoiler {
public:
    explicit Spoiler(std::uint64_t seed) : random_(seed) {}

    FileBytes cut_short(FileBytes file)
    {
        file.resize(below(file.size()));
        return file;
    }

    FileBytes flip_bits(FileBytes file)
    {
        for (std::size_t n = 1 + below(4); n > 0 && !file.empty(); --n)
            file[below(file.size())] ^= static_cast<std::byte>(1u << below(8));
        return file;
    }

    /// Puts a number in place of four bytes, or of eight.
    FileBytes plant_number(FileBytes file)
    {
        static constexpr std::uint64_t numbers[] = {
            0,          1,          0x7FFFFFFF,         0x80000000,         0xFFFFFFFF,
            0x7FF80000, 0x7F800000, 0x7FF0000000000000, 0x1000000000000000, 0xFFFFFFFFFFFFFFFF};
        const std::size_t width = below(2) == 0 ? 4 : 8;
        if (file.size() < width) return file;
        std::memcpy(file.data() + below(file.size() - width + 1), &numbers[below(10)], width);
        return file;
    }

    /// Puts a word in place of another, or between two.
    FileBytes plant_word(FileBytes file)
    {
        static constexpr const char* words[] = {"nan",
                                                "-inf",
                                                "1e999",
                                                "-1",
                                                "0",
                                                "1152921504606846976",
                                                "99999999999999999999",
                                                "\n",
                                                "\r\n",
                                                "#",
                                                "\\\n",
                                                "end",
                                                "facet",
                                                "endsolid",
                                                "f",
                                                "v",
                                                "list",
                                                "int",
                                                "char",
                                                "end_header",
                                                "-",
                                                "1e-9",
                                                "0x10",
                                                "1/2/3",
                                                "//",
                                                "3",
                                                "\t \v",
                                                "element face 2"};
        const char* word = words[below(std::size(words))];
        const auto at = static_cast<std::ptrdiff_t>(below(file.size() + 1));
        const auto stop = std::min(file.end(), file.begin() + at + static_cast<int>(below(6)));
        const auto next = file.erase(file.begin() + at, stop);
        const auto* bytes = reinterpret_cast<const std::byte*>(word);
        file.insert(next, bytes, bytes + std::strlen(word));
        return file;
    }

    /// Removes, doubles or moves a stretch.
    FileBytes move_stretch(FileBytes file)
    {
        if (file.empty()) return file;
        const std::size_t begin = below(file.size());
        const std::size_t length = 1 + below(std::min<std::size_t>(64, file.size() - begin));
        const auto from = file.begin() + static_cast<std::ptrdiff_t>(begin);
        const FileBytes stretch(from, from + static_cast<std::ptrdiff_t>(length));
        if (below(3) != 0) file.erase(from, from + static_cast<std::ptrdiff_t>(length));
        if (below(3) != 0)
            file.insert(file.begin() + static_cast<std::ptrdiff_t>(below(file.size() + 1)),
                        stretch.begin(), stretch.end());
        return file;
    }

    FileBytes spoil(FileBytes file)
    {
        switch (below(5)) {
            case 0:
                return cut_short(std::move(file));
            case 1:
                return flip_bits(std::move(file));
            case 2:
                return plant_number(std::move(file));
            case 3:
                return plant_word(std::move(file));
            default:
                return move_stretch(std::move(file));
        }
    }

private:
    std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }

    std::mt19937_64 random_;
};

/// Whether every face has three corners or more, all of which exist, and every coordinate is a
/// finite number: what read_mesh promises.
inline bool is_sound(const MeshFile& file)
{
    for (const Vec3& v : file.mesh.vertices)
        if (!is_finite(v)) return false;
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f) {
        const auto face = file.mesh.face(f);
        if (face.size() < 3) return false;
        for (const std::int32_t v : face)
            if (v < 0 || static_cast<std::size_t>(v) >= file.mesh.n_vertices()) return false;
    }
    const auto fits = [](std::size_t colors, std::size_t elements) {
        return colors == 0 || colors == elements;
    };
    return fits(file.vertex_colors.size(), file.mesh.n_vertices()) &&
           fits(file.face_colors.size(), file.mesh.n_faces());
}

enum class Outcome { mesh, file_error, broken };

/// Reads the bytes of a spoiled file. Anything but a sound mesh or a FileError that names the file
/// is broken.
inline Outcome outcome_of(const FileBytes& file, const std::string& name,
                          const ReadOptions& options = {})
{
    try {
        return is_sound(read_mesh_file(file, name, options)) ? Outcome::mesh : Outcome::broken;
    } catch (const FileError& error) {
        const std::string text = error.what();
        const bool one_line = text.find('\n') == std::string::npos;
        return error.path() == name && one_line ? Outcome::file_error : Outcome::broken;
    }
}

}  // namespace genus
