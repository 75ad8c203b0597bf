#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace genus {

__extension__ using Int128 = __int128;
__extension__ using UInt128 = unsigned __int128;

/// An integer of at most `N` times 64 bits, held as sign and magnitude. Only the words in use are
/// touched, so that small values cost little however wide the type. Sums and products return a
/// type wide enough for any operands: nothing overflows, nothing is allocated.
template <int N>
class WideInt {
public:
    WideInt() = default;
    WideInt(std::int64_t value) : negative_(value < 0)
    {
        words_[0] =
            negative_ ? ~static_cast<std::uint64_t>(value) + 1 : static_cast<std::uint64_t>(value);
        used_ = words_[0] != 0;
    }
    static WideInt from_int128(Int128 value)
    {
        static_assert(N >= 2);
        WideInt r;
        r.negative_ = value < 0;
        const UInt128 magnitude =
            r.negative_ ? ~static_cast<UInt128>(value) + 1 : static_cast<UInt128>(value);
        r.words_[0] = static_cast<std::uint64_t>(magnitude);
        r.words_[1] = static_cast<std::uint64_t>(magnitude >> 64);
        r.used_ = 2;
        r.trim();
        return r;
    }
    /// Widens, or narrows a value that is known to fit.
    template <int M>
    explicit WideInt(const WideInt<M>& other) : used_(other.used_), negative_(other.negative_)
    {
        assert(other.used_ <= N);
        for (int i = 0; i < used_; ++i) words_[i] = other.words_[i];
    }

    int sign() const { return used_ == 0 ? 0 : (negative_ ? -1 : 1); }
    WideInt operator-() const
    {
        WideInt r = *this;
        r.negative_ = !negative_;
        return r;
    }

    /// Within two units in the last place; infinite above the range of double.
    double to_double() const
    {
        double value = 0.0;
        for (int i = used_ - 1; i >= std::max(0, used_ - 2); --i)
            value += std::ldexp(static_cast<double>(words_[i]), 64 * i);
        return negative_ ? -value : value;
    }

    template <int M>
    WideInt<N + M> times(const WideInt<M>& b) const;
    /// The sum, or the difference if `negate_b`.
    template <int M>
    auto plus(const WideInt<M>& b, bool negate_b) const;
    template <int M>
    int compare_magnitude(const WideInt<M>& b) const;

private:
    template <int M>
    friend class WideInt;

    void trim()
    {
        while (used_ > 0 && words_[used_ - 1] == 0) --used_;
    }

    std::array<std::uint64_t, N> words_;  // words_[used_] and above are not set
    int used_ = 0;
    bool negative_ = false;
};

template <int N>
template <int M>
WideInt<N + M> WideInt<N>::times(const WideInt<M>& b) const
{
    const WideInt& a = *this;
    WideInt<N + M> r;
    if (a.used_ == 0 || b.used_ == 0) return r;
    r.negative_ = a.negative_ != b.negative_;
    r.used_ = a.used_ + b.used_;
    for (int i = 0; i < r.used_; ++i) r.words_[i] = 0;
    for (int i = 0; i < a.used_; ++i) {
        std::uint64_t carry = 0;
        for (int j = 0; j < b.used_; ++j) {
            const UInt128 t =
                static_cast<UInt128>(a.words_[i]) * b.words_[j] + r.words_[i + j] + carry;
            r.words_[i + j] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        r.words_[i + b.used_] = carry;
    }
    r.trim();
    return r;
}

template <int N>
template <int M>
int WideInt<N>::compare_magnitude(const WideInt<M>& b) const
{
    const WideInt& a = *this;
    if (a.used_ != b.used_) return a.used_ < b.used_ ? -1 : 1;
    for (int i = a.used_ - 1; i >= 0; --i)
        if (a.words_[i] != b.words_[i]) return a.words_[i] < b.words_[i] ? -1 : 1;
    return 0;
}

template <int N>
template <int M>
auto WideInt<N>::plus(const WideInt<M>& b, bool negate_b) const
{
    const WideInt& a = *this;
    WideInt<std::max(N, M) + 1> r;
    const bool b_negative = b.negative_ != negate_b;
    const int n = std::max(a.used_, b.used_);
    if (a.negative_ == b_negative) {
        std::uint64_t carry = 0;
        for (int i = 0; i < n; ++i) {
            const UInt128 t = static_cast<UInt128>(i < a.used_ ? a.words_[i] : 0) +
                              (i < b.used_ ? b.words_[i] : 0) + carry;
            r.words_[i] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        r.words_[n] = carry;
        r.used_ = n + 1;
        r.negative_ = a.negative_;
    } else {
        const int order = a.compare_magnitude(b);
        if (order == 0) return r;
        const std::uint64_t* big = order > 0 ? a.words_.data() : b.words_.data();
        const std::uint64_t* small = order > 0 ? b.words_.data() : a.words_.data();
        const int n_small = order > 0 ? b.used_ : a.used_;
        std::uint64_t borrow = 0;
        for (int i = 0; i < n; ++i) {
            const std::uint64_t s = i < n_small ? small[i] : 0;
            const UInt128 t = static_cast<UInt128>(big[i]) - s - borrow;
            r.words_[i] = static_cast<std::uint64_t>(t);
            borrow = static_cast<std::uint64_t>(t >> 64) != 0;
        }
        r.used_ = n;
        r.negative_ = order > 0 ? a.negative_ : b_negative;
    }
    r.trim();
    return r;
}

template <int A, int B>
WideInt<A + B> operator*(const WideInt<A>& a, const WideInt<B>& b)
{
    return a.times(b);
}

template <int A, int B>
WideInt<std::max(A, B) + 1> operator+(const WideInt<A>& a, const WideInt<B>& b)
{
    return a.plus(b, false);
}

template <int A, int B>
WideInt<std::max(A, B) + 1> operator-(const WideInt<A>& a, const WideInt<B>& b)
{
    return a.plus(b, true);
}

/// -1, 0, 1 as a is less than, equal to, greater than b.
template <int A, int B>
int compare(const WideInt<A>& a, const WideInt<B>& b)
{
    if (a.sign() != b.sign()) return a.sign() < b.sign() ? -1 : 1;
    return a.sign() * a.compare_magnitude(b);
}

template <int A, int B>
bool operator==(const WideInt<A>& a, const WideInt<B>& b)
{
    return compare(a, b) == 0;
}

}  // namespace genus
