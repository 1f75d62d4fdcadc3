#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <typeinfo>
#include <utility>

/// Members that make the default copy and assignment of a class right, so that a session's state
/// can be saved, restored and cloned (tools/session/lockstep_session.h).
namespace hpdm {

/// Owns an object of a polymorphic type, which is copied with its owner: T::Clone() returns a
/// std::unique_ptr<T>. An assignment calls T::Take(other) instead, if T has it and both objects are of
/// one class: it takes the other's state in place, without allocation. Otherwise used as a
/// std::unique_ptr.
template <class T>
class Cloned {
 public:
  Cloned() = default;
  Cloned(std::unique_ptr<T> value) : value_(std::move(value)) {}
  Cloned(const Cloned& other) : value_(other.value_ ? other.value_->Clone() : nullptr) {}
  Cloned(Cloned&&) noexcept = default;
  Cloned& operator=(const Cloned& other) {
    if (this == &other) return *this;
    if constexpr (requires(T & value, const T& source) { value.Take(source); }) {
      if (value_ && other.value_) {
        T& value = *value_;
        const T& source = *other.value_;
        if (typeid(value) == typeid(source)) {
          value.Take(source);
          return *this;
        }
      }
    }
    value_ = other.value_ ? other.value_->Clone() : nullptr;
    return *this;
  }
  Cloned& operator=(Cloned&&) noexcept = default;

  T* get() const { return value_.get(); }
  T* operator->() const { return value_.get(); }
  T& operator*() const { return *value_; }
  explicit operator bool() const { return value_ != nullptr; }

 private:
  std::unique_ptr<T> value_;
};

/// A matrix of working memory: its contents have no meaning between two steps. It begins with zeros, so that
/// a session has its memory from the start, and not only once a step with many contacts comes. A copy has
/// the original's size and no contents; an assignment leaves them alone. Copying them would take longer
/// than the rest of a session's state, and would touch memory that a step of the copy may never use.
template <class Matrix>
class WorkMatrixOf : public Matrix {
 public:
  WorkMatrixOf(Eigen::Index rows, Eigen::Index columns) : Matrix(Matrix::Zero(rows, columns)) {}
  WorkMatrixOf(const WorkMatrixOf& other) : Matrix(other.rows(), other.cols()) {}
  WorkMatrixOf& operator=(const WorkMatrixOf& other) {
    this->resize(other.rows(), other.cols());
    return *this;
  }
};
using WorkMatrix = WorkMatrixOf<Eigen::MatrixXd>;

/// A member with references inside, which an assignment of its owner replaces. Used as a pointer.
template <class T>
class Rebindable {
 public:
  Rebindable(const T& value) : value_(value) {}
  Rebindable(const Rebindable&) = default;
  Rebindable& operator=(const Rebindable& other) {
    const T value = *other.value_;
    value_.emplace(value);
    return *this;
  }

  const T* operator->() const { return &*value_; }
  const T& operator*() const { return *value_; }

 private:
  std::optional<T> value_;
};

}  // namespace hpdm
