#include "rib/light_scan.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <vector>

namespace kinora::rib {

namespace {

constexpr std::string_view kSource = "LightSource", kLight = "Light", kArchive = "Archive",
                           kInstance = "ObjectInstance", kIf = "IfBegin";
constexpr size_t kLongest = kInstance.size();

bool isNamePart(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

const char* find(const char* from, const char* end, std::string_view what) {
  return static_cast<const char*>(memmem(from, size_t(end - from), what.data(), what.size()));
}

// A request of this very name begins where no name goes on; in binary files its length stands before it.
bool mentionsLight(const char* begin, const char* end) {
  if (find(begin + 1, end, kSource)) return true;
  for (const char* at = begin + 1; (at = find(at, end, kLight)); ++at)
    if (!isNamePart(at[-1])) return true;
  return false;
}

}  // namespace

Mentions mentionsIn(ByteSource& source) {
  constexpr size_t kRead = size_t(1) << 18;
  // the end of what was read before stands in front, so that nothing is cut in two
  std::vector<char> bytes(1 + kLongest + kRead, '\n');
  size_t kept = 1;
  Mentions m;
  while (const size_t n = source.read(bytes.data() + kept, kRead)) {
    const char *const begin = bytes.data(), *const end = begin + kept + n;
    m.lights = m.lights || mentionsLight(begin, end);
    m.archives = m.archives || find(begin, end, kArchive);
    m.objects = m.objects || find(begin, end, kInstance);
    m.conditions = m.conditions || find(begin, end, kIf);
    kept = std::min(kept + n, 1 + kLongest);
    std::memmove(bytes.data(), end - kept, kept);
  }
  return m;
}

}  // namespace kinora::rib
