#include "run_program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace kinora::cli {

Workplace::Workplace() {
  std::string pattern = testing::TempDir() + "kinora_cli_XXXXXX";
  if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  folder_ = pattern;
}
Workplace::~Workplace() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::string Workplace::write(const std::string& name, const std::string& text) const {
  std::ofstream(path(name), std::ios::binary) << text;
  return name;
}
bool Workplace::has(const std::string& name) const { return fs::exists(path(name)); }
std::vector<std::string> Workplace::files() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

namespace {

void limit(int resource, uint64_t bytes) {
  if (!bytes) return;
  const rlimit value{bytes, bytes};
  setrlimit(resource, &value);
}

// Between fork and exec only calls that are safe there.
[[noreturn]] void becomeProgram(const std::string& folder, char* const* arguments, char* const* environment, int in,
                                int out, int err, const RunOptions& options) {
  dup2(in, 0);
  dup2(out, 1);
  dup2(err, 2);
  if (chdir(folder.c_str()) != 0) _exit(126);
  limit(RLIMIT_FSIZE, options.fileSizeLimit);
  limit(RLIMIT_AS, options.addressSpaceLimit);
  limit(RLIMIT_CORE, 1);
  execve(arguments[0], arguments, environment);
  _exit(127);
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& t : texts) list.push_back(t.data());
  list.push_back(nullptr);
  return list;
}

}  // namespace

Result Workplace::run(const std::vector<std::string>& given, const RunOptions& options) const {
  std::vector<std::string> arguments{KINORA_PROGRAM}, environment;
  arguments.insert(arguments.end(), given.begin(), given.end());
  for (char** e = environ; *e; ++e)
    if (!std::string_view(*e).starts_with("KINORA_")) environment.emplace_back(*e);
  environment.insert(environment.end(), options.environment.begin(), options.environment.end());
  auto argumentPointers = pointers(arguments), environmentPointers = pointers(environment);

  std::FILE* input = std::tmpfile();
  std::fwrite(options.input.data(), 1, options.input.size(), input);
  std::rewind(input);
  int outPipe[2], errPipe[2];
  if (pipe2(outPipe, O_CLOEXEC) != 0 || pipe2(errPipe, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0)
    becomeProgram(folder_, argumentPointers.data(), environmentPointers.data(), fileno(input), outPipe[1], errPipe[1],
                  options);
  close(outPipe[1]);
  close(errPipe[1]);

  Result result;
  const auto start = std::chrono::steady_clock::now();
  auto begin = start;
  const auto end = start + std::chrono::seconds(options.timeoutSeconds);
  pollfd polled[2] = {{outPipe[0], POLLIN, 0}, {errPipe[0], POLLIN, 0}};
  bool isTerminated = false;
  while (polled[0].fd >= 0 || polled[1].fd >= 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) {
      result.isTimedOut = true;
      kill(child, SIGKILL);
      break;
    }
    int wait = int(left.count());
    const bool isTiming = !options.fromFirstOutput || !result.out.empty();
    if (!isTiming) begin = std::chrono::steady_clock::now();
    if (options.signalAfterSeconds >= 0 && isTiming && !isTerminated) {
      const double toGo = options.signalAfterSeconds -
                          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      if (toGo <= 0) {
        kill(child, options.signal);
        isTerminated = true;
      } else {
        wait = std::min(wait, int(toGo * 1000) + 1);
      }
    }
    poll(polled, 2, wait);
    for (int i = 0; i < 2; ++i) {
      if (!(polled[i].revents & (POLLIN | POLLHUP))) continue;
      char buffer[65536];
      const ssize_t n = read(polled[i].fd, buffer, sizeof buffer);
      if (n <= 0)
        polled[i].fd = -1;
      else
        (i ? result.err : result.out).append(buffer, size_t(n));
    }
    if (options.terminateWhen && !isTerminated && options.terminateWhen(result.out)) {
      kill(child, options.signal);
      isTerminated = true;
    }
  }
  close(outPipe[0]);
  close(errPipe[0]);
  std::fclose(input);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status)) result.exitCode = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

std::string rib(const SceneParts& p) {
  return p.options + "\n" + p.samples + "\nIntegrator \"PxrPathTracer\" \"integrator\"\n" + p.display + "\n" +
         p.format + "\n" + p.camera + "\nWorldBegin\n" + p.light + "\nAttributeBegin\n" + p.material + "\n" +
         p.geometry + "\nAttributeEnd\nWorldEnd\n";
}

bool areSame(const Workplace& w, const std::string& a, const std::string& b) {
  const Result r = w.run({"diff", a, b});
  EXPECT_EQ(r.exitCode, 0) << a << " " << b << "\n" << r.out << r.err;
  return r.out.find("identical in every bit") != std::string::npos;
}

}  // namespace kinora::cli
