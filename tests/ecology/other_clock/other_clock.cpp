// To be preloaded into a program: its clock of the wall is ahead by the seconds that the file OTHER_CLOCK has, eight
// bytes, at any moment. Steady clocks stay as they are, so that only what looks at the date is changed.
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace {

using Seconds = std::atomic<std::int64_t>;

const Seconds* shared_seconds() {
  static Seconds none{0};
  const char* path = std::getenv("OTHER_CLOCK");
  const int file = path == nullptr ? -1 : ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return &none;
  void* place = ::mmap(nullptr, sizeof(Seconds), PROT_READ, MAP_SHARED, file, 0);
  ::close(file);
  return place == MAP_FAILED ? &none : static_cast<const Seconds*>(place);
}

std::int64_t ahead() {
  static const Seconds* const seconds = shared_seconds();
  return seconds->load();
}

timespec real(clockid_t clock) {
  timespec now{};
  ::syscall(SYS_clock_gettime, clock, &now);
  return now;
}

timespec wall() {
  auto now = real(CLOCK_REALTIME);
  now.tv_sec += ahead();
  return now;
}

bool is_before(const timespec& a, const timespec& b) {
  return a.tv_sec != b.tv_sec ? a.tv_sec < b.tv_sec : a.tv_nsec < b.tv_nsec;
}

/// A condition variable waits by either clock: this tells by which.
bool is_wall(const timespec& time) {
  const auto distance = [&time](const timespec& now) { return std::llabs(time.tv_sec - now.tv_sec); };
  return distance(wall()) < distance(real(CLOCK_MONOTONIC));
}

constexpr long kSlice = 20'000'000;  // nanoseconds: the clock may be set while a thread waits

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  if (clock == CLOCK_REALTIME) return *now = wall(), 0;
  return static_cast<int>(::syscall(SYS_clock_gettime, clock, now));
}

int gettimeofday(timeval* now, void*) noexcept {
  const auto time = wall();
  *now = {time.tv_sec, time.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* now) noexcept {
  const auto seconds = wall().tv_sec;
  if (now != nullptr) *now = seconds;
  return seconds;
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  if (!is_wall(*until)) return ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, until);
  while (is_before(wall(), *until)) {
    auto slice = real(CLOCK_MONOTONIC);
    slice.tv_nsec += kSlice;
    if (slice.tv_nsec >= 1'000'000'000) slice = {slice.tv_sec + 1, slice.tv_nsec - 1'000'000'000};
    const int ended = ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &slice);
    if (ended != ETIMEDOUT) return ended;
  }
  return ETIMEDOUT;
}
}
