#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/mesh/handles.h"

namespace genus {

namespace detail {

class PropertyArrayBase {
public:
    virtual ~PropertyArrayBase() = default;
    virtual void resize(std::size_t n) = 0;
    virtual void move_entry(std::size_t from, std::size_t to) = 0;
    virtual std::unique_ptr<PropertyArrayBase> copy() const = 0;
};

template <class T>
class PropertyArray final : public PropertyArrayBase {
public:
    explicit PropertyArray(T value) : value_(std::move(value)) {}
    void resize(std::size_t n) override { entries.resize(n, value_); }
    void move_entry(std::size_t from, std::size_t to) override
    {
        entries[to] = std::move(entries[from]);
    }
    std::unique_ptr<PropertyArrayBase> copy() const override
    {
        return std::make_unique<PropertyArray>(*this);
    }

    std::vector<T> entries;

private:
    T value_;
};

}  // namespace detail

/// Access to one named array of a mesh: `weight[v]`. Stays good as the mesh grows, until the
/// property is removed or the mesh ends or is assigned to.
template <class H, class T>
class Property {
public:
    explicit Property(detail::PropertyArray<T>& array) : array_(&array) {}

    T& operator[](H h) const { return array_->entries[h.index]; }
    std::vector<T>& entries() const { return array_->entries; }

private:
    detail::PropertyArray<T>* array_;
};

/// The named arrays on one kind of element, all as long as there are elements.
template <class H>
class PropertySet {
public:
    PropertySet() = default;
    PropertySet(PropertySet&&) noexcept = default;
    PropertySet& operator=(PropertySet&&) noexcept = default;
    PropertySet(const PropertySet& other) { *this = other; }
    PropertySet& operator=(const PropertySet& other)
    {
        if (this == &other) return *this;
        arrays_.clear();
        for (const auto& [name, array] : other.arrays_) arrays_[name] = array->copy();
        size_ = other.size_;
        return *this;
    }
    ~PropertySet() = default;

    /// Throws InvalidInput if the name is taken.
    template <class T>
    Property<H, T> add(const std::string& name, T value = {})
    {
        static_assert(!std::is_same_v<T, bool>, "vector<bool> has no references; use char");
        if (arrays_.count(name)) throw InvalidInput("property \"" + name + "\" is there already");
        auto array = std::make_unique<detail::PropertyArray<T>>(std::move(value));
        array->resize(size_);
        Property<H, T> property(*array);
        arrays_[name] = std::move(array);
        return property;
    }

    /// Throws InvalidInput if there is none of that name and type.
    template <class T>
    Property<H, T> get(const std::string& name) const
    {
        const auto at = arrays_.find(name);
        auto* array = at == arrays_.end()
                          ? nullptr
                          : dynamic_cast<detail::PropertyArray<T>*>(at->second.get());
        if (!array) throw InvalidInput("there is no property \"" + name + "\" of that type");
        return Property<H, T>(*array);
    }

    bool has(const std::string& name) const { return arrays_.count(name) > 0; }
    void remove(const std::string& name) { arrays_.erase(name); }

    void resize(std::size_t n)
    {
        size_ = n;
        for (auto& entry : arrays_) entry.second->resize(n);
    }
    /// Entry `to` takes the value of entry `from`.
    void move_entry(std::size_t from, std::size_t to)
    {
        if (from == to) return;
        for (auto& entry : arrays_) entry.second->move_entry(from, to);
    }

private:
    std::map<std::string, std::unique_ptr<detail::PropertyArrayBase>> arrays_;
    std::size_t size_ = 0;
};

}  // namespace genus
