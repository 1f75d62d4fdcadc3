#include "tools/python/native/array_views.h"

#include "tools/python/native/python_errors.h"

namespace hpdm {

namespace py = pybind11;

py::object ToolArray(const std::shared_ptr<void>& owner, ToolView* views, py::ssize_t count,
                     py::ssize_t tools, const std::string& name) {
  constexpr auto kStride = static_cast<py::ssize_t>(sizeof(ToolView));
  ArrayShape shape, strides;
  if (count >= 0) {
    shape.push_back(count);
    strides.push_back(kStride * tools);
  }
  shape.push_back(tools);
  strides.push_back(kStride);
  ToolView* const v = views;
  const auto reals = [&](double* first, py::ssize_t size) {
    if (size > 1) {
      shape.push_back(size);
      strides.push_back(kReal);
    }
    return py::object(View(owner, first, shape, strides, false));
  };
  const auto whole = [&](std::int32_t* first) {
    return py::object(View(owner, first, shape, strides, false));
  };
  if (name == "force") return reals(v->force.data(), 3);
  if (name == "tip") return reals(v->tip.data(), 3);
  if (name == "velocity") return reals(v->velocity.data(), 3);
  if (name == "rotation") return reals(v->rotation.data(), 4);
  if (name == "joints") return reals(v->joints.data(), 5);
  if (name == "mean_force") return reals(v->step_force.data(), 3);
  if (name == "peak_force") return reals(&v->peak_force, 1);
  if (name == "jaw") return reals(&v->jaw, 1);
  if (name == "depth") return reals(&v->depth, 1);
  if (name == "slip") return reals(&v->slip, 1);
  if (name == "contact_organ") return whole(&v->organ);
  if (name == "contact_kind") return whole(&v->kind);
  FailValue("there is no array \"" + name + "\"");
}

}  // namespace hpdm
