#include "tools/shared/interrupt.h"

namespace hpdm {
namespace {

constexpr std::array<int, 2> kSignals = {SIGINT, SIGTERM};
volatile sig_atomic_t requested = 0;

void Note(int) { requested = 1; }

}  // namespace

Interrupt::Interrupt() {
  requested = 0;
  struct sigaction once = {};
  once.sa_handler = Note;
  once.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &once, nullptr);
  }
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

bool Interrupt::Requested() const { return requested != 0; }

}  // namespace hpdm
