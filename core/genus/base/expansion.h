#pragma once

#include <cstddef>

namespace genus {

/// Exact sums and products of doubles as a rounded result and its rounding error, valid while
/// nothing overflows or underflows.
///
/// Implements [shewchuk1997], section 2, and [dekker1971] for the product.

struct TwoTerms {
    double high;
    double low;
};

inline TwoTerms two_sum(double a, double b)
{
    const double sum = a + b;
    const double b_part = sum - a;
    const double a_part = sum - b_part;
    return {sum, (a - a_part) + (b - b_part)};
}

inline TwoTerms split_in_halves(double a)
{
    const double c = 134217729.0 * a;  // 2^27 + 1
    const double high = c - (c - a);
    return {high, a - high};
}

inline TwoTerms two_product(double a, double b)
{
    const double product = a * b;
    const TwoTerms x = split_in_halves(a), y = split_in_halves(b);
    const double low =
        x.low * y.low - (((product - x.high * y.high) - x.low * y.high) - x.high * y.low);
    return {product, low};
}

/// A number as the exact sum of up to `Capacity` doubles that do not overlap, smallest first.
template <std::size_t Capacity>
class Expansion {
public:
    Expansion() = default;
    explicit Expansion(TwoTerms terms)
    {
        static_assert(Capacity >= 2);
        append(terms.low);
        append(terms.high);
    }

    std::size_t size() const { return size_; }
    double operator[](std::size_t i) const { return term_[i]; }

    int sign() const
    {
        if (size_ == 0) return 0;
        return term_[size_ - 1] > 0.0 ? 1 : -1;
    }

    void negate()
    {
        for (std::size_t i = 0; i < size_; ++i) term_[i] = -term_[i];
    }

    /// Adds one double, keeping the terms free of overlap.
    void add(double value)
    {
        std::size_t kept = 0;
        double carry = value;
        for (std::size_t i = 0; i < size_; ++i) {
            const TwoTerms t = two_sum(carry, term_[i]);
            carry = t.high;
            if (t.low != 0.0) term_[kept++] = t.low;
        }
        size_ = kept;
        append(carry);
    }

private:
    void append(double value)
    {
        if (value != 0.0) term_[size_++] = value;
    }

    double term_[Capacity];
    std::size_t size_ = 0;
};

template <std::size_t N, std::size_t M>
Expansion<N + M> operator+(const Expansion<N>& a, const Expansion<M>& b)
{
    Expansion<N + M> sum;
    for (std::size_t i = 0; i < a.size(); ++i) sum.add(a[i]);
    for (std::size_t i = 0; i < b.size(); ++i) sum.add(b[i]);
    return sum;
}

template <std::size_t N, std::size_t M>
Expansion<N + M> operator-(const Expansion<N>& a, Expansion<M> b)
{
    b.negate();
    return a + b;
}

template <std::size_t N, std::size_t M>
Expansion<2 * N * M> operator*(const Expansion<N>& a, const Expansion<M>& b)
{
    Expansion<2 * N * M> product;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) {
            const TwoTerms t = two_product(a[i], b[j]);
            product.add(t.low);
            product.add(t.high);
        }
    return product;
}

/// a - b exactly.
inline Expansion<2> difference(double a, double b)
{
    return Expansion<2>(two_sum(a, -b));
}

}  // namespace genus
