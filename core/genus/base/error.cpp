#include "genus/base/error.h"

#include <charconv>
#include <cmath>

namespace genus {

namespace {

std::string file_text(const std::string& path, const std::string& problem, FileError::Place place)
{
    if (place.line) return path + ":" + std::to_string(*place.line) + ": " + problem;
    if (place.byte) return path + ": byte " + std::to_string(*place.byte) + ": " + problem;
    return path + ": " + problem;
}

}  // namespace

FileError::FileError(const std::string& path, const std::string& problem)
    : FileError(path, problem, Place{})
{
}

FileError::FileError(const std::string& path, const std::string& problem, Place place)
    : Error(file_text(path, problem, place)), path_(path), problem_(problem), place_(place)
{
}

ModelError::ModelError(const std::string& file, int line, int column, const std::string& problem)
    : Error(file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + problem),
      file_(file),
      line_(line),
      column_(column),
      problem_(problem)
{
}

ToleranceNotMet::ToleranceNotMet(const std::string& text, double asked, double reached,
                                 std::vector<Box3> where)
    : Error(text), asked_(asked), reached_(reached), where_(std::move(where))
{
}

std::string to_text(double value)
{
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    return std::string(buffer, end);
}

void require(bool holds, const char* argument, double value, const char* demand)
{
    if (holds) return;
    throw InvalidInput(std::string(argument) + " is " + to_text(value) + ", must be " + demand);
}

void require(bool holds, const char* text)
{
    if (!holds) throw InvalidInput(text);
}

}  // namespace genus
