#include "base/process_age.h"

#include <time.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace kinora {

double processAge() {
  std::ifstream file("/proc/self/stat");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  // the program's name stands second, in brackets, and may hold anything; the start, in ticks since boot, is the 22nd
  const size_t name = text.rfind(')');
  if (name == std::string::npos) return -1;
  std::istringstream fields(text.substr(name + 1));
  std::string skipped;
  for (int k = 3; k < 22; ++k) fields >> skipped;
  double ticks = 0;
  timespec now{};
  const long perSecond = sysconf(_SC_CLK_TCK);
  if (!(fields >> ticks) || perSecond <= 0 || clock_gettime(CLOCK_BOOTTIME, &now)) return -1;
  const double age = double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - ticks / double(perSecond);
  return age > 0 ? age : 0;
}

}  // namespace kinora
