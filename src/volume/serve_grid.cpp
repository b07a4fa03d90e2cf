// The other side of read_process.cpp: bounds itself, then reads.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>

#include "image/picture_library.h"
#include "volume/grid_stream.h"
#include "volume/read_process.h"

namespace kinora::volume {

namespace {

void bound(int resource, uint64_t most, uint64_t grace = 0) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0) return;
  const uint64_t highest = now.rlim_max;  // RLIM_INFINITY is the largest number
  now.rlim_cur = std::min<uint64_t>(most, highest);
  now.rlim_max = std::min<uint64_t>(most + grace, highest);
  setrlimit(resource, &now);
}
bool number(const std::string& text, uint64_t& value) {
  char* end = nullptr;
  value = std::strtoull(text.c_str(), &end, 10);
  return !text.empty() && text[0] >= '0' && text[0] <= '9' && end && !*end;
}

}  // namespace

bool sendGrid(const std::string& path, const std::string& which, int descriptor) {
  std::string why;
  if (const auto* const library = image::pictureLibrary<VolumeCalls>(why))
    return library->send(path, which, descriptor);
  const uint32_t head[2] = {uint32_t(GridRecord::Refusal), uint32_t(std::min<size_t>(why.size(), 1000))};
  return write(descriptor, head, sizeof head) == sizeof head && write(descriptor, why.data(), head[1]) == head[1];
}

int serveGrid(const std::vector<std::string>& words) {
  uint64_t bytes = 0, seconds = 0;
  if (words.size() != 4 || !number(words[2], bytes) || !number(words[3], seconds)) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody reads what comes when the renderer is gone
  bound(RLIMIT_CORE, 0);
  bound(RLIMIT_FSIZE, 0);
  bound(RLIMIT_CPU, std::min<uint64_t>(seconds, 1000000), 5);  // at the hard limit the signal would not say why
#if !defined(__SANITIZE_ADDRESS__)                             // it maps terabytes of its own
  constexpr uint64_t kProgram = uint64_t(1) << 30;             // addresses that libraries and stacks take
  bound(RLIMIT_AS, std::min(bytes, uint64_t(1) << 60) + kProgram);
#endif
  // what libraries print must not come between the records
  const int out = fcntl(1, F_DUPFD_CLOEXEC, 3), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (out < 0 || nowhere < 0 || dup2(nowhere, 1) < 0) return 1;
  return sendGrid(words[0], words[1], out) ? 0 : 1;
}

}  // namespace kinora::volume
