#include "tools/python/native/session_bindings.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "engine/base/error.h"
#include "scenes/loader/scene.h"
#include "tools/python/native/array_views.h"
#include "tools/python/native/picture_arrays.h"
#include "tools/python/native/python_session.h"
#include "tools/python/native/session_arguments.h"
#include "tools/session/session_recorder.h"

namespace hpdm {
namespace {

namespace py = pybind11;
using Array = py::array_t<double>;

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
  /// Steps without a call between them: what the benchmark compares calls with.
  void Run(int count) {
    const OneCaller caller(&busy_, kWhat);
    SessionData& data = *this->data();
    const py::gil_scoped_release unlocked;
    for (int i = 0; i < count; ++i) data.Step();
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
      return Array(ArrayShape{rest.rows(), 3}, rest.data());
    }
    if (name == "triangles") {
      const Triangles& triangles = model.organs()[o].rest().triangles;
      py::array_t<int> copy(ArrayShape{triangles.rows(), 3});
      for (int t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) copy.mutable_at(t, k) = triangles(t, k);
      }
      return copy;
    }
    FailValue("there is no array \"" + name + "\"");
  }
  py::list Attachments() {
    const OneCaller caller(&busy_, kWhat);
    py::list attachments(session().model().beds().size());
    for (const AttachmentLink& link : session().links()) {
      for (std::size_t l = 0; l < link.joint().layers().size(); ++l) {
        const AttachmentBed& bed = link.joint().layers()[l].bed;
        const AttachmentOutcome& outcome = link.outcomes()[l];
        const std::span<const double> damage = link.state().DamageOf(l);
        py::dict one;
        one["a"] = bed.options.a;
        one["b"] = bed.options.b;
        one["load"] = Array(3, outcome.load_W.data());
        one["damage"] = Array(damage.size(), damage.data());
        one["area"] = Array(bed.areas.size(), bed.areas.data());
        const Points points = PlacesOf(link.joint(), l);
        one["points"] = py::array_t<double>({points.rows(), Eigen::Index{3}}, points.data());
        one["freed_area"] = outcome.freed_area;
        one["burnt_area"] = outcome.burnt_area;
        one["cut_area"] = outcome.cut_area;
        one["dissipated"] = outcome.dissipated;
        attachments[ToSize(bed.index)] = one;
      }
    }
    return attachments;
  }
  // None in a scene without an exercise.
  py::object Exercise() {
    const OneCaller caller(&busy_, kWhat);
    const std::optional<ExerciseEvaluator>& exercise = session().exercise();
    if (!exercise) return py::none();
    const ExerciseResult& result = exercise->result();
    const ExerciseStatus status = exercise->Status();
    py::list errors;
    for (const ExerciseError& error : result.errors) {
      py::dict one;
      one["name"] = exercise->options().errors[ToSize(error.rule)].name;
      one["time"] = error.time;
      one["step"] = error.step;
      one["hand"] = error.hand;
      one["organ"] = error.organ;
      one["duct"] = error.duct;
      one["place"] = Array(3, error.place_W.data());
      one["force"] = error.force;
      errors.append(one);
    }
    py::dict all;
    all["step"] = status.step;
    all["steps"] = exercise->options().steps.size();
    all["progress"] = status.progress;
    all["step_times"] = result.step_times;
    all["errors"] = errors;
    all["time"] = result.time;
    all["score"] = result.score;
    all["ended"] = result.ended;
    all["passed"] = result.passed;
    return all;
  }
  // M x 3, m: the middles of a bed's samples between the two organs now.
  Points PlacesOf(const AttachmentJoint& joint, std::size_t layer) const {
    const AttachmentJoint::Layer& joined = joint.layers()[layer];
    Points places = Points::Zero(joined.bed.size(), 3);
    for (std::size_t side = 0; side < 2; ++side) {
      const auto o = ToSize(joint.members()[ToSize(joined.members[side])].organ);
      const OrganState& organ = session().organ(o);
      const Triangles& triangles = session().model().organs()[o].rest().triangles;
      for (int i = 0; i < joined.bed.size(); ++i) {
        const SurfacePoint& at = joined.bed.surface_points[side][ToSize(i)];
        places.row(i) +=
            0.5 * (at.Position(organ.vertices, triangles) + organ.offset_W).transpose();
      }
    }
    return places;
  }
  Array TickForces() {
    const OneCaller caller(&busy_, kWhat);
    const std::vector<double>& forces = session().tick_forces();
    const auto tools = static_cast<py::ssize_t>(session().tools().size());
    const py::ssize_t ticks = tools > 0 ? static_cast<py::ssize_t>(forces.size()) / (3 * tools) : 0;
    return Array(ArrayShape{ticks, tools, 3}, forces.data());
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
    const InstrumentOptions& hand = Hand(instrument);
    const int count = hand.HeldCount();
    if (held < 0 || held >= count) {
      FailIndex("instrument " + std::to_string(held) + " of hand \"" + hand.name + "\": it has " +
                std::to_string(count));
    }
    session().Exchange(instrument, held);
  }
  void Press(std::size_t instrument, bool pressed) {
    const OneCaller caller(&busy_, kWhat);
    Hand(instrument);
    session().Press(instrument, pressed);
  }

 private:
  // Returns the hand of an instrument's number. Refuses one that the scene has not.
  const InstrumentOptions& Hand(std::size_t instrument) {
    const Scene& scene = session().model().scene();
    if (instrument >= scene.instruments.size()) FailIndex("there is no such instrument");
    return scene.instruments[instrument];
  }
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

  py::class_<SessionData, std::shared_ptr<SessionData>>(
      *module, "State", "The state of a session, from Session.save(). time: its virtual time, s.")
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
      .def("step", &NativeSession::Step,
           "Computes one deformation step and the haptic ticks of its period. Other Python threads "
           "run meanwhile.")
      .def("run", &NativeSession::Run)
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
      .def("attachments", &NativeSession::Attachments)
      .def("exercise", &NativeSession::Exercise)
      .def("tick_forces", &NativeSession::TickForces)
      .def("events", &NativeSession::Events)
      .def("exchange", &NativeSession::Exchange)
      .def("press", &NativeSession::Press)
      .def("flags", [](const NativeSession& session) { return session.session().record().flags; })
      .def("steps", [](const NativeSession& session) { return session.session().steps(); })
      .def("time",
           [](const NativeSession& session) { return ToSeconds(session.session().time_ns()); });
}

}  // namespace hpdm
