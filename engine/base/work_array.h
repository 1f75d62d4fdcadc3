#pragma once

#include <cstddef>
#include <memory>

namespace hpdm {

/// Working memory for values without meaning between two steps. T has no initialisers. It begins with
/// zeros, so that a session has its memory from the start. A copy has the original's size and no contents,
/// and an assignment leaves them alone: a page that no step of the copy writes needs no memory. See
/// WorkMatrix (copying.h) for matrices.
template <class T>
class WorkArray {
 public:
  explicit WorkArray(std::size_t size) : size_(size), values_(std::make_unique<T[]>(size)) {}
  WorkArray(const WorkArray& other)
      : size_(other.size_), values_(std::make_unique_for_overwrite<T[]>(other.size_)) {}
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
