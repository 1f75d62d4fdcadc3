#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

namespace hpdm {

/// A fixed-size array of which the owner uses only the first few values. The owner's copy
/// constructor starts it as kUntouched and takes over those few. A page that nobody writes needs no
/// memory, so copies of a session need memory only for what is in use.
template <class T, int N>
class Room {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  enum Start { kUntouched };

  Room() : values_() {}
  /// Values without contents: write them before they are read.
  explicit Room(Start) {}
  Room(const Room&) = delete;
  Room& operator=(const Room&) = delete;
  ~Room() {}

  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  T* begin() { return values_.data(); }
  T* end() { return values_.data() + N; }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + N; }
  static constexpr std::size_t size() { return N; }

  /// Copies the first `count` values of another, at most N.
  void Take(const Room& other, int count) {
    std::copy_n(other.begin(), static_cast<std::size_t>(std::clamp(count, 0, N)), begin());
  }

 private:
  union {  // leaves the values without contents
    std::array<T, N> values_;
  };
};

}  // namespace hpdm
