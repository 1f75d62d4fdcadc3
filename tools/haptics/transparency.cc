#include "tools/haptics/transparency.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include "scenes/generator/meshing/obj_writer.h"
#include "tools/haptics/contact_reference.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Complex = std::complex<double>;

constexpr int kModelDepths = 9;
constexpr double kReferenceSpacing = 0.004;  // m, of the search for the contact
constexpr double kFollowedBy = 1e-3;         // m between two calls of the reference
constexpr double kMotionShare = 0.25;        // amplitude over the reference depth
constexpr double kMovesFrom = 0.004;         // m
constexpr double kMovesWith = 0.02;          // m/s
constexpr double kHandSettles = 0.5;         // s
constexpr double kLeastTime = 0.5;           // s
// Judged where hands move on purpose.
constexpr double kJudgedHertz = 2;
constexpr double kRatioError = 0.1;
constexpr double kPhaseError = 10;  // degrees

// The tip's motion from its rest and the displayed force against it, one value a tick.
struct HandMotion {
  std::vector<double> x;
  std::vector<double> force;
};

// Moves the hand's intent with the amplitude (m) and returns the last `ticks` of its motion.
HandMotion MoveHand(double hertz, double amplitude, double push, int settle, int ticks,
                    ContactLoop* loop, const HandOptions& hand) {
  HandMotion motion;
  const double omega = 2 * std::numbers::pi * hertz;
  for (int i = 0; i < settle + ticks; ++i) {
    const double angle = omega * i * loop->period();
    loop->plant().Push(push + amplitude * (hand.stiffness * std::sin(angle) +
                                           hand.damping * omega * std::cos(angle)));
    loop->Tick();
    if (i < settle) continue;
    motion.x.push_back(loop->plant().x());
    motion.force.push_back(-loop->plant().force());
  }
  return motion;
}

// Fundamental of values at the beginning of each period, less their mean.
Complex FourierFundamental(const std::vector<double>& values, double omega, double period) {
  Complex sum = 0;
  const double mean =
      std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += (values[i] - mean) * std::exp(Complex(0, -omega * period * static_cast<double>(i)));
  }
  return sum / static_cast<double>(values.size());
}

// The factor that holding a value over each period multiplies its fundamental by.
Complex HoldFactor(double omega, double period) {
  const Complex turn(0, omega * period);
  return (1.0 - std::exp(-turn)) / turn;
}

}  // namespace

ModelForce::ModelForce(const ShippedContact& contact, double least, double most)
    : middle_(0.5 * (least + most)), half_(0.5 * (most - least)) {
  ContactReference reference(
      contact.session->organs(),
      {contact.session->DeformationTools()[static_cast<std::size_t>(contact.instrument)]},
      kReferenceSpacing);
  ToolState state;
  state.tool_count = 1;
  const auto solve = [&](double x, double jaw) {
    state.time_ns += 20'000'000;
    state.tools[0].X_WT = contact.kinematics.Forward(JointsAt(contact, x));
    state.tools[0].p_trocar_W = contact.kinematics.p_trocar_W();
    state.tools[0].jaw = jaw;
    return contact.way_W.dot(reference.Solve(state)[0].force_on_tissue_W);
  };
  if (contact.grasps) {
    for (double x = kMovesFrom; x > 0; x -= kFollowedBy) solve(x, 1);
    solve(0, 1);
    solve(0, 0);
  }
  const double jaw = contact.grasps ? 0 : 1;
  for (double x = contact.grasps ? 0 : -kFollowedBy; x < most; x += kFollowedBy) solve(x, jaw);
  for (double x = most; x > least; x -= kFollowedBy) solve(x, jaw);
  Eigen::Matrix<double, kModelDepths, 4> powers;
  Eigen::Matrix<double, kModelDepths, 1> forces;
  for (int i = 0; i < kModelDepths; ++i) {
    const double s = -1 + 2.0 * i / (kModelDepths - 1);
    powers.row(i) << 1, s, s * s, s * s * s;
    forces[i] = solve(middle_ + s * half_, jaw);
  }
  coefficients_ = powers.colPivHouseholderQr().solve(forces);
}

double ModelForce::At(double x) const {
  const double s = (x - middle_) / half_;
  return coefficients_[0] + s * (coefficients_[1] + s * (coefficients_[2] + s * coefficients_[3]));
}

double ModelForce::SlopeAt(double x) const {
  const double s = (x - middle_) / half_;
  return (coefficients_[1] + s * (2 * coefficients_[2] + 3 * s * coefficients_[3])) / half_;
}

namespace {

// The motion's amplitude, m.
double AmplitudeOf(const ShippedContact& contact) { return kMotionShare * contact.depth; }

// Brings the tip to the reference pose and leaves it to the hand. Returns the hand's push there, N.
double HoldContact(const ShippedContact& contact, ContactLoop* loop) {
  if (contact.grasps) {
    loop->plant().SetJaw(1);
    loop->Hold(kMovesFrom - contact.depth, -contact.depth, kMovesWith);
    loop->Rest(0.2);
    loop->plant().SetJaw(0);
    loop->Rest(0.2);
    loop->Hold(-contact.depth, 0, kMovesWith);
  } else {
    loop->Hold(-contact.depth - kMovesFrom, 0, kMovesWith);
  }
  loop->Rest(kHandSettles);
  const double push = -loop->plant().force();
  loop->plant().Push(push);
  loop->plant().Release(0);
  return push;
}

Transparency MeasureUnder(const ShippedContact& contact, const DisplayConditions& display,
                          const ModelForce& model, const std::vector<double>& frequencies) {
  const HandOptions& hand = InstrumentOf(contact).hand;
  ContactLoop loop(contact, display, contact.depth, 1, true);
  const double push = HoldContact(contact, &loop);
  const double intended = AmplitudeOf(contact) * (1 + contact.stiffness / hand.stiffness);
  Transparency result{contact.name, display, model.SlopeAt(contact.depth), {}};
  for (const double hertz : frequencies) {
    const double periods = std::max(1.0, std::ceil(kLeastTime * hertz));
    const int ticks = static_cast<int>(std::lround(periods / hertz / loop.period()));
    const int settle = static_cast<int>(kHandSettles / loop.period());
    // Whole periods: the phase of the settling does not count, since both forces begin with it.
    const HandMotion motion = MoveHand(hertz, intended, push, settle, ticks, &loop, hand);
    std::vector<double> modelled;
    for (const double x : motion.x) modelled.push_back(model.At(contact.depth + x));
    const double omega = 2 * std::numbers::pi * hertz;
    const Complex force =
        HoldFactor(omega, loop.period()) * FourierFundamental(motion.force, omega, loop.period());
    const Complex moved = FourierFundamental(motion.x, omega, loop.period());
    const Complex ratio = force / FourierFundamental(modelled, omega, loop.period());
    result.points.push_back({.hertz = hertz,
                             .amplitude = 2 * std::abs(moved),
                             .rendered = std::abs(force / moved),
                             .ratio = std::abs(ratio),
                             .phase = std::arg(ratio) * 180 / std::numbers::pi});
  }
  return result;
}

}  // namespace

std::vector<Transparency> MeasureTransparency(const ShippedContact& contact,
                                              const std::vector<DisplayConditions>& displays,
                                              const std::vector<double>& frequencies) {
  const double reach = 1.4 * AmplitudeOf(contact);
  const ModelForce model(contact, contact.depth - reach, contact.depth + reach);
  std::vector<Transparency> measured;
  for (const DisplayConditions& display : displays) {
    measured.push_back(MeasureUnder(contact, display, model, frequencies));
  }
  return measured;
}

std::vector<DisplayConditions> TransparencyConditions(const ShippedContact& contact) {
  DisplayConditions shipped{.period = 1.0 / contact.session->scene().timing.haptic_hz,
                            .delay = InstrumentOf(contact).device.delay,
                            .control = InstrumentOf(contact).device.passivity_control};
  DisplayConditions bare = shipped;
  bare.control = bare.guard = false;
  return {shipped, bare};
}

std::vector<double> TransparencyFrequencies(bool quick) {
  return quick ? std::vector{1.0, 10.0} : std::vector{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0};
}

std::vector<ContactTable> TransparencyTables(const std::vector<Transparency>& measured) {
  if (measured.empty()) return {};
  constexpr double kAny = std::numeric_limits<double>::infinity();
  ContactTable ratio{
      "transparency",
      "Rendered over model stiffness: fundamental of the displayed force over that "
      "of the solved organ's force at the tip's own motion.",
      Format("Target: within %.0f %% up to %.0f Hz.", 100 * kRatioError, kJudgedHertz),
      {{"model, N/m", "model_N_per_m", 0}},
      {}};
  ContactTable phase{
      "transparency_phase",
      "Phase of the same, degrees; negative: the force is late.",
      Format("Target: at most %.0f degrees up to %.0f Hz.", kPhaseError, kJudgedHertz),
      {},
      {}};
  for (const TransparencyPoint& point : measured[0].points) {
    ratio.columns.push_back({Format("%g Hz", point.hertz), Format("at_%g_Hz", point.hertz), 3});
    phase.columns.push_back({Format("%g Hz", point.hertz), Format("at_%g_Hz", point.hertz), 1});
  }
  for (const Transparency& each : measured) {
    const std::string name = each.contact + (each.display.control ? "" : ", no controller") +
                             (each.display.guard ? "" : ", no guard limits");
    ContactTable::Row ratios{name, {{each.model, -kAny, kAny}}}, phases{name, {}};
    for (const TransparencyPoint& point : each.points) {
      const bool judged = point.hertz <= kJudgedHertz;
      ratios.values.push_back(
          {point.ratio, judged ? 1 - kRatioError : -kAny, judged ? 1 + kRatioError : kAny});
      phases.values.push_back(
          {point.phase, judged ? -kPhaseError : -kAny, judged ? kPhaseError : kAny});
    }
    ratio.rows.push_back(ratios);
    phase.rows.push_back(phases);
  }
  return {ratio, phase};
}

void WriteTransparencyCsv(const std::vector<Transparency>& measured, const std::string& path) {
  std::string text =
      "contact,rate_hz,delay_s,control,guard,model_N_per_m,frequency_Hz,amplitude_m,"
      "rendered_N_per_m,ratio,phase_degrees\n";
  for (const Transparency& each : measured) {
    for (const TransparencyPoint& point : each.points) {
      text += Format("%s,%.6g,%.6g,%d,%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", each.contact.c_str(),
                     1 / each.display.period, each.display.delay, each.display.control,
                     each.display.guard, each.model, point.hertz, point.amplitude, point.rendered,
                     point.ratio, point.phase);
    }
  }
  WriteTextFile(path, text);
}

}  // namespace hpdm
