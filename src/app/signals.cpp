#include "app/signals.h"

#include <sys/time.h>

#include <cmath>
#include <csignal>

namespace kinora::app {

namespace {
std::atomic<bool> stop{false}, snapshot{false}, wasAsked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch lock-free atomics only");

void handleStop(int signal) {
  stop = true;
  if (wasAsked.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}
void handleTimer(int) { stop = true; }
void handleSnapshot(int) { snapshot = true; }

void install(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}
}  // namespace

std::atomic<bool>* stopOnSignals() {
  install(SIGINT, &handleStop);
  install(SIGTERM, &handleStop);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  return &stop;
}

std::atomic<bool>* snapshotOnSignal() {
  install(SIGUSR1, &handleSnapshot);
  return &snapshot;
}

void stopAfter(double seconds) {
  install(SIGALRM, &handleTimer);
  itimerval timer{};
  timer.it_value.tv_sec = time_t(std::floor(seconds));
  timer.it_value.tv_usec = suseconds_t((seconds - std::floor(seconds)) * 1e6);
  if (timer.it_value.tv_sec == 0 && timer.it_value.tv_usec == 0) timer.it_value.tv_usec = 1;  // 0 would switch it off
  setitimer(ITIMER_REAL, &timer, nullptr);
}

}  // namespace kinora::app
