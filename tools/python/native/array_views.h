#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/session/lockstep_session.h"

namespace hpdm {

using ArrayShape = std::vector<pybind11::ssize_t>;

/// The stride of successive doubles, bytes.
inline constexpr pybind11::ssize_t kReal = sizeof(double);

/// Returns an array over memory that `owner` keeps alive. `strides`: bytes.
template <class T>
pybind11::array_t<T> View(std::shared_ptr<void> owner, T* data, ArrayShape shape,
                          ArrayShape strides, bool writable) {
  auto* kept = new std::shared_ptr<void>(std::move(owner));
  const pybind11::capsule base(kept,
                               [](void* p) { delete static_cast<std::shared_ptr<void>*>(p); });
  pybind11::array_t<T> array(std::move(shape), std::move(strides), data, base);
  if (!writable) array.attr("flags").attr("writeable") = false;
  return array;
}

/// Returns one of the values of ToolView, which are `count` rows of `tools` views; count -1: no
/// rows. `owner` keeps the views alive. Throws ValueError if there is no value of that name.
pybind11::object ToolArray(const std::shared_ptr<void>& owner, ToolView* views,
                           pybind11::ssize_t count, pybind11::ssize_t tools,
                           const std::string& name);

}  // namespace hpdm
