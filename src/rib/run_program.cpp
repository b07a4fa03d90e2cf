#include "rib/run_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

extern char** environ;

namespace kinora::rib {

namespace {

// Closed when it goes.
struct Descriptor {
  int fd = -1;
  ~Descriptor() { close(); }
  void close() {
    if (fd >= 0) ::close(fd);
    fd = -1;
  }
};

// A pair of ends: of sockets, since writing to a pipe that nobody reads any more would be a signal.
bool makePair(Descriptor& ours, Descriptor& theirs) {
  int fds[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds) != 0) return false;
  ours.fd = fds[0];
  theirs.fd = fds[1];
  return true;
}

}  // namespace

std::optional<std::string> runProgram(const std::vector<std::string>& words, const std::string& request,
                                      const ProgramLimits& limits, std::string& why) {
  Descriptor ours, theirs;
  if (words.empty()) {
    why = "it has no name";
    return std::nullopt;
  }
  if (!makePair(ours, theirs)) {
    why = std::strerror(errno);
    return std::nullopt;
  }
  std::vector<char*> arguments;
  for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, theirs.fd, 0);
  posix_spawn_file_actions_adddup2(&actions, theirs.fd, 1);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  // signals as a fresh program has them
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  // a group of its own: what it starts is ended with it
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, arguments[0], &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  theirs.close();
  if (failed) {
    why = std::strerror(failed);
    return std::nullopt;
  }

  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limits.seconds);
  std::string answer;
  size_t sent = 0;
  if (request.empty()) shutdown(ours.fd, SHUT_WR);
  bool isAnswered = false, isOver = false;
  while (!isAnswered && !isOver && why.empty()) {
    if (std::chrono::steady_clock::now() >= end)
      why = "it takes longer than " + std::to_string(int(limits.seconds)) + " s";
    if (limits.stop && limits.stop->load(std::memory_order_relaxed)) why = "rendering was stopped";
    if (!why.empty()) break;
    pollfd p{ours.fd, short(sent < request.size() ? POLLIN | POLLOUT : POLLIN), 0};
    if (poll(&p, 1, 50) <= 0) continue;
    if (p.revents & POLLOUT && sent < request.size()) {
      const ssize_t n = send(ours.fd, request.data() + sent, request.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n > 0) sent += size_t(n);
      if (n < 0 && errno != EAGAIN && errno != EINTR) sent = request.size();  // it does not listen: it may answer
      if (sent == request.size()) shutdown(ours.fd, SHUT_WR);
    }
    if (!(p.revents & (POLLIN | POLLHUP | POLLERR))) continue;
    char buffer[65536];
    const ssize_t n = recv(ours.fd, buffer, sizeof buffer, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    isOver = n <= 0;
    for (ssize_t i = 0; i < n && !isAnswered; ++i) {
      isAnswered = static_cast<unsigned char>(buffer[i]) == 255;
      if (!isAnswered) answer += buffer[i];
    }
    if (answer.size() > limits.bytes) why = "it prints more than " + std::to_string(limits.bytes >> 20) + " MB";
  }
  if (!why.empty() || isAnswered) kill(-child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!why.empty()) return std::nullopt;
  if (!isAnswered && WIFSIGNALED(status)) why = "it was ended by signal " + std::to_string(WTERMSIG(status));
  if (!isAnswered && answer.empty() && WIFEXITED(status) && WEXITSTATUS(status) != 0)
    why = "it ended with code " + std::to_string(WEXITSTATUS(status));
  if (!why.empty()) return std::nullopt;
  return answer;
}

}  // namespace kinora::rib
