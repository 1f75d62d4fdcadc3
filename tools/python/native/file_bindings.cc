#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <map>
#include <memory>
#include <variant>

#include "engine/base/error.h"
#include "engine/statics/static_loads.h"
#include "hpdm/device_t.hpp"
#include "hpdm/force_t.hpp"
#include "lcmtypes/live/network.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/message_schema.h"
#include "scenes/loader/scene_edit.h"
#include "tools/plan/scene_plan.h"
#include "tools/python/native/python_errors.h"
#include "tools/python/native/scene_key_edit.h"
#include "tools/python/native/session_bindings.h"
#include "tools/shared/report_text.h"
#include "tools/shared/static_case.h"
#include "tools/shared/with_scene_path.h"

namespace hpdm {
namespace {

namespace py = pybind11;
using Array = py::array_t<double>;
using Shape = std::vector<py::ssize_t>;

Array PointsArray(const Points& points) { return Array(Shape{points.rows(), 3}, points.data()); }

Array VectorsArray(const std::vector<Vector3d>& vectors) {
  Array array(Shape{static_cast<py::ssize_t>(vectors.size()), 3});
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (int d = 0; d < 3; ++d) array.mutable_at(static_cast<py::ssize_t>(i), d) = vectors[i][d];
  }
  return array;
}

/// One column of a channel: a row for each message. Missing numbers are NaN.
struct Column {
  bool is_whole = true;
  std::vector<double> reals;
  std::vector<std::int64_t> whole;
  std::vector<std::string> texts;
  std::size_t rows = 0;
};

using Table = std::map<std::string, Column>;

void Append(const MessageValue& value, std::size_t row, Column* column) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  if (column->rows > row) return;  // a value that occurs twice: the first counts
  if (const auto* text = std::get_if<std::string_view>(&value.value)) {
    column->texts.resize(row);
    column->texts.emplace_back(*text);
  } else {
    const auto* integer = std::get_if<std::int64_t>(&value.value);
    column->is_whole = column->is_whole && integer != nullptr && column->rows == row;
    column->reals.resize(row, kMissing);
    column->reals.push_back(integer != nullptr ? static_cast<double>(*integer)
                                               : std::get<double>(value.value));
    if (column->is_whole) column->whole.push_back(*integer);
  }
  column->rows = row + 1;
}

py::object ColumnArray(Column* column, std::size_t rows) {
  if (!column->texts.empty()) {
    column->texts.resize(rows);
    return py::cast(column->texts);
  }
  const Shape shape{static_cast<py::ssize_t>(rows)};
  if (column->is_whole && column->whole.size() == rows) {
    return py::array_t<std::int64_t>(shape, column->whole.data());
  }
  column->reals.resize(rows, std::numeric_limits<double>::quiet_NaN());
  return Array(shape, column->reals.data());
}

py::dict ReadLog(const std::string& path) {
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  struct Channel {
    Table table;
    std::vector<std::int64_t> times_us;
  };
  std::map<std::string, Channel> channels;
  LogReader reader(path);
  {
    const py::gil_scoped_release unlocked;
    LogEvent event;
    while (reader.Next(&event)) {
      const LcmStruct* type = schemas.Find(event.data);
      if (type == nullptr || !schemas.Decode(*type, event.data, [](const MessageValue&) {})) {
        continue;
      }
      Channel& channel = channels[event.channel];
      const std::size_t row = channel.times_us.size();
      channel.times_us.push_back(event.time_us);
      schemas.Decode(*type, event.data, [&](const MessageValue& value) {
        Append(value, row, &channel.table[std::string(value.name)]);
      });
    }
  }
  py::dict log;
  for (auto& [name, channel] : channels) {
    py::dict columns;
    const std::size_t rows = channel.times_us.size();
    columns["log_time_us"] =
        py::array_t<std::int64_t>(Shape{static_cast<py::ssize_t>(rows)}, channel.times_us.data());
    for (auto& [key, column] : channel.table) {
      columns[py::str(key)] = ColumnArray(&column, rows);
    }
    log[py::str(name)] = columns;
  }
  return log;
}

py::dict Solve(const Scene& scene) {
  StaticCase load_case;
  StaticSolution solution;
  double residual = 0;
  {
    const py::gil_scoped_release unlocked;
    load_case = MakeStaticCase(scene);
    const OrganModel model =
        WithScenePath(scene, [&] { return OrganModel(load_case.organ, load_case.rest); });
    const StaticLoads loads = WithScenePath(scene, [&] { return StaticLoads(model, scene.loads); });
    solution = loads.Solve();
    residual = loads.Residual(solution);
  }
  py::dict result;
  result["organ"] = load_case.organ.name;
  result["vertices"] = PointsArray(load_case.rest.vertices);
  result["displacements"] = PointsArray(solution.vertex_displacements);
  result["load_forces"] = VectorsArray(solution.load_forces);
  result["load_displacements"] = VectorsArray(solution.load_displacements);
  result["compliance"] = solution.Compliance();
  result["residual"] = residual;
  result["share"] = solution.share;
  return result;
}

// Throws from the search if Python has a signal, such as Ctrl-C.
bool Interrupted() {
  const py::gil_scoped_acquire locked;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  return false;
}

py::dict Plan(const Scene& scene, double error, double budget_ms, double seconds,
              const std::string& out) {
  ScenePlan plan;
  {
    const py::gil_scoped_release unlocked;
    plan = MakePlan(
        scene, {error, 1e3 * budget_ms}, seconds, [](const std::string&, const PlanPoint&) {},
        &Interrupted);
  }
  py::dict result;
  result["meets_both"] = plan.MeetsBoth();
  result["remarks"] = plan.remarks;
  const auto choice = [&](const char* name, const std::optional<PlanChoice>& of) {
    py::dict values;
    if (of) {
      values["error"] = of->error;
      values["step_ms"] = of->step_us / 1e3;
    }
    result[name] = values;
  };
  choice("of_error", plan.of_error);
  choice("of_budget", plan.of_budget);
  if (plan.MeetsBoth()) {
    const std::filesystem::path path(out.empty() ? scene.path : std::filesystem::path(out));
    const std::string text = PlannedScene(scene, plan, path.parent_path());
    result["scene"] = ParseScene(text, path);
  }
  return result;
}

/// A haptic device for a session that runs elsewhere (haptics/device/README.md).
class Driver {
 public:
  explicit Driver(int instrument)
      : instrument_(instrument), lcm_(Connect(NetworkUrl(), "hpdm.Driver")) {
    lcm_->subscribeFunction("HPDM_FORCE", &Driver::Take, this);
  }

  void Publish(const std::array<double, 5>& joints, bool pedal) {
    process_.Require("the driver's connection");
    const std::int64_t now = Now();
    device_t reading{++sequence_, now, instrument_, {}, true, pedal};
    std::copy(joints.begin(), joints.end(), reading.joints);
    if (lcm_->publish("HPDM_DEVICE", &reading) != 0) FailState("the reading was not sent");
  }

  // The newest effort; zero if the session has been silent for 50 ms.
  py::tuple Effort() {
    process_.Require("the driver's connection");
    {
      const py::gil_scoped_release unlocked;
      while (lcm_->handleTimeout(0) > 0) {
      }
    }
    const bool silent = Now() - taken_ns_ > 50'000'000;
    if (silent) return py::make_tuple(0.0, 0.0, 0.0);
    return py::make_tuple(effort_[0], effort_[1], effort_[2]);
  }

 private:
  static std::int64_t Now() { return std::chrono::steady_clock::now().time_since_epoch().count(); }
  static void Take(const lcm::ReceiveBuffer*, const std::string&, const force_t* force,
                   Driver* driver) {
    const auto i = static_cast<std::size_t>(driver->instrument_);
    if (i >= force->tools.size()) return;
    for (int axis = 0; axis < 3; ++axis) driver->effort_[axis] = force->tools[i].effort[axis];
    driver->taken_ns_ = Now();
  }

  int instrument_;
  ProcessCheck process_;
  std::unique_ptr<lcm::LCM> lcm_;
  std::int64_t sequence_ = 0;
  std::int64_t taken_ns_ = std::numeric_limits<std::int64_t>::min() / 2;
  std::array<double, 3> effort_{};
};

}  // namespace

void BindFiles(py::module_* module) {
  py::class_<Scene, std::shared_ptr<Scene>>(*module, "Scene")
      .def(py::init([](const std::string& path) { return LoadScene(path); }))
      .def_static("parse", [](const std::string& text,
                              const std::string& path) { return ParseScene(text, path); })
      .def("with_key",
           [](const Scene& scene, const std::string& key, const std::string& value) {
             return ParseScene(WithKey(scene, key, value), scene.path);
           })
      .def("moved",
           [](const Scene& scene, const std::string& folder) {
             return MovedScene(scene, scene.source_text, folder);
           })
      .def_property_readonly("path", [](const Scene& scene) { return scene.path.string(); })
      .def_readonly("text", &Scene::source_text)
      .def_readonly("name", &Scene::name)
      .def_property_readonly("haptic_hz", [](const Scene& scene) { return scene.timing.haptic_hz; })
      .def_property_readonly("deformation_hz",
                             [](const Scene& scene) { return scene.timing.deformation_hz; })
      .def_property_readonly("organs",
                             [](const Scene& scene) {
                               std::vector<std::string> names;
                               for (const auto& organ : scene.organs) names.push_back(organ.name);
                               return names;
                             })
      .def_property_readonly("youngs",
                             [](const Scene& scene) {
                               std::vector<double> values;
                               for (const auto& organ : scene.organs) {
                                 values.push_back(organ.material.young);
                               }
                               return values;
                             })
      .def_property_readonly("instruments", [](const Scene& scene) {
        std::vector<std::string> names;
        for (const auto& instrument : scene.instruments) names.push_back(instrument.name);
        return names;
      });
  module->def("read_log", &ReadLog);
  module->def("solve", &Solve);
  module->def("plan", &Plan);
  py::class_<Driver>(*module, "Driver")
      .def(py::init<int>())
      .def("publish", &Driver::Publish, py::arg("joints"), py::arg("pedal") = false)
      .def("effort", &Driver::Effort);
}

}  // namespace hpdm
