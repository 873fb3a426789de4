// A number with 64 significant bits whose arithmetic gives the same bits on every processor. On x86-64, `long
// double` has 64 bits. On arm64, `long double` has 113 bits; Veltkamp's splitting rounds each result to 64
// bits. Such a result is rounded twice, and differs from x86-64 with a probability of 2^-49.
#pragma once

#include <limits>

namespace hystcan::model {

class Extended {
 public:
  Extended(long double value = 0.0L) : value_(rounded(value)) {}
  explicit operator double() const { return static_cast<double>(value_); }

  friend Extended operator+(Extended a, Extended b) { return a.value_ + b.value_; }
  friend Extended operator-(Extended a, Extended b) { return a.value_ - b.value_; }
  friend Extended operator*(Extended a, Extended b) { return a.value_ * b.value_; }
  friend Extended operator/(Extended a, Extended b) { return a.value_ / b.value_; }
  friend bool operator<(Extended a, Extended b) { return a.value_ < b.value_; }
  friend bool operator>(Extended a, Extended b) { return a.value_ > b.value_; }
  Extended& operator+=(Extended b) { return *this = *this + b; }
  Extended operator-() const { return -value_; }
  Extended magnitude() const { return value_ < 0.0L ? -value_ : value_; }

 private:
  static constexpr int digits = 64, own_digits = std::numeric_limits<long double>::digits;
  static_assert(own_digits >= digits, "long double has less than 64 bits on this processor");

  static long double rounded(long double value) {
    if constexpr (own_digits == digits) return value;
    // Veltkamp's splitting: adding value * 2^n and subtracting it again rounds `value` to 64 bits.
    const long double above = value * (static_cast<long double>(1ULL << (own_digits - digits)) + 1.0L);
    return above - (above - value);
  }

  long double value_;
};

}  // namespace hystcan::model
