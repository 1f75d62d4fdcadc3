#pragma once

#include <array>
#include <cstddef>
#include <memory>

/// Room for as many values as a scene may ever need, of which most scenes use few. What is not used
/// is never written, so that it takes addresses but no memory, in a session and in its copies.
namespace hpdm {

/// N values, of which the owner uses the first few and copies those alone: it starts its copy as
/// kUntouched. Used as a std::array.
template <class T, int N>
class Room {
 public:
  enum Start { kUntouched };

  Room() : values_() {}
  /// Values without contents, to be assigned before they are read.
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

  /// Takes over the first `count` values of another.
  void Take(const Room& other, int count) {
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      values_[k] = other.values_[k];
    }
  }

 private:
  union {  // which starts without contents
    std::array<T, N> values_;
  };
};

/// Working memory for values without meaning between two steps. A copy has the original's size and
/// no contents; an assignment leaves them alone. T has no initialisers.
template <class T>
class WorkArray {
 public:
  explicit WorkArray(std::size_t size)
      : size_(size), values_(std::make_unique_for_overwrite<T[]>(size)) {}
  WorkArray(const WorkArray& other) : WorkArray(other.size_) {}
  WorkArray& operator=(const WorkArray& other) {
    if (size_ != other.size_) *this = WorkArray(other.size_);
    return *this;
  }
  WorkArray(WorkArray&&) noexcept = default;
  WorkArray& operator=(WorkArray&&) noexcept = default;

  T* data() { return values_.get(); }
  const T* data() const { return values_.get(); }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }

 private:
  std::size_t size_;
  std::unique_ptr<T[]> values_;
};

}  // namespace hpdm
