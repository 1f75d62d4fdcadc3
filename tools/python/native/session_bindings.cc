#include "tools/python/native/session_bindings.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <limits>

#include "engine/base/error.h"
#include "render/camera/laparoscope.h"
#include "scenes/loader/scene.h"
#include "tools/python/native/python_session.h"
#include "tools/session/session_recorder.h"

namespace hpdm {
namespace {

namespace py = pybind11;
using Array = py::array_t<double>;
using Shape = std::vector<py::ssize_t>;

CommandKind KindOf(const std::string& text) {
  if (text == "axes") return CommandKind::kAxes;
  if (text == "tip") return CommandKind::kTip;
  FailValue("command: \"" + text + "\" is not known; give \"axes\" or \"tip\"");
}

// The devices that live in this program; `text`: "command", or the arguments of --device.
std::vector<DeviceChoice> DevicesOf(const std::vector<std::string>& arguments, const Scene& scene) {
  std::vector<DeviceChoice> devices(scene.instruments.size(), {DeviceChoice::Type::kCommand, {}});
  std::vector<std::string> others;
  for (const std::string& argument : arguments) {
    if (argument != "command") others.push_back(argument);
  }
  if (others.empty()) return devices;
  const std::vector<DeviceChoice> chosen = ChooseDevices(others, scene.instruments);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i].type == DeviceChoice::Type::kLcm) {
      throw InputError("device \"lcm\" needs the real clock; start `hpdm run --device lcm`");
    }
    const std::string prefix = scene.instruments[i].name + "=";
    bool named = false;
    for (const std::string& other : others) {
      named = named || other.starts_with(prefix) ||
              (other.find('=') == std::string::npos || other.starts_with("trace:"));
    }
    if (named) devices[i] = chosen[i];
  }
  return devices;
}

/// An array over memory that `owner` keeps alive.
template <class T, class Owner>
py::array_t<T> View(const std::shared_ptr<Owner>& owner, T* data, Shape shape, Shape strides,
                    bool writable) {
  auto* kept = new std::shared_ptr<Owner>(owner);
  const py::capsule base(kept, [](void* p) { delete static_cast<std::shared_ptr<Owner>*>(p); });
  py::array_t<T> array(std::move(shape), std::move(strides), data, base);
  if (!writable) array.attr("flags").attr("writeable") = false;
  return array;
}

constexpr py::ssize_t kReal = sizeof(double);

/// One of the values of ToolView as an array over `count` rows of `tools` views; -1: no rows.
template <class Owner>
py::object ToolArray(const std::shared_ptr<Owner>& owner, ToolView* views, py::ssize_t count,
                     py::ssize_t tools, const std::string& name) {
  constexpr auto kStride = static_cast<py::ssize_t>(sizeof(ToolView));
  Shape shape, strides;
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

py::dict PictureArrays(const PictureWish& wish, const SessionPicture& picture) {
  const py::ssize_t h = wish.height, w = wish.width;
  py::dict arrays;
  arrays["rgb"] = py::array_t<std::uint8_t>(Shape{h, w, 3}, picture.image.rgb.data());
  if (wish.depth) arrays["depth"] = py::array_t<float>(Shape{h, w}, picture.depth.data());
  if (wish.organs) arrays["organs"] = py::array_t<std::int32_t>(Shape{h, w}, picture.organs.data());
  return arrays;
}

py::dict CameraOf(const SessionModel& model, int width, int height) {
  const Laparoscope scope(model.scene().laparoscope, width, height);
  // x to the right, y down, z along the view: the axes of the intrinsics.
  Eigen::Matrix4d pose = scope.X_WC().matrix();
  pose.col(1) *= -1;
  pose.col(2) *= -1;
  const double f = scope.focal_length_px();
  Array poses(Shape{4, 4}), intrinsics(Shape{3, 3});
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) poses.mutable_at(i, j) = pose(i, j);
  }
  const double K[3][3] = {{f, 0, width / 2.0}, {0, f, height / 2.0}, {0, 0, 1}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) intrinsics.mutable_at(i, j) = K[i][j];
  }
  py::dict camera;
  camera["pose"] = poses;
  camera["intrinsics"] = intrinsics;
  camera["circle_radius"] = scope.circle_radius_px();
  camera["distortion"] = scope.distortion();
  return camera;
}

PictureWish WishOf(int width, int height, bool depth, bool organs) {
  constexpr int kLeast = Laparoscope::kMinSide, kMost = Laparoscope::kMaxSide;
  if (width < kLeast || width > kMost || height < kLeast || height > kMost) {
    FailValue("a picture has " + std::to_string(kLeast) + " to " + std::to_string(kMost) +
              " pixels on each side, not " + std::to_string(width) + " x " +
              std::to_string(height));
  }
  return {width, height, depth, organs};
}

void RequireYoung(double young) {
  if (!(young > 0) || young > 1e12) {
    FailValue("young: give Pa above 0, up to 1e12");
  }
}

/// A session as Python holds it. Closing drops the data; arrays keep what they show.
class NativeSession {
 public:
  NativeSession(std::shared_ptr<const SessionModel> model, const std::vector<std::string>& devices,
                std::uint32_t seed, const std::string& command)
      : data_(std::make_shared<SessionData>(model, DevicesOf(devices, model->scene()), seed,
                                            KindOf(command))) {}
  explicit NativeSession(std::shared_ptr<SessionData> data) : data_(std::move(data)) {}

  const std::shared_ptr<SessionData>& data() const {
    if (data_ == nullptr) FailState("the session is closed");
    return data_;
  }
  LockstepSession& session() const { return data()->session; }
  /// Throws MachineError after it is closed if a record's log is not complete.
  void Close() {
    const OneCaller caller(&busy_, kWhat);
    const std::shared_ptr<SessionData> closed = std::move(data_);
    if (closed != nullptr) StopRecorder(closed.get());
  }

  void Record(const std::string& folder, bool live) {
    const OneCaller caller(&busy_, kWhat);
    if (session().steps() > 0) FailState("a record begins at the start; call reset() first");
    if (recorder_ != nullptr) FailState("the session is recorded already; call end_record() first");
    const py::gil_scoped_release unlocked;
    recorder_ = std::make_unique<SessionRecorder>(session().model(), folder, live);
    session().RecordTo(recorder_.get());
  }
  void EndRecord() {
    const OneCaller caller(&busy_, kWhat);
    StopRecorder(data().get());
  }

  void Step() {
    const OneCaller caller(&busy_, kWhat);
    SessionData& data = *this->data();
    data.ApplyCommands();
    const py::gil_scoped_release unlocked;
    data.Step();
  }
  void Reset(std::uint32_t seed) {
    const OneCaller caller(&busy_, kWhat);
    SessionData& data = *this->data();
    StopRecorder(&data);
    const py::gil_scoped_release unlocked;
    data.Reset(seed);
  }
  void SetYoung(std::size_t organ, double young, std::uint32_t seed) {
    RequireYoung(young);
    if (organ >= session().model().organs().size()) FailIndex("there is no such organ");
    const OneCaller caller(&busy_, kWhat);
    SessionData& data = *this->data();
    StopRecorder(&data);
    const py::gil_scoped_release unlocked;
    data.session.SetYoung(organ, young, seed);
    data.FillCommands();
    data.Refresh();
  }
  std::shared_ptr<SessionData> Copy() {
    const OneCaller caller(&busy_, kWhat);
    const SessionData& data = *this->data();
    const py::gil_scoped_release unlocked;
    return std::make_shared<SessionData>(data);
  }
  void Load(const SessionData& state) {
    const OneCaller caller(&busy_, kWhat);
    SessionData& data = *this->data();
    if (!data.session.Fits(state.session)) {
      FailValue("the state is of another scene; load it into a session of its own scene");
    }
    StopRecorder(&data);
    const py::gil_scoped_release unlocked;
    data.Load(state);
  }
  py::dict Render(int width, int height, bool depth, bool organs) {
    const PictureWish wish = WishOf(width, height, depth, organs);
    const OneCaller caller(&busy_, kWhat);
    const SessionData& data = *this->data();
    SessionPicture picture;
    {
      const py::gil_scoped_release unlocked;
      data.pictures->Draw(data.session, wish, &picture);
    }
    return PictureArrays(wish, picture);
  }

  py::object Tool(const std::string& name) const {
    std::vector<ToolView>& views = session().tools();
    return ToolArray(data(), views.data(), -1, static_cast<py::ssize_t>(views.size()), name);
  }
  py::object Commands() const {
    const auto tools = static_cast<py::ssize_t>(data()->session.tools().size());
    return View(data(), data()->commands.data(), {tools, 5}, {5 * kReal, kReal}, true);
  }
  py::object OrganForces() const {
    std::vector<double>& forces = session().organ_forces();
    const auto organs = static_cast<py::ssize_t>(forces.size() / 3);
    return View(data(), forces.data(), {organs, 3}, {3 * kReal, kReal}, false);
  }
  py::object Organ(std::size_t o, const std::string& name) {
    const OneCaller caller(&busy_, kWhat);
    const SessionModel& model = session().model();
    if (o >= model.organs().size()) FailIndex("there is no such organ");
    const OrganState& state = session().organ(o);
    const auto rows = [&](const Points& points, py::ssize_t count) {
      return View(data(), const_cast<double*>(points.data()), {count, 3}, {3 * kReal, kReal},
                  false);
    };
    if (name == "vertices") return rows(state.vertices, state.vertices.rows());
    if (name == "displacements") return rows(data()->Displacements(o), state.vertices.rows());
    if (name == "control_points") {
      return rows(state.control_displacements, model.organs()[o].control_points());
    }
    if (name == "rest") {
      const Points& rest = model.organs()[o].rest().vertices;
      return Array(Shape{rest.rows(), 3}, rest.data());
    }
    if (name == "triangles") {
      const Triangles& triangles = model.organs()[o].rest().triangles;
      py::array_t<int> copy(Shape{triangles.rows(), 3});
      for (int t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) copy.mutable_at(t, k) = triangles(t, k);
      }
      return copy;
    }
    FailValue("there is no array \"" + name + "\"");
  }
  Array TickForces() {
    const OneCaller caller(&busy_, kWhat);
    const std::vector<double>& forces = session().tick_forces();
    const auto tools = static_cast<py::ssize_t>(session().tools().size());
    const py::ssize_t ticks = tools > 0 ? static_cast<py::ssize_t>(forces.size()) / (3 * tools) : 0;
    return Array(Shape{ticks, tools, 3}, forces.data());
  }
  py::list Events() {
    const OneCaller caller(&busy_, kWhat);
    py::list events;
    for (const SessionEvent& event : session().events()) {
      static constexpr const char* kSeverity[] = {"info", "warning", "error"};
      events.append(py::make_tuple(ToSeconds(event.time_ns),
                                   kSeverity[static_cast<int>(event.severity)], event.name,
                                   event.text));
    }
    session().ClearEvents();
    return events;
  }
  void Exchange(std::size_t instrument, int held) {
    const OneCaller caller(&busy_, kWhat);
    const Scene& scene = session().model().scene();
    if (instrument >= scene.instruments.size()) FailIndex("there is no such instrument");
    const int count = scene.instruments[instrument].HeldCount();
    if (held < 0 || held >= count) {
      FailIndex("instrument " + std::to_string(held) + " of hand \"" +
                scene.instruments[instrument].name + "\": it has " + std::to_string(count));
    }
    session().Exchange(instrument, held);
  }

 private:
  // Ends the record, if there is one. Throws MachineError if its log is not complete.
  void StopRecorder(SessionData* data) {
    if (recorder_ == nullptr) return;
    data->session.RecordTo(nullptr);
    const std::string failure = recorder_->Finish();
    recorder_ = nullptr;
    if (!failure.empty()) throw MachineError(failure);
  }

  static constexpr const char* kWhat = "the session";
  std::shared_ptr<SessionData> data_;
  std::unique_ptr<SessionRecorder> recorder_;
  std::atomic<bool> busy_ = false;
};

class NativeBatch {
 public:
  NativeBatch(std::shared_ptr<const SessionModel> model, const std::vector<std::string>& devices,
              const std::vector<std::uint32_t>& seeds, const std::string& command, int threads) {
    if (seeds.empty()) FailValue("count: give at least 1");
    if (threads < 1 || threads > 1024) FailValue("threads: give 1 to 1024");
    std::vector<DeviceChoice> chosen = DevicesOf(devices, model->scene());
    const CommandKind kind = KindOf(command);
    const py::gil_scoped_release unlocked;
    data_ = std::make_shared<BatchData>(std::move(model), std::move(chosen), seeds, kind, threads);
  }

  const std::shared_ptr<BatchData>& data() const {
    if (data_ == nullptr) FailState("the batch is closed");
    return data_;
  }
  void Close() {
    const std::shared_ptr<BatchData> data = data_;
    if (data == nullptr) return;
    const OneCaller caller(&data->busy, kWhat);
    data_ = nullptr;
  }
  void Step() {
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    const py::gil_scoped_release unlocked;
    data.Step();
  }
  void Reset(const std::vector<int>& which, const std::vector<std::uint32_t>& seeds) {
    BatchData& data = *this->data();
    if (which.size() != seeds.size()) FailValue("give one seed for each session");
    for (const int index : which) Require(index);
    const OneCaller caller(&data.busy, kWhat);
    const py::gil_scoped_release unlocked;
    data.Reset(which, seeds);
  }
  std::shared_ptr<SessionData> Save(int index) {
    Require(index);
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    return std::make_shared<SessionData>(data.at(index));
  }
  void Load(int index, const SessionData& state) {
    Require(index);
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    if (!data.at(index).session.Fits(state.session)) {
      FailValue("the state is of another scene; load it into a batch of its own scene");
    }
    data.Load(index, state);
  }
  py::dict Render(int index, int width, int height, bool depth, bool organs) {
    Require(index);
    const PictureWish wish = WishOf(width, height, depth, organs);
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    SessionPicture picture;
    {
      const py::gil_scoped_release unlocked;
      data.at(index).pictures->Draw(data.at(index).session, wish, &picture);
    }
    return PictureArrays(wish, picture);
  }
  py::object Tool(const std::string& name) const {
    return ToolArray(data(), data()->views.data(), data()->count(),
                     static_cast<py::ssize_t>(data()->tools()), name);
  }
  py::object Commands() const {
    const auto tools = static_cast<py::ssize_t>(data()->tools());
    return View(data(), data()->commands.data(), {data()->count(), tools, 5},
                {5 * tools * kReal, 5 * kReal, kReal}, true);
  }
  py::object OrganForces() const {
    const auto organs = static_cast<py::ssize_t>(data()->organs());
    return View(data(), data()->organ_forces.data(), {data()->count(), organs, 3},
                {3 * organs * kReal, 3 * kReal, kReal}, false);
  }
  py::object Vertices(int index, std::size_t organ) const {
    Require(index);
    if (organ >= data()->organs()) FailIndex("there is no such organ");
    const Points& vertices = data()->at(index).session.organ(organ).vertices;
    return View(data(), const_cast<double*>(vertices.data()), {vertices.rows(), 3},
                {3 * kReal, kReal}, false);
  }
  double Time(int index) const {
    Require(index);
    return ToSeconds(data()->at(index).session.time_ns());
  }

 private:
  void Require(int index) const {
    if (index < 0 || index >= data()->count()) {
      FailIndex("session " + std::to_string(index) + ": the batch has " +
                std::to_string(data()->count()));
    }
  }

  static constexpr const char* kWhat = "the batch";
  std::shared_ptr<BatchData> data_;
};

}  // namespace

void BindSessions(py::module_* module) {
  py::class_<SessionModel, std::shared_ptr<SessionModel>>(*module, "Model")
      .def(py::init([](const Scene& scene) {
        const py::gil_scoped_release unlocked;
        RefuseCuts(scene);
        return std::make_shared<SessionModel>(scene);
      }))
      .def_property_readonly("remarks", &SessionModel::remarks)
      .def("camera", &CameraOf);

  py::class_<SessionData, std::shared_ptr<SessionData>>(*module, "State")
      .def_property_readonly("time",
                             [](const SessionData& d) { return ToSeconds(d.session.time_ns()); });

  py::class_<NativeSession>(*module, "Session")
      .def(py::init([](const std::shared_ptr<SessionModel>& model,
                       const std::vector<std::string>& devices, std::uint32_t seed,
                       const std::string& command) {
        return std::make_unique<NativeSession>(model, devices, seed, command);
      }))
      .def(py::init([](const std::shared_ptr<SessionData>& state) {
        return std::make_unique<NativeSession>(std::make_shared<SessionData>(*state));
      }))
      .def("step", &NativeSession::Step)
      .def("record", &NativeSession::Record)
      .def("end_record", &NativeSession::EndRecord)
      .def("reset", &NativeSession::Reset)
      .def("set_young", &NativeSession::SetYoung)
      .def("save", &NativeSession::Copy)
      .def("load", &NativeSession::Load)
      .def("close", &NativeSession::Close)
      .def("render", &NativeSession::Render)
      .def("tool", &NativeSession::Tool)
      .def("commands", &NativeSession::Commands)
      .def("organ_forces", &NativeSession::OrganForces)
      .def("organ", &NativeSession::Organ)
      .def("tick_forces", &NativeSession::TickForces)
      .def("events", &NativeSession::Events)
      .def("exchange", &NativeSession::Exchange)
      .def("flags", [](const NativeSession& session) { return session.session().record().flags; })
      .def("steps", [](const NativeSession& session) { return session.session().steps(); })
      .def("time",
           [](const NativeSession& session) { return ToSeconds(session.session().time_ns()); });

  py::class_<NativeBatch>(*module, "Batch")
      .def(py::init(
          [](const std::shared_ptr<SessionModel>& model, const std::vector<std::string>& devices,
             const std::vector<std::uint32_t>& seeds, const std::string& command, int threads) {
            return std::make_unique<NativeBatch>(model, devices, seeds, command, threads);
          }))
      .def("step", &NativeBatch::Step)
      .def("reset", &NativeBatch::Reset)
      .def("save", &NativeBatch::Save)
      .def("load", &NativeBatch::Load)
      .def("close", &NativeBatch::Close)
      .def("render", &NativeBatch::Render)
      .def("tool", &NativeBatch::Tool)
      .def("commands", &NativeBatch::Commands)
      .def("organ_forces", &NativeBatch::OrganForces)
      .def("vertices", &NativeBatch::Vertices)
      .def("time", &NativeBatch::Time)
      .def("threads", [](const NativeBatch& batch) { return batch.data()->threads(); });
}

}  // namespace hpdm
