#include <dlfcn.h>
#include <gtest/gtest.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>

#include "engine/threads/session_clock.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/haptic_bench.h"

/// Checks that the haptic thread never allocates, locks, calls the system except for the time, or
/// reads the wall clock. Sanitizers do these things themselves: nothing is tested under them.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// A program's own definition of a C function goes before the library's, also for calls from other
// libraries (std::mutex, std::chrono): each counts its calls and passes them on.
namespace {
thread_local long locks = 0;
thread_local long wall_clock_readings = 0;

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
}  // namespace

#define HPDM_COUNT_LOCK(name, parameters, arguments)                 \
  extern "C" int name parameters noexcept {                          \
    static decltype(&name) const next = Next<decltype(name)>(#name); \
    ++locks;                                                         \
    return next arguments;                                           \
  }
HPDM_COUNT_LOCK(pthread_mutex_lock, (pthread_mutex_t * m), (m))
HPDM_COUNT_LOCK(pthread_mutex_trylock, (pthread_mutex_t * m), (m))
HPDM_COUNT_LOCK(pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
HPDM_COUNT_LOCK(pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
HPDM_COUNT_LOCK(pthread_spin_lock, (pthread_spinlock_t * l), (l))
#undef HPDM_COUNT_LOCK

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static decltype(&clock_gettime) const next = Next<decltype(clock_gettime)>("clock_gettime");
  if (clock != CLOCK_MONOTONIC && clock != CLOCK_THREAD_CPUTIME_ID) ++wall_clock_readings;
  return next(clock, time);
}
extern "C" int gettimeofday(timeval* time, void* zone) noexcept {
  static const auto next = Next<int(timeval*, void*)>("gettimeofday");
  ++wall_clock_readings;
  return next(time, zone);
}
extern "C" time_t time(time_t* result) noexcept {
  static const auto next = Next<time_t(time_t*)>("time");
  ++wall_clock_readings;
  return next(result);
}

namespace hpdm {
namespace {

// A session of two tools that press now and then, with a patch every 33 ticks, of both kinds of
// reaction in turn: a second in virtual time, past the ramp-in, then half of one on the real clock.
class Session : public SimulatedSession {
 public:
  Session() { Run(0, 1000); }

  TickCount RunRealClock() {
    constexpr Nanoseconds kStart = 1000 * kPeriod;
    struct SessionsClock : RealLoopClock {
      explicit SessionsClock(Session* s) : RealLoopClock(SessionClock()), session(s) {}
      Nanoseconds Now() noexcept override { return kStart + RealLoopClock::Now(); }
      void SleepUntil(Nanoseconds time) noexcept override {
        if (++sleeps % 33 == 0) session->PublishKind(sleeps / 33 % 2 == 0, time);
        HapticSample sample;
        while (session->samples.Pop(&sample)) {
          session->in_contact += sample.tools[0].kind != ContactKind::kNone;
        }
        RealLoopClock::SleepUntil(time - kStart);
      }
      Session* session;
      std::uint64_t sleeps = 0;
    };
    SessionsClock clock(this);
    return loop->RunRealClock({}, clock, kStart, 500);
  }

  void PublishKind(bool lattice, Nanoseconds now) {
    ContactPatch& patch = patches.Back();
    patch = lattice ? *lattice_patch_ : *paper_patch_;
    patch.step.number = ++step;
    patch.step.device_time_ns = now;
    patches.Publish();
  }

  int in_contact = 0;

 private:
  // On the heap: a patch has three megabytes.
  static std::unique_ptr<const ContactPatch> Patch(ReactionType reaction) {
    auto patch = std::make_unique<ContactPatch>();
    patch->tool_count = kMaxInstruments;
    for (ToolPatches& tool : patch->tools) {
      for (int p = 0; p < kMaxPlaces; ++p) {
        ToolPatch& place = tool.places[static_cast<std::size_t>(p)];
        place = SpherePatch(8, 0.04, 0.1, kStiffness);
        place.organ = p;
        place.reaction = reaction;
        place.compliance_W = Matrix3d::Identity() / kStiffness;
        place.coupling_W = 0.2 * place.compliance_W;
        place.kernel_radius = kTipRadius;
        for (PatchPoint& point : place.points) {
          point.compliance_W = place.compliance_W;
          point.coupling_W = place.coupling_W;
        }
      }
    }
    return patch;
  }
  const std::unique_ptr<const ContactPatch> lattice_patch_ = Patch(ReactionType::kLattice);
  const std::unique_ptr<const ContactPatch> paper_patch_ = Patch(ReactionType::kPaper);
};

TEST(TickPromises, AThousandTicksAllocateNothing) {
  SimulatedSession session;
  session.Run(0, 700);
  session.log.reserve(3000);
  const long before = AllocationsOfThisThread();
  session.Run(700, 1700);
  EXPECT_EQ(AllocationsOfThisThread(), before);
  // A compiler may leave out an allocation that a new-expression makes.
  ::operator delete(::operator new(1));
  EXPECT_GT(AllocationsOfThisThread(), before) << "the counter works";
}

TEST(TickPromises, PausesAndExchangesAllocateNothing) {
  SimulatedSession session;
  session.Run(0, 700);
  session.log.reserve(3000);
  const long before = AllocationsOfThisThread();
  session.instrument_index = 1;
  session.Ask({.paused = false, .instrument_index = {1, 1}});
  session.Run(700, 2000);
  session.Ask({.paused = true, .instrument_index = {1, 1}});
  session.Run(2000, 2100);
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_TRUE(session.log.back().paused);
  EXPECT_EQ(session.log.back().tools[0].instrument_index, 1) << "it was free at some time";
}

TEST(TickPromises, NoTickLocks) {
  Session session;
  const long before = locks;
  session.RunRealClock();
  EXPECT_EQ(locks, before);
  EXPECT_GT(session.in_contact, 0);
  std::mutex mutex;
  { const std::lock_guard lock(mutex); }
  EXPECT_GT(locks, before) << "the counter works, std::mutex included";
}

TEST(TickPromises, StepsOfTheWallClockReachNoTickForNoneLooksAtIt) {
  Session session;
  const long before = wall_clock_readings;
  session.RunRealClock();
  EXPECT_EQ(wall_clock_readings, before);
  std::chrono::system_clock::now();
  EXPECT_GT(wall_clock_readings, before) << "the counter works, std::chrono included";
}

// --- System calls -------------------------------------------------------------------------------

volatile int* refused_call = nullptr;  // shared with the parent

void OnRefusedCall(int, siginfo_t* info, void*) {
  *refused_call = info->si_syscall;
  _exit(1);  // one of the calls that are allowed
}

// Installs a filter: the process may read the monotonic clock and its CPU clock, sleep on the
// former and end. Any other system call or clock ends it. False if the system refuses the filter.
bool AllowOnlyTheClock() {
#if defined(__x86_64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
  constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
  constexpr std::uint32_t kArchitecture = 0;
#endif
  if (kArchitecture == 0) return false;
  struct sigaction action = {};
  action.sa_sigaction = OnRefusedCall;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);

  constexpr std::uint16_t kLoad = BPF_LD | BPF_W | BPF_ABS;
  constexpr std::uint16_t kIfEqual = BPF_JMP | BPF_JEQ | BPF_K;
  constexpr std::uint16_t kReturn = BPF_RET | BPF_K;
  const auto load = [&](std::size_t offset) {
    return sock_filter{kLoad, 0, 0, static_cast<std::uint32_t>(offset)};
  };
  const auto if_equal = [&](std::uint32_t value, std::uint8_t then_skip, std::uint8_t else_skip) {
    return sock_filter{kIfEqual, then_skip, else_skip, value};
  };
  std::array filter = {
      load(offsetof(seccomp_data, arch)),
      if_equal(kArchitecture, 0, 9),
      load(offsetof(seccomp_data, nr)),
      if_equal(SYS_exit_group, 6, 0),
      if_equal(SYS_clock_nanosleep, 1, 0),
      if_equal(SYS_clock_gettime, 0, 5),
      // The low half of the first argument, a clock.
      load(offsetof(seccomp_data, args)),
      if_equal(CLOCK_MONOTONIC, 2, 0),
      if_equal(CLOCK_THREAD_CPUTIME_ID, 1, 0),
      sock_filter{kReturn, 0, 0, SECCOMP_RET_TRAP},
      sock_filter{kReturn, 0, 0, SECCOMP_RET_ALLOW},
      sock_filter{kReturn, 0, 0, SECCOMP_RET_TRAP},
  };
  const sock_fprog program = {static_cast<unsigned short>(filter.size()), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

// Runs `body` in a child process under the filter. Returns the call that ended it, 0 if none did,
// -1 if the system refuses filters.
int RefusedCallOf(void (*body)()) {
  constexpr int kNoFilter = 77;
  void* shared =
      mmap(nullptr, sizeof(int), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  EXPECT_NE(shared, MAP_FAILED);
  refused_call = static_cast<volatile int*>(shared);
  *refused_call = 0;
  const pid_t child = fork();
  if (child == 0) {
    body();
    _exit(0);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  const int call = *refused_call;
  munmap(shared, sizeof(int));
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  if (WEXITSTATUS(status) == kNoFilter) return -1;
  EXPECT_EQ(WEXITSTATUS(status), call == 0 ? 0 : 1);
  return call;
}

TEST(TickPromises, NoTickCallsTheSystemButForTheClock) {
  const int call = RefusedCallOf([] {
    Session session;
    if (!AllowOnlyTheClock()) _exit(77);
    session.RunRealClock();
    _exit(0);  // before anything is freed
  });
  if (call < 0) GTEST_SKIP() << "system call filters are refused here";
  EXPECT_EQ(call, 0) << "the number of the system call that a tick made";
}

TEST(TickPromises, TheFilterOfSystemCallsCatchesOne) {
  const int call = RefusedCallOf([] {
    if (!AllowOnlyTheClock()) _exit(77);
    getppid();
  });
  if (call < 0) GTEST_SKIP() << "system call filters are refused here";
  EXPECT_EQ(call, SYS_getppid);
  const int clock = RefusedCallOf([] {
    if (!AllowOnlyTheClock()) _exit(77);
    timespec time;
    syscall(SYS_clock_gettime, CLOCK_REALTIME, &time);
  });
  EXPECT_EQ(clock, SYS_clock_gettime) << "the wall clock is none of a tick's";
}

}  // namespace
}  // namespace hpdm

#endif
