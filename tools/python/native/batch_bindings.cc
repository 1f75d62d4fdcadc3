#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "tools/python/native/array_views.h"
#include "tools/python/native/picture_arrays.h"
#include "tools/python/native/python_session.h"
#include "tools/python/native/session_arguments.h"
#include "tools/python/native/session_bindings.h"
#include "tools/python/native/session_calls.h"

namespace hpdm {
namespace {

namespace py = pybind11;

/// A batch as Python holds it. Closing drops the data; arrays keep what they show.
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
  py::object Exercise(int index) const {
    Require(index);
    return ExerciseOf(data()->at(index).session);
  }
  void Exchange(int index, std::size_t hand, int held) {
    Require(index);
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    ExchangeTool(&data.at(index).session, hand, held);
  }
  void Press(int index, std::size_t hand, bool pressed) {
    Require(index);
    BatchData& data = *this->data();
    const OneCaller caller(&data.busy, kWhat);
    PressPedal(&data.at(index).session, hand, pressed);
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

void BindBatches(py::module_* module) {
  py::class_<NativeBatch>(*module, "Batch")
      .def(py::init(
          [](const std::shared_ptr<SessionModel>& model, const std::vector<std::string>& devices,
             const std::vector<std::uint32_t>& seeds, const std::string& command, int threads) {
            return std::make_unique<NativeBatch>(model, devices, seeds, command, threads);
          }))
      .def("step", &NativeBatch::Step,
           "Computes a step of every session. Other Python threads run meanwhile.")
      .def("reset", &NativeBatch::Reset)
      .def("save", &NativeBatch::Save)
      .def("load", &NativeBatch::Load)
      .def("close", &NativeBatch::Close)
      .def("render", &NativeBatch::Render)
      .def("tool", &NativeBatch::Tool)
      .def("commands", &NativeBatch::Commands)
      .def("organ_forces", &NativeBatch::OrganForces)
      .def("vertices", &NativeBatch::Vertices)
      .def("exercise", &NativeBatch::Exercise)
      .def("exchange", &NativeBatch::Exchange)
      .def("press", &NativeBatch::Press)
      .def("time", &NativeBatch::Time)
      .def("threads", [](const NativeBatch& batch) { return batch.data()->threads(); });
}

}  // namespace hpdm
