#include "volume/read_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "volume/grid_stream.h"

namespace kinora::volume {

namespace {

using Clock = std::chrono::steady_clock;

// A descriptor that is closed.
struct Descriptor {
  int number = -1;
  ~Descriptor() { close(); }
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

// A started process: killed and waited for when it goes.
class Child {
 public:
  // 0 or errno. The child's standard output is `out`; it has no input, its errors go nowhere.
  int start(const std::vector<std::string>& words, int out) {
    std::vector<char*> arguments;
    for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out, 1);
    posix_spawn_file_actions_addopen(&files, 2, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
    // signals as a fresh program has them
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int error = posix_spawn(&id_, arguments[0], &files, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (error) id_ = -1;
    return error;
  }
  ~Child() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  // How it ended by itself, if it does within a second; "" otherwise.
  std::string ending() {
    for (int k = 0; k < 100 && id_ > 0; ++k) {
      int status = 0;
      const pid_t done = ::waitpid(id_, &status, WNOHANG);
      if (done == id_) {
        id_ = -1;
        if (WIFEXITED(status)) return "ended with exit code " + std::to_string(WEXITSTATUS(status));
        const int signal = WTERMSIG(status);
        if (signal == SIGXCPU) return "took too long";
        return "ended with signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
      }
      if (done < 0 && errno != EINTR) break;
      ::usleep(10000);
    }
    return "";
  }

 private:
  pid_t id_ = -1;
};

// Bytes of a pipe until a time.
class PipeReader {
 public:
  PipeReader(int descriptor, Clock::time_point end) : descriptor_(descriptor), end_(end), buffer_(1 << 17) {}
  bool read(void* to, size_t bytes) {
    for (char* at = static_cast<char*>(to); bytes > 0;) {
      if (first_ == last_ && !fill()) return false;
      const size_t n = std::min(bytes, last_ - first_);
      std::memcpy(at, buffer_.data() + first_, n);
      first_ += n, at += n, bytes -= n;
    }
    return true;
  }
  bool isLate() const { return isLate_; }

 private:
  bool fill() {
    for (;;) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end_ - Clock::now()).count();
      if (left <= 0) {
        isLate_ = true;
        return false;
      }
      pollfd asked{descriptor_, POLLIN, 0};
      const int ready = ::poll(&asked, 1, int(std::min<long long>(left, 1000)));
      if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
      const ssize_t n = ready < 0 ? -1 : ::read(descriptor_, buffer_.data(), buffer_.size());
      if (n < 0 && errno == EINTR) continue;
      first_ = 0;
      last_ = n > 0 ? size_t(n) : 0;
      return n > 0;
    }
  }
  int descriptor_;
  Clock::time_point end_;
  std::vector<char> buffer_;
  size_t first_ = 0, last_ = 0;
  bool isLate_ = false;
};

uint64_t physicalMemory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? uint64_t(pages) * uint64_t(size) : uint64_t(4) << 30;
}

}  // namespace

ReaderProgram thisProgram() { return {{"/proc/self/exe", kReadCommand}}; }

std::unique_ptr<VoxelGrid> readGrid(const ReaderProgram& program, const std::string& path, const std::string& which,
                                    std::string& error, std::shared_ptr<VoxelStore> store) {
  if (program.command.empty()) {
    error = "no program that reads it is known";
    return nullptr;
  }
  std::error_code ec;
  const double size = double(std::filesystem::file_size(path, ec)), seconds = program.seconds + size / 20e6;
  if (ec) {
    error = "it cannot be read (" + ec.message() + ")";
    return nullptr;
  }
  // a small file may not fill the machine, however well it is packed
  const bool isBounded = store && store->limit() > 0;
  const uint64_t most = uint64_t(
      std::min({isBounded ? HUGE_VAL : double(Memory::left()), double(physicalMemory()), 0x1p30 + 100 * size}));
  std::vector<std::string> words = program.command;
  words.insert(words.end(), {path, which, std::to_string(most), std::to_string(long(std::min(seconds + 1, 1e6)))});
  Descriptor in, out;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    error = std::string("no pipe to a process that reads it (") + std::strerror(errno) + ")";
    return nullptr;
  }
  in.number = ends[0], out.number = ends[1];
  Child child;
  if (const int failed = child.start(words, out.number)) {
    error = "no process that reads it can be started: " + program.command[0] + ": " + std::strerror(failed);
    return nullptr;
  }
  out.close();
  const VoxelStore::Filling filling(store);
  const auto wait = std::chrono::duration<double>(std::min(2 * seconds, 1e6));
  PipeReader pipe(in.number, Clock::now() + std::chrono::duration_cast<Clock::duration>(wait));
  auto grid =
      receiveGrid([&](void* to, size_t bytes) { return pipe.read(to, bytes); }, most, error, std::move(store));
  if (grid || !error.empty()) return grid;
  if (pipe.isLate()) {
    error = "it was not read within " + std::to_string(long(std::min(2 * seconds, 1e6))) + " seconds";
  } else {
    const std::string how = child.ending();
    error = "it is damaged, or too large: the process that reads it " + (how.empty() ? "gave up" : how);
  }
  return nullptr;
}

}  // namespace kinora::volume
