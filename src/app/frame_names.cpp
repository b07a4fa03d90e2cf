#include "app/frame_names.h"

#include <fmt/format.h>

namespace kinora::app {

bool hasFrameField(const std::string& name) { return name.find('#') != std::string::npos; }

std::string withFrame(const std::string& name, int frame) {
  std::string out;
  for (size_t i = 0; i < name.size();) {
    if (name[i] != '#') {
      out += name[i++];
      continue;
    }
    size_t width = 0;
    while (i < name.size() && name[i] == '#') ++i, ++width;
    out += fmt::format("{:0{}}", frame, width);
  }
  return out;
}

}  // namespace kinora::app
