#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "genus/base/box.h"

namespace genus {

/// Root of everything the library throws. `what()` is one line, ready to be shown.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// An argument outside what the function promises to take.
class InvalidInput : public Error {
public:
    using Error::Error;
};

/// A file that cannot be read or written. `line` counts from 1, `byte` from 0; at most one is set.
class FileError : public Error {
public:
    struct Place {
        std::optional<std::int64_t> line;
        std::optional<std::int64_t> byte;
    };

    FileError(const std::string& path, const std::string& problem);
    FileError(const std::string& path, const std::string& problem, Place place);

    static Place at_line(std::int64_t line) { return {line, std::nullopt}; }
    static Place at_byte(std::int64_t byte) { return {std::nullopt, byte}; }

    const std::string& path() const { return path_; }
    const std::string& problem() const { return problem_; }
    Place place() const { return place_; }

private:
    std::string path_;
    std::string problem_;
    Place place_;
};

/// A mistake in a text model. Line and column count from 1.
class ModelError : public Error {
public:
    ModelError(const std::string& file, int line, int column, const std::string& problem);

    const std::string& file() const { return file_; }
    int line() const { return line_; }
    int column() const { return column_; }
    const std::string& problem() const { return problem_; }

private:
    std::string file_;
    int line_;
    int column_;
    std::string problem_;
};

/// The solid reaches to infinity; the text names the leaf that makes it so.
class UnboundedSolid : public Error {
public:
    using Error::Error;
};

/// The tolerance asked for was not reached within the budget.
class ToleranceNotMet : public Error {
public:
    ToleranceNotMet(const std::string& text, double asked, double reached, std::vector<Box3> where);

    double asked() const { return asked_; }
    /// The best bound reached; infinity where none could be given.
    double reached() const { return reached_; }
    /// Boxes, in model units, in which the bound failed.
    const std::vector<Box3>& where() const { return where_; }

private:
    double asked_;
    double reached_;
    std::vector<Box3> where_;
};

/// The caller asked to stop; see progress.h.
class Cancelled : public Error {
public:
    Cancelled() : Error("cancelled") {}
};

/// A number as short as it can be written and still read back the same.
std::string to_text(double value);

/// Throws InvalidInput "`argument` is `value`, must be `demand`" unless `holds`.
void require(bool holds, const char* argument, double value, const char* demand);

/// Throws InvalidInput with `text` unless `holds`.
void require(bool holds, const char* text);

}  // namespace genus
